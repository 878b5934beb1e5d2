//! A folder of numbered PNG or JPEG frames.
//!
//! Files are taken in the order of the numbers in their names; other files, hidden ones and
//! sub-folders are passed over. Numbers may have gaps, as thinned-out footage has: without a
//! timestamps.csv a frame's time is (its number - the first number) / frame rate, so that time
//! passes in a gap as it did in front of the camera.
//!
//! Decoding takes far longer than tracking. A thread of the source's own decodes ahead while the
//! caller works, a few pictures and no more.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::mpsc::{Receiver, SyncSender, sync_channel},
    thread::JoinHandle,
};

use tetrad_core::vision::frame::FrameView;

use super::{
    DEFAULT_FPS, Frame, Gap, Labels, Source, SourceError, SourceInfo,
    frame_number::{frame_number, natural_order},
    picture::Picture,
    timestamps,
};

/// Pictures in circulation: one in the caller's hands, the others decoded or being decoded.
const AHEAD: usize = 3;

/// A step from one frame number to the next above this is no gap in a recording (it would be nine
/// hours at 30 frames a second): such names are times.
const MAX_NUMBER_STEP: u64 = 1_000_000;

/// See the [module's text](self).
pub struct FolderSource {
    info: SourceInfo,
    frames: Vec<(u64, f64)>,
    delivered: usize,
    held: Option<Picture>,
    /// Set after an error: the thread has stopped and there is nothing more to have.
    ended: bool,
    decoder: Decoder,
}

/// One picture file.
struct Entry {
    path: PathBuf,
    stem: String,
    /// Zero for a single picture without one.
    number: u64,
    numbered: bool,
}

impl FolderSource {
    /// Opens a folder: lists it, reads its timestamps.csv if there is one and decodes the first
    /// picture. `fps` is the rate frame numbers stand for where there is no timestamps.csv.
    ///
    /// # Errors
    /// [`SourceError`] naming the folder or the file in it that cannot be used.
    pub fn open(spec: &str, folder: &Path, fps: Option<f64>) -> Result<Self, SourceError> {
        let entries = list(spec, folder)?;
        let stamps =
            timestamps::read(folder, entries.iter().map(|entry| (entry.stem.as_str(), entry.number)))?;
        let nominal_fps = if stamps.is_some() { None } else { Some(fps.unwrap_or(DEFAULT_FPS)) };
        let times = match (stamps, nominal_fps) {
            (Some(times), _) => times,
            (None, fps) => times_by_number(&entries, fps.unwrap_or(DEFAULT_FPS))?,
        };
        let frames = entries.iter().zip(times).map(|(entry, t_s)| (entry.number, t_s)).collect::<Vec<_>>();

        let labels = match nominal_fps {
            _ if entries.iter().any(|entry| !entry.numbered) => Labels::Order,
            Some(_) => Labels::Numbers,
            None => Labels::Times { step_s: median_step(&frames).unwrap_or(1.0 / DEFAULT_FPS) },
        };

        let mut decoder = Decoder::start(entries.into_iter().map(|entry| entry.path).collect());
        let first = decoder.next(folder)?;
        let info = SourceInfo {
            name: spec.to_owned(),
            width: first.width,
            height: first.height,
            format: first.format,
            fps: nominal_fps,
            frames: Some(frames.len() as u64),
            live: false,
            labels,
        };
        decoder.first = Some(first);
        Ok(Self { info, frames, delivered: 0, held: None, ended: false, decoder })
    }
}

impl Source for FolderSource {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        let Some(&(number, t_s)) = self.frames.get(self.delivered).filter(|_| !self.ended) else {
            return Ok(None);
        };
        if let Some(picture) = self.held.take() {
            self.decoder.give_back(picture);
        }
        let folder = Path::new(&self.info.name);
        let size = (self.info.width, self.info.height);
        let picture = self
            .decoder
            .next(folder)
            .and_then(|picture| same_size(picture, size))
            .inspect_err(|_| self.ended = true)?;
        let previous = self.delivered.checked_sub(1).and_then(|index| self.frames.get(index));
        let gap = previous.map_or(Gap::None, |&(before, _)| gap(before, number));
        let index = self.delivered as u64;
        self.delivered += 1;

        let picture = self.held.insert(picture);
        let view = FrameView::packed(&picture.pixels, picture.width, picture.height, picture.format)
            .map_err(|error| SourceError::input(&picture.path, error.to_string()))?;
        Ok(Some(Frame { view, index, number, t_s, gap }))
    }
}

fn same_size(picture: Picture, (width, height): (u16, u16)) -> Result<Picture, SourceError> {
    if (picture.width, picture.height) == (width, height) {
        return Ok(picture);
    }
    Err(SourceError::input(
        &picture.path,
        format!(
            "{} x {} pixels, and the pictures before it have {width} x {height}: all pictures of a folder must have one size",
            picture.width, picture.height
        ),
    ))
}

const fn gap(before: u64, number: u64) -> Gap {
    match number.saturating_sub(before) {
        1 => Gap::None,
        step @ 2..=MAX_NUMBER_STEP => Gap::Missed(step - 1),
        _ => Gap::Unknown,
    }
}

/// The pictures of a folder, in order, with their numbers.
fn list(spec: &str, folder: &Path) -> Result<Vec<Entry>, SourceError> {
    let unreadable = |error: std::io::Error| SourceError::input(folder, format!("cannot be listed: {error}"));
    let mut entries = Vec::new();
    let mut unnumbered = None;
    for item in fs::read_dir(folder).map_err(unreadable)? {
        let path = item.map_err(unreadable)?.path();
        let (Some(stem), Some(extension)) = (
            path.file_stem().and_then(|text| text.to_str()),
            path.extension().and_then(|text| text.to_str()),
        ) else {
            continue;
        };
        let extension = extension.to_ascii_lowercase();
        if !matches!(extension.as_str(), "png" | "jpg" | "jpeg") || stem.starts_with('.') || path.is_dir() {
            continue;
        }
        let number = frame_number(stem).map_err(|digits| {
            SourceError::input(&path, format!("{digits} is too large for a frame number"))
        })?;
        let stem = stem.to_owned();
        if number.is_none() {
            unnumbered = Some(path.clone());
        }
        entries.push(Entry { path, stem, number: number.unwrap_or(0), numbered: number.is_some() });
    }
    if entries.is_empty() {
        return Err(SourceError::argument(
            spec,
            "no PNG or JPEG pictures in this folder: give one with numbered frames (0001.png, 0002.png, ...)",
        ));
    }
    // A single picture needs no number to know its place.
    if let Some(path) = unnumbered.filter(|_| entries.len() > 1) {
        return Err(SourceError::input(
            &path,
            "no frame number in the file name: number it like the others (0001.png), or move it out of the folder",
        ));
    }
    entries.sort_by(|a, b| natural_order(&a.stem, &b.stem).then_with(|| a.path.cmp(&b.path)));
    for (a, b) in entries.iter().zip(entries.iter().skip(1)) {
        if a.number >= b.number {
            return Err(SourceError::input(
                &b.path,
                format!(
                    "frame number {} after number {} of {}: the last digits of the names must count the frames, each once",
                    b.number,
                    a.number,
                    a.path.display()
                ),
            ));
        }
    }
    Ok(entries)
}

fn times_by_number(entries: &[Entry], fps: f64) -> Result<Vec<f64>, SourceError> {
    for (a, b) in entries.iter().zip(entries.iter().skip(1)) {
        if b.number - a.number > MAX_NUMBER_STEP {
            return Err(SourceError::input(
                &b.path,
                format!(
                    "frame number {} after {}: these look like times, not numbers of frames: write them to {} beside the pictures (frame,t with t in seconds)",
                    b.number,
                    a.number,
                    timestamps::FILE_NAME
                ),
            ));
        }
    }
    let first = entries.first().map_or(0, |entry| entry.number);
    Ok(entries.iter().map(|entry| (entry.number - first) as f64 / fps).collect())
}

/// The median time from one frame to the next; `None` of a single one.
fn median_step(frames: &[(u64, f64)]) -> Option<f64> {
    let mut steps: Vec<f64> = frames.iter().zip(frames.iter().skip(1)).map(|(a, b)| b.1 - a.1).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

/// The thread that decodes, and the buffers that go round between it and the source.
struct Decoder {
    /// Decoded while opening, for its size.
    first: Option<Picture>,
    /// `None` only while being dropped.
    empty: Option<SyncSender<Picture>>,
    ready: Receiver<Result<Picture, SourceError>>,
    thread: Option<JoinHandle<()>>,
}

impl Decoder {
    fn start(paths: Vec<PathBuf>) -> Self {
        let (empty, take) = sync_channel::<Picture>(AHEAD);
        let (put, ready) = sync_channel(AHEAD);
        for _ in 0..AHEAD {
            // Cannot fail: there is room for all and the receiver is here.
            let _ = empty.send(Picture::default());
        }
        let thread = std::thread::spawn(move || {
            for path in paths {
                let Ok(mut picture) = take.recv() else { return };
                let result = picture.load(&path).map(|()| picture);
                let failed = result.is_err();
                if put.send(result).is_err() || failed {
                    return;
                }
            }
        });
        Self { first: None, empty: Some(empty), ready, thread: Some(thread) }
    }

    fn next(&mut self, folder: &Path) -> Result<Picture, SourceError> {
        match self.first.take() {
            Some(picture) => Ok(picture),
            None => self.ready.recv().unwrap_or_else(|_| {
                Err(SourceError::input(
                    folder,
                    "the thread that decodes its pictures died: please report this",
                ))
            }),
        }
    }

    fn give_back(&mut self, picture: Picture) {
        if let Some(empty) = &self.empty {
            // Fails only when the thread has decoded everything and needs no more buffers.
            let _ = empty.send(picture);
        }
    }
}

impl Drop for Decoder {
    fn drop(&mut self) {
        // Without its channel the thread ends with the picture it is at.
        self.empty = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
