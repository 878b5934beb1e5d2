//! Where pictures come from: a camera, a folder, a film file or a simulated scene, all behind one
//! trait.
//!
//! [`open`] turns the SRC argument of the command line into a [`Source`]; [`Source::next`] then
//! lends one picture at a time out of the source's own buffer, so nothing is copied on the way to
//! the tracker:
//!
//! ```text
//! SRC -> Spec -> open -> Source -> next -> Frame { view, number, t_s, gap }
//!
//! folder     numbered PNG or JPEG files, decoded one ahead on a thread of their own
//! y4m        a YUV4MPEG2 film, read frame by frame
//! mcap       one camera's pictures out of a recorded session
//! simulated  a rendered scene of tetrad-fixtures
//! v4l2       a Linux camera: mapped driver buffers
//! ```
//!
//! [`open_live`] opens the same for a station, which lives in real time: a simulated scene is played to
//! and fro, a recording once at the pace it was taken at.
//!
//! A source never decides what a bad picture means for the run: it stops with a [`SourceError`]
//! that names the file or device, and [`SourceError::exit`] says which exit code that deserves.
//! Frames delivered before the error stay good.

mod error;
pub mod folder;
mod frame_number;
pub mod live_scene;
pub mod mcap;
mod paced;
pub mod picture;
pub mod simulated;
pub mod simulated_arm;
mod spec;
mod timestamps;
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
pub mod v4l2;
pub mod y4m;

#[cfg(test)]
mod tests;

pub use error::SourceError;
pub use folder::FolderSource;
pub(crate) use frame_number::natural_order;
pub use live_scene::LiveScene;
pub use mcap::McapSource;
pub use paced::Paced;
pub use simulated::SimulatedSource;
pub use spec::Spec;
pub use y4m::Y4mSource;

use tetrad_core::vision::frame::{FrameView, PixelFormat};

/// Frames a second assumed when neither the source nor the user says.
pub const DEFAULT_FPS: f64 = 30.0;

/// The highest frame rate that is believed; above it a figure is a mistake of units.
pub const MAX_FPS: f64 = 10_000.0;

/// Which of two cameras a source stands for. Core knows no left or right: these names belong to
/// the command line, and only a simulated scene needs them, to choose where to render from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// The first camera.
    #[default]
    Left,
    /// The second camera.
    Right,
}

impl View {
    /// The camera's index in a scene.
    #[must_use]
    pub const fn index(self) -> usize {
        match self {
            Self::Left => 0,
            Self::Right => 1,
        }
    }

    /// The name used in files and messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// What the user said beside SRC itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Which camera a simulated scene is rendered from.
    pub view: View,
    /// Frames a second: asked of a camera; for a folder without timestamps.csv and a film without a
    /// rate, the rate its pictures were taken at. `None`: [`DEFAULT_FPS`].
    pub fps: Option<f64>,
    /// Width and height asked of a camera, in pixels. `None`: 640 x 480. Other sources have the
    /// size they have.
    pub size: Option<(u16, u16)>,
    /// How long a simulated scene that is not played in real time goes on, seconds. `None`: as long as it
    /// is.
    pub scene_s: Option<f64>,
}

/// What is known of a source once it is open.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceInfo {
    /// SRC as it was given.
    pub name: String,
    /// Width of every picture, in pixels.
    pub width: u16,
    /// Height of every picture, in pixels.
    pub height: u16,
    /// Format of the first picture. In a folder, pictures with an alpha channel may come between
    /// others: each frame's view knows its own format.
    pub format: PixelFormat,
    /// Nominal frames a second, where there is such a figure.
    pub fps: Option<f64>,
    /// Number of frames, where it is known beforehand.
    pub frames: Option<u64>,
    /// Whether pictures arrive by themselves and are lost when nobody takes them.
    pub live: bool,
    /// What tells which frames of two recordings were taken together.
    pub labels: Labels,
}

/// What a recording knows of its frames beside their order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Labels {
    /// Nothing.
    #[default]
    Order,
    /// The numbers in its file names.
    Numbers,
    /// When each was taken, and the numbers.
    Times {
        /// The median time from one to the next, in seconds.
        step_s: f64,
    },
    /// They were recorded in pairs: the nth of one camera belongs to the nth of the other.
    Pairs,
}

/// What lies between a frame and the one delivered before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gap {
    /// Nothing: the frames follow each other.
    #[default]
    None,
    /// So many frames are missing.
    Missed(u64),
    /// Frames may be missing; the numbering does not tell how many.
    Unknown,
}

/// One picture, lent by its source until the next is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The pixels.
    pub view: FrameView<'a>,
    /// How many frames this source delivered before this one.
    pub index: u64,
    /// What the frame is called in the `frame` column of results: the number in the file name, the
    /// camera's running number, else the index.
    pub number: u64,
    /// When it was taken, in seconds. Recordings and scenes count from their first frame (or as
    /// timestamps.csv says); cameras give the system's monotonic clock, the same for all cameras of
    /// one machine.
    pub t_s: f64,
    /// What is missing before this frame.
    pub gap: Gap,
}

/// A stream of pictures of one size.
pub trait Source: Send {
    /// What is known of the stream.
    fn info(&self) -> &SourceInfo;

    /// The next picture, or `None` after the last one. A live source waits for it, within bounds.
    ///
    /// # Errors
    /// [`SourceError`] when the next picture cannot be had. The stream ends there: a recording
    /// gives `None` from then on, a lost camera the same error again.
    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError>;

    /// The present by the clock of the frames' times, seconds; `None` where they are of no clock that
    /// goes on, as in a recording.
    fn now_s(&self) -> Option<f64> {
        None
    }

    /// What the user should be told about the source and has not been yet: an automatic control
    /// switched off, a frame rate the camera changed. Each is handed out once.
    fn take_notices(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// Opens what `spec` names: `/dev/videoN`, a folder of numbered PNG or JPEG frames, a .y4m or .mcap file
/// or `sim:NAME`.
///
/// # Errors
/// [`SourceError::BadArgument`] when `spec` names nothing this version can read, otherwise what
/// kept the source from opening.
pub fn open(spec: &str, options: &Options) -> Result<Box<dyn Source>, SourceError> {
    check_fps(spec, options)?;
    match Spec::parse(spec)? {
        Spec::Camera(path) => open_camera(spec, &path, options),
        Spec::Folder(path) => Ok(Box::new(FolderSource::open(spec, &path, options.fps)?)),
        Spec::Y4m(path) => Ok(Box::new(Y4mSource::open(spec, &path, options.fps)?)),
        Spec::Mcap(path) => Ok(Box::new(McapSource::open(spec, &path, options.view)?)),
        Spec::Simulated { name, format } => {
            let scene = SimulatedSource::open(spec, &name, options.view, format)?;
            Ok(Box::new(options.scene_s.into_iter().fold(scene, SimulatedSource::lasting)))
        }
    }
}

/// Opens the same for somebody who lives in real time: cameras as they are, a scene as [`LiveScene`],
/// a recording [`Paced`].
///
/// # Errors
/// As [`open`], and for a rate at which no scene is played.
pub fn open_live(spec: &str, options: &Options) -> Result<Box<dyn Source>, SourceError> {
    check_fps(spec, options)?;
    match Spec::parse(spec)? {
        Spec::Camera(path) => open_camera(spec, &path, options),
        Spec::Simulated { name, format } => Ok(Box::new(LiveScene::open(spec, &name, format, options)?)),
        Spec::Folder(_) | Spec::Y4m(_) | Spec::Mcap(_) => Ok(Box::new(Paced::new(open(spec, options)?))),
    }
}

/// What `spec` names, if [`open_live`] could open it as far as that is known beforehand: no device is
/// opened, and whether one is there is not asked.
///
/// # Errors
/// As [`open_live`].
pub fn check_live(spec: &str, options: &Options) -> Result<Spec, SourceError> {
    check_fps(spec, options)?;
    let what = Spec::parse(spec)?;
    if let Spec::Simulated { name, format } = &what {
        LiveScene::find(spec, name, *format, options)?;
    }
    Ok(what)
}

fn check_fps(spec: &str, options: &Options) -> Result<(), SourceError> {
    match options.fps {
        Some(fps) if !(fps > 0.0 && fps <= MAX_FPS) => Err(SourceError::argument(
            spec,
            format!("{fps} frames a second is no frame rate: give one between 0 and {MAX_FPS}"),
        )),
        _ => Ok(()),
    }
}

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
fn open_camera(
    spec: &str,
    path: &std::path::Path,
    options: &Options,
) -> Result<Box<dyn Source>, SourceError> {
    Ok(Box::new(v4l2::CameraSource::open(spec, path, options)?))
}

#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
fn open_camera(
    spec: &str,
    _path: &std::path::Path,
    _options: &Options,
) -> Result<Box<dyn Source>, SourceError> {
    Err(SourceError::argument(
        spec,
        "cameras are read through Video4Linux, on Linux x86-64 and aarch64 only: record to a .y4m file and give that",
    ))
}
