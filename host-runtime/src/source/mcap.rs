//! One camera's pictures out of a recorded session (docs/sessions.md), pixel by pixel as they were
//! captured.
//!
//! `--left session.mcap` is the session's first camera that has pictures, `--right session.mcap` the
//! second. A file that was cut short ends with its last whole picture, or pair of pictures, and a notice
//! says so.

use super::{DEFAULT_FPS, Frame, Gap, Labels, Source, SourceError, SourceInfo, View};
use crate::regular_file;
use crate::session::schema::foxglove::RawImage;
use crate::session::schema::tetrad::Chain;
use crate::session::{Reader, SessionError, Topic, picture_view};
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// What a whole file ends with.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// See the [module's text](self).
pub struct McapSource {
    info: SourceInfo,
    reader: Reader,
    camera: usize,
    image: RawImage,
    delivered: u64,
    /// How many pictures may be delivered, where the file was cut short.
    most: Option<u64>,
    last: Option<u32>,
    notices: Vec<String>,
}

impl McapSource {
    /// Opens the session at `path` for the camera that `view` means.
    ///
    /// # Errors
    /// [`SourceError::Session`] for a file that is no session, [`SourceError::BadArgument`] for one that has
    /// no pictures of that camera.
    pub fn open(spec: &str, path: &Path, view: View) -> Result<Self, SourceError> {
        let reader = Reader::open(path)?;
        let beginning = reader.beginning();
        let with_pictures = beginning.cameras.iter().enumerate();
        let mut with_pictures =
            with_pictures.filter_map(|(at, camera)| Some((at, camera.pictures.as_ref()?)));
        let (camera, pictures) = with_pictures.nth(view.index()).ok_or_else(|| {
            let names: Vec<&str> = beginning
                .cameras
                .iter()
                .filter(|camera| camera.pictures.is_some())
                .map(|camera| camera.name.as_str())
                .collect();
            let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            SourceError::argument(
                spec,
                format!("no pictures of a {} camera are recorded in it, only of: {there}", view.name()),
            )
        })?;
        let labels = match beginning.chain {
            Chain::Pairs => Labels::Pairs,
            Chain::Stations | Chain::Unknown => {
                Labels::Times { step_s: 1.0 / pictures.fps.unwrap_or(DEFAULT_FPS) }
            }
        };
        let info = SourceInfo {
            name: spec.to_owned(),
            width: pictures.size.0,
            height: pictures.size.1,
            format: pictures.format,
            fps: pictures.fps,
            frames: None,
            live: false,
            labels,
        };
        let whole = ends_whole(path).map_err(|cause| SessionError::Read { path: path.to_owned(), cause })?;
        let most = if whole { None } else { Some(count(path, camera, labels == Labels::Pairs)?) };
        let mut notices = Vec::new();
        if let Some(most) = most {
            notices.push(format!("{spec}: cut short, {most} pictures of the camera can be read"));
        }
        let image = RawImage::default();
        Ok(Self { info, reader, camera, image, delivered: 0, most, last: None, notices })
    }

    /// The next picture's time, number and place in the file; the picture itself is in `self.image`.
    fn read(&mut self) -> Result<Option<(u64, u32, u64)>, SessionError> {
        if self.most.is_some_and(|most| self.delivered >= most) {
            return Ok(None);
        }
        while let Some(entry) = self.reader.next_entry()? {
            if entry.topic == Topic::Image(self.camera) {
                self.image = self.reader.decode(&entry)?;
                return Ok(Some((entry.time_us, entry.sequence, entry.at)));
            }
        }
        Ok(None)
    }
}

impl Source for McapSource {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        let Some((time_us, number, at)) = self.read()? else { return Ok(None) };
        let view = picture_view(&self.image).map_err(|reason| SessionError::Damaged {
            path: self.reader.path().to_owned(),
            at,
            reason,
        })?;
        let index = self.delivered;
        self.delivered += 1;
        let skipped = self.last.map_or(0, |last| number.saturating_sub(last).saturating_sub(1));
        self.last = Some(number);
        let gap = if skipped == 0 { Gap::None } else { Gap::Missed(u64::from(skipped)) };
        Ok(Some(Frame { view, index, number: u64::from(number), t_s: time_us as f64 * 1e-6, gap }))
    }

    fn take_notices(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notices)
    }
}

/// Whether the file was finished.
fn ends_whole(path: &Path) -> io::Result<bool> {
    let mut file = regular_file::open(path)?;
    let mut end = [0; MAGIC.len()];
    if file.metadata()?.len() < end.len() as u64 {
        return Ok(false);
    }
    file.seek(SeekFrom::End(-(end.len() as i64)))?;
    file.read_exact(&mut end)?;
    Ok(end == MAGIC)
}

/// How many pictures of the camera are in the file; where they were taken in pairs, of every camera.
fn count(path: &Path, camera: usize, in_pairs: bool) -> Result<u64, SessionError> {
    let mut reader = Reader::open(path)?;
    let cameras: Vec<bool> =
        reader.beginning().cameras.iter().map(|camera| camera.pictures.is_some()).collect();
    let mut counts = vec![0; cameras.len()];
    while let Some(entry) = reader.next_entry()? {
        if let Topic::Image(at) = entry.topic
            && let Some(count) = counts.get_mut(at)
        {
            *count += 1;
        }
    }
    let counted = counts
        .iter()
        .enumerate()
        .zip(cameras)
        .filter(|((at, _), pictures)| *pictures && (in_pairs || *at == camera));
    Ok(counted.map(|((_, count), _)| *count).min().unwrap_or(0))
}
