//! From a started camera to one picture after the other.
//!
//! ```text
//! next: give back the buffer lent before -> wait -> drain to the newest whole picture,
//!       giving the others back at once -> lend it
//! ```
//!
//! The picture lent stays out of the driver's hands until the next call, so nothing writes into it;
//! the driver has the other buffers meanwhile. Older pictures go back before work on the newest
//! begins: a tracker that falls behind loses frames, never time.

use std::{io, time::Duration};

use super::{
    controls::{self, Saved},
    device::{Device, Filled, Wake},
    negotiate::Agreed,
};
use crate::source::{Gap, SourceError};

/// Buffers asked of the driver: one lent, one being filled, two for hiccups.
pub(super) const BUFFERS: u32 = 4;

/// Fewer than this cannot work: one is lent while another is filled.
pub(super) const MIN_BUFFERS: u32 = 2;

/// How long the first picture may take: USB cameras set up their sensor when the stream starts.
const START_TIMEOUT: Duration = Duration::from_secs(5);

/// How long any other picture may take, unless ten frames take longer.
const STALL_TIMEOUT: Duration = Duration::from_secs(2);

/// A greater step of the sequence number is no loss but nonsense (a loss of a thousand seconds).
const MAX_SEQUENCE_STEP: u32 = 1 << 16;

/// A stamp further in the future than this is of another clock. Some drivers reckon the time of
/// exposure from the camera's own clock and are a few milliseconds off, in seconds.
const MAX_AHEAD_S: f64 = 0.5;

/// A first picture older than this was stamped by another clock: the stream has only just begun, in
/// seconds.
const MAX_AGE_S: f64 = 10.0;

/// The step that keeps time increasing when neither clock does, in seconds.
const LEAST_STEP_S: f64 = 1e-6;

/// Pictures that were not lent, by cause, since the camera was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Marked damaged by the driver, or too short.
    pub damaged: u64,
    /// Whole, but a newer one was there already.
    pub overtaken: u64,
}

/// A picture lent to the caller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taken {
    pub(super) buffer: u32,
    pub(super) index: u64,
    pub(super) number: u64,
    pub(super) t_s: f64,
    pub(super) gap: Gap,
}

/// Where times come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Clock {
    /// The driver's stamps.
    Driver,
    /// The moment a picture was taken from the driver.
    Arrival,
}

/// What the last picture was.
#[derive(Clone, Copy)]
struct Last {
    sequence: u32,
    number: u64,
    t_s: f64,
}

/// A running camera.
pub(super) struct Stream<D: Device> {
    device: D,
    name: String,
    agreed: Agreed,
    saved: Saved,
    buffers: u32,
    lent: Option<u32>,
    last: Option<Last>,
    delivered: u64,
    clock: Clock,
    losses: Losses,
    /// Why the camera is lost, once it is.
    lost: Option<String>,
    pub(super) notices: Vec<String>,
}

impl<D: Device> Stream<D> {
    /// Starts capturing. `saved` are the controls to set back at the end, whatever happens here.
    pub(super) fn start(
        device: D,
        name: &str,
        agreed: Agreed,
        saved: Saved,
        notices: Vec<String>,
    ) -> io::Result<Self> {
        let mut stream = Self {
            device,
            name: name.to_owned(),
            agreed,
            saved,
            buffers: 0,
            lent: None,
            last: None,
            delivered: 0,
            clock: Clock::Driver,
            losses: Losses::default(),
            lost: None,
            notices,
        };
        stream.buffers = stream.device.start(BUFFERS)?;
        if stream.buffers < MIN_BUFFERS {
            return Err(io::Error::other(format!("the driver has only {} buffer", stream.buffers)));
        }
        Ok(stream)
    }

    pub(super) const fn losses(&self) -> Losses {
        self.losses
    }

    /// The monotonic clock, which pictures are stamped with, in seconds.
    pub(super) fn now_s(&self) -> f64 {
        self.device.now_s()
    }

    /// The bytes of a buffer that was lent.
    pub(super) fn bytes(&self, buffer: u32) -> &[u8] {
        self.device.bytes(buffer)
    }

    /// Waits for the newest picture.
    pub(super) fn next(&mut self) -> Result<Taken, SourceError> {
        if let Some(reason) = &self.lost {
            return Err(SourceError::DeviceLost { device: self.name.clone(), reason: reason.clone() });
        }
        match self.newest() {
            Ok(Some(filled)) => Ok(self.lend(&filled)),
            Ok(None) => Err(SourceError::DeviceLost {
                device: self.name.clone(),
                reason: self.lost.insert(went_away("it reports an error or was unplugged")).clone(),
            }),
            Err(Trouble::Io(error)) => Err(SourceError::DeviceLost {
                device: self.name.clone(),
                reason: self.lost.insert(went_away(&error.to_string())).clone(),
            }),
            Err(Trouble::Stalled { seconds, damaged }) => {
                Err(SourceError::Stalled { device: self.name.clone(), seconds, damaged })
            }
        }
    }

    /// The newest whole picture; `None` when the device is gone.
    fn newest(&mut self) -> Result<Option<Filled>, Trouble> {
        if let Some(buffer) = self.lent.take() {
            self.device.queue(buffer)?;
        }
        let timeout = self.timeout();
        let began = self.device.now_s();
        let damaged_before = self.losses.damaged;
        loop {
            let left =
                timeout.saturating_sub(Duration::from_secs_f64((self.device.now_s() - began).max(0.0)));
            let wake = if left.is_zero() { Wake::TimedOut } else { self.device.wait(left)? };
            match wake {
                Wake::Gone => return Ok(None),
                Wake::Ready => {
                    if let Some(filled) = self.drain()? {
                        return Ok(Some(filled));
                    }
                }
                Wake::TimedOut => {
                    return Err(Trouble::Stalled {
                        seconds: timeout.as_secs_f64(),
                        damaged: self.losses.damaged - damaged_before,
                    });
                }
            }
        }
    }

    /// Takes all that is filled, keeps the newest whole picture and gives the others back. Bounded:
    /// a driver that fills as fast as we give back must not keep us here.
    fn drain(&mut self) -> io::Result<Option<Filled>> {
        let mut newest: Option<Filled> = None;
        for _ in 0..self.buffers {
            let Some(filled) = self.device.dequeue()? else { break };
            if filled.damaged || filled.bytes < self.picture_bytes() {
                self.losses.damaged += 1;
                self.device.queue(filled.index)?;
            } else if let Some(older) = newest.replace(filled) {
                self.losses.overtaken += 1;
                self.device.queue(older.index)?;
            }
        }
        Ok(newest)
    }

    fn lend(&mut self, filled: &Filled) -> Taken {
        let t_s = self.time(filled);
        let (number, gap) = match self.last {
            None => (0, Gap::None),
            Some(last) => match filled.sequence.wrapping_sub(last.sequence) {
                1 => (last.number + 1, Gap::None),
                step @ 2..=MAX_SEQUENCE_STEP => {
                    (last.number + u64::from(step), Gap::Missed(u64::from(step) - 1))
                }
                // Repeated, or backwards: some drivers do, and it does not mean four billion losses.
                _ => (last.number + 1, Gap::Unknown),
            },
        };
        self.last = Some(Last { sequence: filled.sequence, number, t_s });
        self.lent = Some(filled.index);
        let index = self.delivered;
        self.delivered += 1;
        Taken { buffer: filled.index, index, number, t_s, gap }
    }

    /// The driver's stamp while it can be believed; from its first failure on, the moment of arrival.
    fn time(&mut self, filled: &Filled) -> f64 {
        let now = self.device.now_s();
        if self.clock == Clock::Driver {
            match believable(filled.t_s, self.last, now) {
                Ok(t_s) => return t_s,
                Err(why) => self.notices.push(format!("{why}; frames carry the time they arrived")),
            }
            self.clock = Clock::Arrival;
        }
        self.last.map_or(now, |last| now.max(last.t_s + LEAST_STEP_S))
    }

    /// The least number of bytes of a whole picture: its last row needs no padding.
    fn picture_bytes(&self) -> usize {
        let Agreed { width, height, stride, format, .. } = self.agreed;
        stride * format.rows(usize::from(height)) - (stride - format.row_bytes(usize::from(width)))
    }

    fn timeout(&self) -> Duration {
        if self.last.is_none() {
            return START_TIMEOUT;
        }
        let ten_frames = self.agreed.fps.map_or(0.0, |fps| 10.0 / fps);
        STALL_TIMEOUT.max(Duration::try_from_secs_f64(ten_frames).unwrap_or(STALL_TIMEOUT))
    }
}

impl<D: Device> Drop for Stream<D> {
    fn drop(&mut self) {
        controls::restore(&mut self.device, &self.saved);
    }
}

/// A stamp that is of the monotonic clock, near the present and after the last one; else why not.
fn believable(stamp: Option<f64>, last: Option<Last>, now: f64) -> Result<f64, &'static str> {
    let t_s = stamp.ok_or("the driver does not stamp pictures with the monotonic clock")?;
    // Only the first may be too old: later, an old picture may have waited for a stopped program.
    if t_s > now + MAX_AHEAD_S || (last.is_none() && t_s < now - MAX_AGE_S) {
        return Err("the driver's time stamps are of another clock than it says");
    }
    if last.is_some_and(|last| t_s <= last.t_s) {
        return Err("the driver's time stamps do not increase");
    }
    Ok(t_s)
}

fn went_away(how: &str) -> String {
    format!("the camera went away ({how}): check its cable, plug it in and start again")
}

/// Why there is no picture.
enum Trouble {
    Io(io::Error),
    Stalled { seconds: f64, damaged: u64 },
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}
