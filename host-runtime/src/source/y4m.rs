//! A YUV4MPEG2 film (.y4m): `ffmpeg -i film.mp4 -pix_fmt yuv420p film.y4m` makes one of anything.
//!
//! Frames are read one at a time, so a film may be longer than memory. The planes of a frame become
//! one of the packed formats core reads: 4:2:0 becomes NV12, 4:2:2 YUYV, 4:4:4 RGB.
//!
//! The parser is our own: the format is a page long, and the `y4m` crate takes a film cut off in the
//! middle of a frame for one that has ended, multiplies the header's sizes without looking for
//! overflow, and tells neither interlaced films nor the byte where it stopped.

use std::{
    fs::File,
    io::{BufReader, ErrorKind, Read},
    path::{Path, PathBuf},
};

use tetrad_core::vision::frame::FrameView;

use super::{DEFAULT_FPS, Frame, Gap, Labels, Source, SourceError, SourceInfo};

mod convert;
mod header;

use convert::Repack;
use header::Header;

/// The longest stream or frame header that is read, in bytes: theirs have some 60.
const MAX_HEADER_BYTES: usize = 1024;

const FRAME_MARK: &[u8] = b"FRAME";

/// See the [module's text](self).
pub struct Y4mSource {
    info: SourceInfo,
    path: PathBuf,
    file: BufReader<File>,
    /// Bytes read so far, for messages.
    offset: u64,
    seconds_per_frame: f64,
    planes: Vec<u8>,
    picture: Vec<u8>,
    repack: Repack,
    next_index: u64,
    ended: bool,
}

impl Y4mSource {
    /// Opens a film and reads its header. `fps` is used when the film does not say its rate.
    ///
    /// # Errors
    /// [`SourceError::BadInput`] naming the file, the byte, and what a film must be like.
    pub fn open(spec: &str, path: &Path, fps: Option<f64>) -> Result<Self, SourceError> {
        let unreadable = |error| SourceError::input(path, format!("cannot be read: {error}"));
        let file = File::open(path).map_err(unreadable)?;
        let bytes = file.metadata().map_err(unreadable)?.len();
        let mut file = BufReader::new(file);
        let line = read_line(&mut file).map_err(unreadable)?;
        let header = match &line {
            Line::Complete(text) => Header::parse(text),
            Line::Cut(_) | Line::End => {
                Err("the file ends within its header: it is no YUV4MPEG2 film, or an empty one".to_owned())
            }
            Line::TooLong => Err("does not begin with a YUV4MPEG2 header".to_owned()),
        }
        .map_err(|reason| SourceError::input(path, reason))?;
        let offset = line.bytes() as u64;

        let repack = Repack::new(&header);
        let fps = header.fps.or(fps).unwrap_or(DEFAULT_FPS);
        let info = SourceInfo {
            name: spec.to_owned(),
            width: header.width,
            height: header.height,
            format: repack.format(),
            fps: Some(fps),
            frames: whole_frames(bytes.saturating_sub(offset), repack.plane_bytes()),
            live: false,
            labels: Labels::Order,
        };
        Ok(Self {
            info,
            path: path.to_owned(),
            file,
            offset,
            seconds_per_frame: 1.0 / fps,
            planes: vec![0; repack.plane_bytes()],
            picture: vec![0; repack.picture_bytes()],
            repack,
            next_index: 0,
            ended: false,
        })
    }

    /// Reads one frame into `planes`; false at the end of the film.
    fn read_frame(&mut self) -> Result<bool, SourceError> {
        let (number, start) = (self.next_index, self.offset);
        let fail = |path: &Path, what: String| {
            SourceError::input(path, format!("frame {number} (at byte {start}): {what}"))
        };
        let line = read_line(&mut self.file).map_err(|error| fail(&self.path, error.to_string()))?;
        match &line {
            Line::End => return Ok(false),
            Line::Complete(text) if is_frame_header(text) => {}
            Line::Cut(text) if FRAME_MARK.starts_with(text) || is_frame_header(text) => {
                return Err(fail(&self.path, "the film ends within the frame's header".to_owned()));
            }
            _ => {
                return Err(fail(
                    &self.path,
                    "no frame begins here: the film is damaged, or its header gives the wrong size"
                        .to_owned(),
                ));
            }
        }
        let read = read_full(&mut self.file, &mut self.planes)
            .map_err(|error| fail(&self.path, error.to_string()))?;
        self.offset += (line.bytes() + read) as u64;
        if read < self.planes.len() {
            return Err(fail(
                &self.path,
                format!(
                    "the film is cut off: {read} of the frame's {} bytes are there; the frames before it are whole",
                    self.planes.len()
                ),
            ));
        }
        Ok(true)
    }
}

impl Source for Y4mSource {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        if self.ended {
            return Ok(None);
        }
        // Set first, so that it holds on every way out but the good one.
        self.ended = true;
        if !self.read_frame()? {
            return Ok(None);
        }
        self.ended = false;
        self.repack.run(&mut self.planes, &mut self.picture);
        let index = self.next_index;
        self.next_index += 1;
        let view = FrameView::packed(&self.picture, self.info.width, self.info.height, self.info.format)
            .map_err(|error| SourceError::input(&self.path, error.to_string()))?;
        let t_s = index as f64 * self.seconds_per_frame;
        Ok(Some(Frame { view, index, number: index, t_s, gap: Gap::None }))
    }
}

/// `FRAME`, alone or with parameters of its own, which may say nothing we need.
fn is_frame_header(line: &[u8]) -> bool {
    line.strip_prefix(FRAME_MARK).is_some_and(|rest| rest.is_empty() || rest.starts_with(b" "))
}

/// Frames in `bytes` when their headers carry no parameters, as nearly always; `None` when that does
/// not come out even.
fn whole_frames(bytes: u64, plane_bytes: usize) -> Option<u64> {
    let each = plane_bytes as u64 + FRAME_MARK.len() as u64 + 1;
    bytes.is_multiple_of(each).then_some(bytes / each)
}

/// A header line without its newline.
enum Line {
    Complete(Vec<u8>),
    /// The file ends before the newline.
    Cut(Vec<u8>),
    TooLong,
    /// The file ends here.
    End,
}

impl Line {
    /// Bytes taken from the file.
    fn bytes(&self) -> usize {
        match self {
            Self::Complete(text) => text.len() + 1,
            Self::Cut(text) => text.len(),
            Self::TooLong => MAX_HEADER_BYTES,
            Self::End => 0,
        }
    }
}

fn read_line(file: &mut impl Read) -> std::io::Result<Line> {
    let mut text = Vec::new();
    let mut byte = [0];
    while text.len() < MAX_HEADER_BYTES {
        if read_full(file, &mut byte)? == 0 {
            return Ok(if text.is_empty() { Line::End } else { Line::Cut(text) });
        }
        if byte == *b"\n" {
            return Ok(Line::Complete(text));
        }
        text.extend(byte);
    }
    Ok(Line::TooLong)
}

/// Fills `buffer` as far as the file goes and tells how far that was.
fn read_full(file: &mut impl Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match file.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}
