//! A rendered scene of `tetrad-fixtures`: `sim:demo`, seen by the left or the right camera.
//!
//! The same scene gives the same pictures on every machine, so whatever is tracked in it can be
//! compared with the truth to the bit.

use std::cmp::Reverse;

use tetrad_core::vision::frame::{FrameError, FrameView, PixelFormat};
use tetrad_fixtures::{Scene, to_format};

use super::{Frame, Gap, Labels, Source, SourceError, SourceInfo, View};

/// How many scene names a message lists.
const LISTED: usize = 12;

/// See the [module's text](self).
pub struct SimulatedSource {
    info: SourceInfo,
    scene: Scene,
    camera: usize,
    rgb: Vec<u8>,
    /// The picture in the format asked for, when that is not RGB.
    converted: Vec<u8>,
    next_frame: usize,
}

impl SimulatedSource {
    /// Sets up the scene `name` as `view` sees it, its pictures in `format`.
    ///
    /// # Errors
    /// [`SourceError::BadArgument`] for a name no scene has, with those there are, for a scene that
    /// this camera does not see, and for a format its size does not allow.
    pub fn open(spec: &str, name: &str, view: View, format: PixelFormat) -> Result<Self, SourceError> {
        let scene = find(spec, name, view, format)?;
        let camera = view.index();
        let info = SourceInfo {
            name: spec.to_owned(),
            width: scene.width,
            height: scene.height,
            format,
            fps: Some(scene.fps),
            frames: Some(scene.frames() as u64),
            live: false,
            labels: Labels::Order,
        };
        Ok(Self { info, scene, camera, rgb: Vec::new(), converted: Vec::new(), next_frame: 0 })
    }

    /// The same scene for so many seconds: its movements go on for as long as anybody looks.
    #[must_use]
    pub fn lasting(mut self, seconds: f64) -> Self {
        self.scene.frames = ((seconds * self.scene.fps).ceil() as usize).max(1);
        self.info.frames = Some(self.scene.frames as u64);
        self
    }
}

impl Source for SimulatedSource {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        let frame = self.next_frame;
        if frame >= self.scene.frames() {
            return Ok(None);
        }
        self.next_frame += 1;
        self.scene.render_rgb(frame, self.camera, &mut self.rgb);
        let SourceInfo { width, height, format, .. } = self.info;
        let pixels = if format == PixelFormat::Rgb888 {
            &self.rgb
        } else {
            self.converted = to_format(&self.rgb, width, height, format);
            &self.converted
        };
        let view = FrameView::packed(pixels, width, height, format)
            .map_err(|error| SourceError::argument(&self.info.name, error.to_string()))?;
        let index = frame as u64;
        Ok(Some(Frame { view, index, number: index, t_s: self.scene.time_s(frame), gap: Gap::None }))
    }
}

/// The scene `name`, if `view` sees it and its pictures can be had in `format`.
pub(super) fn find(spec: &str, name: &str, view: View, format: PixelFormat) -> Result<Scene, SourceError> {
    let scene = Scene::named(name).ok_or_else(|| SourceError::argument(spec, unknown(name)))?;
    if view.index() >= scene.cameras() {
        return Err(SourceError::argument(
            spec,
            format!("this scene has no {} camera, only {}", view.name(), scene.cameras()),
        ));
    }
    check_sides(format, scene.width, scene.height)
        .map_err(|error| SourceError::argument(spec, error.to_string()))?;
    Ok(scene)
}

/// Whether a picture of this size can be had in this format: rendering takes it for granted.
fn check_sides(format: PixelFormat, width: u16, height: u16) -> Result<(), FrameError> {
    match FrameView::packed(&[], width, height, format) {
        // Of course it has no pixels yet.
        Ok(_) | Err(FrameError::WrongLength { .. }) => Ok(()),
        Err(error) => Err(error),
    }
}

/// Names the scenes there are, those most like `name` first.
fn unknown(name: &str) -> String {
    let mut known: Vec<String> = Scene::names().into_iter().map(|(known, _)| known).collect();
    // Stable: scenes equally alike stay in their own order.
    known.sort_by_key(|known| Reverse(alike(known, name)));
    let rest = known.len().saturating_sub(LISTED);
    let more = if rest == 0 {
        String::new()
    } else {
        format!(" and {rest} more, with other sizes, speeds and rates")
    };
    known.truncate(LISTED);
    format!("no scene is called '{name}': there are {}{more}", known.join(", "))
}

/// The length of the common beginning.
fn alike(a: &str, b: &str) -> usize {
    a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count()
}
