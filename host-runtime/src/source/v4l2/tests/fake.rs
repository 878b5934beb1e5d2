//! A camera in memory that follows the driver's rules about buffers and keeps a record.

use std::{
    collections::{BTreeMap, VecDeque},
    io,
    sync::{Arc, Mutex, MutexGuard},
    time::Duration,
};

use crate::source::v4l2::device::{ControlInfo, Device, Filled, FourCc, FrameSize, Identity, Picture, Wake};

/// Something the camera does at a time of its own.
#[derive(Clone, Debug)]
pub(super) enum Arrival {
    /// A picture, filled with this value.
    Picture { value: u8, sequence: u32, damaged: bool, short: bool },
    /// The cable is pulled: waiting reports it.
    Unplugged,
    /// Waiting sees a picture and taking it fails.
    Fails(i32),
}

impl Arrival {
    pub(super) fn picture(value: u8, sequence: u32) -> Self {
        Self::Picture { value, sequence, damaged: false, short: false }
    }
}

/// What the camera is and what has been done to it.
pub(super) struct State {
    pub(super) identity: Identity,
    /// Formats and, for each, the sizes it comes in; the nearest is granted.
    pub(super) formats: Vec<(FourCc, Vec<(u32, u32)>)>,
    pub(super) granted: Option<Picture>,
    /// What a format turns into when it is set, whatever was tried.
    pub(super) forced_fourcc: Option<FourCc>,
    pub(super) interlaced: bool,
    pub(super) other_yuv: bool,
    /// Bytes of padding in a row.
    pub(super) padding: u32,
    pub(super) rate: Option<f64>,
    pub(super) controls: BTreeMap<u32, (bool, i32)>,
    /// Controls that keep their value, and those that refuse to be set.
    pub(super) stubborn: Vec<u32>,
    pub(super) refusing: Vec<u32>,
    pub(super) control_writes: Vec<(u32, i32)>,
    pub(super) fail_format: Option<i32>,
    pub(super) fail_start: Option<i32>,
    pub(super) buffer_count: u32,
    /// What arrives at each wait: all of one entry at once.
    pub(super) script: VecDeque<Vec<Arrival>>,
    /// Whether pictures carry the driver's time.
    pub(super) stamps: bool,
    /// Added to the driver's time of the next picture.
    pub(super) stamp_off_s: f64,
    pub(super) now_s: f64,
    queued: VecDeque<u32>,
    /// Filled buffers with the value they hold, or what taking one fails with.
    filled: VecDeque<Result<(Filled, u8), i32>>,
    pub(super) streaming: bool,
}

/// A handle to a camera. A clone looks at the same state; the pictures are with the one that took
/// them.
#[derive(Clone)]
pub(super) struct Fake {
    state: Arc<Mutex<State>>,
    pictures: Vec<Vec<u8>>,
}

/// Distance between two waits that bring something.
pub(super) const PERIOD_S: f64 = 1.0 / 32.0;

impl Fake {
    /// A camera with YUYV at 640 x 480, 30 frames a second and no controls.
    pub(super) fn new(script: Vec<Vec<Arrival>>) -> Self {
        let state = State {
            identity: Identity {
                card: "Memory Cam".to_owned(),
                driver: "fake".to_owned(),
                bus: "memory-1".to_owned(),
                captures: true,
                multi_planar: false,
            },
            formats: vec![(FourCc(*b"YUYV"), vec![(640, 480)])],
            granted: None,
            forced_fourcc: None,
            interlaced: false,
            other_yuv: false,
            padding: 0,
            rate: Some(30.0),
            controls: BTreeMap::new(),
            stubborn: Vec::new(),
            refusing: Vec::new(),
            control_writes: Vec::new(),
            fail_format: None,
            fail_start: None,
            buffer_count: 4,
            script: script.into(),
            stamps: true,
            stamp_off_s: 0.0,
            now_s: 1000.0,
            queued: VecDeque::new(),
            filled: VecDeque::new(),
            streaming: false,
        };
        Self { state: Arc::new(Mutex::new(state)), pictures: Vec::new() }
    }

    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap()
    }

    /// Which of the buffers belong to the driver now.
    pub(super) fn queued(&self) -> usize {
        self.state().queued.len()
    }
}

fn os_error(code: i32) -> io::Error {
    io::Error::from_raw_os_error(code)
}

impl State {
    fn grant(&self, wish: &Picture) -> Picture {
        let (fourcc, sizes) =
            self.formats.iter().find(|(fourcc, _)| *fourcc == wish.fourcc).unwrap_or(&self.formats[0]);
        let distance = |size: &&(u32, u32)| size.0.abs_diff(wish.width) + size.1.abs_diff(wish.height);
        let (width, height) = *sizes.iter().min_by_key(distance).unwrap();
        Picture {
            fourcc: *fourcc,
            width,
            height,
            stride: width * 2 + self.padding,
            interlaced: self.interlaced,
            other_yuv: self.other_yuv,
        }
    }

    /// Lets the next entry of the script happen; pictures without a buffer to go to are lost.
    fn happen(&mut self, arrivals: Vec<Arrival>) -> bool {
        self.now_s += PERIOD_S;
        for arrival in arrivals {
            match arrival {
                Arrival::Unplugged => return false,
                Arrival::Fails(code) => self.filled.push_back(Err(code)),
                Arrival::Picture { value, sequence, damaged, short } => {
                    let Some(index) = self.queued.pop_front() else { continue };
                    let t_s = self.stamps.then_some(self.now_s - 0.001 + self.stamp_off_s);
                    self.stamp_off_s = 0.0;
                    let whole = self.granted.map_or(0, |picture| picture.stride * picture.height) as usize;
                    let bytes = if short { whole / 2 } else { whole };
                    self.filled.push_back(Ok((Filled { index, bytes, damaged, sequence, t_s }, value)));
                }
            }
        }
        true
    }
}

impl Device for Fake {
    fn identity(&mut self) -> io::Result<Identity> {
        Ok(self.state().identity.clone())
    }

    fn formats(&mut self) -> io::Result<Vec<FourCc>> {
        Ok(self.state().formats.iter().map(|(fourcc, _)| *fourcc).collect())
    }

    fn sizes(&mut self, fourcc: FourCc) -> io::Result<Vec<FrameSize>> {
        let state = self.state();
        let (_, sizes) = state.formats.iter().find(|(known, _)| *known == fourcc).unwrap();
        Ok(sizes.iter().map(|&(width, height)| FrameSize::Exact(width, height)).collect())
    }

    fn try_format(&mut self, wish: &Picture) -> io::Result<Picture> {
        Ok(self.state().grant(wish))
    }

    fn set_format(&mut self, wish: &Picture) -> io::Result<Picture> {
        let mut state = self.state();
        if let Some(code) = state.fail_format {
            return Err(os_error(code));
        }
        let mut granted = state.grant(wish);
        granted.fourcc = state.forced_fourcc.unwrap_or(granted.fourcc);
        state.granted = Some(granted);
        Ok(granted)
    }

    fn set_rate(&mut self, _fps: f64) -> io::Result<Option<f64>> {
        Ok(self.state().rate)
    }

    fn control_info(&mut self, id: u32) -> io::Result<Option<ControlInfo>> {
        Ok(self.state().controls.get(&id).map(|(settable, _)| ControlInfo { settable: *settable }))
    }

    fn control(&mut self, id: u32) -> io::Result<i32> {
        Ok(self.state().controls[&id].1)
    }

    fn set_control(&mut self, id: u32, value: i32) -> io::Result<()> {
        let mut state = self.state();
        if state.refusing.contains(&id) {
            return Err(os_error(libc::EBUSY));
        }
        state.control_writes.push((id, value));
        if !state.stubborn.contains(&id) {
            state.controls.get_mut(&id).unwrap().1 = value;
        }
        Ok(())
    }

    fn start(&mut self, count: u32) -> io::Result<u32> {
        let mut state = self.state();
        if let Some(code) = state.fail_start {
            return Err(os_error(code));
        }
        let count = count.min(state.buffer_count);
        state.queued = (0..count).collect();
        state.streaming = true;
        // A page more than a picture, as real buffers have.
        let bytes = state.granted.map_or(0, |picture| picture.stride * picture.height) as usize + 4096;
        drop(state);
        self.pictures = vec![vec![0; bytes]; count as usize];
        Ok(count)
    }

    fn wait(&mut self, timeout: Duration) -> io::Result<Wake> {
        let mut state = self.state();
        if !state.filled.is_empty() {
            return Ok(Wake::Ready);
        }
        match state.script.pop_front() {
            Some(arrivals) => Ok(if state.happen(arrivals) { Wake::Ready } else { Wake::Gone }),
            None => {
                state.now_s += timeout.as_secs_f64();
                Ok(Wake::TimedOut)
            }
        }
    }

    fn dequeue(&mut self) -> io::Result<Option<Filled>> {
        let taken = self.state().filled.pop_front().transpose().map_err(os_error)?;
        Ok(taken.map(|(filled, value)| {
            let bytes = &mut self.pictures[filled.index as usize];
            bytes.chunks_exact_mut(2).for_each(|pair| pair.copy_from_slice(&[value, 128]));
            filled
        }))
    }

    fn queue(&mut self, index: u32) -> io::Result<()> {
        let mut state = self.state();
        if state.queued.contains(&index) || index as usize >= self.pictures.len() {
            // What a driver says to a buffer it has already: the bug other crates have.
            return Err(os_error(libc::EINVAL));
        }
        state.queued.push_back(index);
        Ok(())
    }

    fn bytes(&self, index: u32) -> &[u8] {
        if self.state().queued.contains(&index) { &[] } else { &self.pictures[index as usize] }
    }

    fn now_s(&self) -> f64 {
        self.state().now_s
    }
}
