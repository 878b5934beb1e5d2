//! One scene, tracked in several ways beside its truth.
//!
//! A frame is rendered once and every [`Variant`] tracks it: the modes are compared on the very same
//! pictures, and rendering, which takes far longer than tracking, is paid once.

use super::sensor::Sensor;
use crate::learning::{self, Refused};
use crate::pipeline::{CameraStart, Pipeline, Step};
use crate::settings::Mode;
use std::time::Duration;
use tetrad_core::config::LearnConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::{AffineRefusal, Arms};
use tetrad_core::observation::BALLS;
use tetrad_core::vision::frame::{FrameError, FrameView, PixelFormat};
use tetrad_core::vision::tracker::TrackerError;
use tetrad_fixtures::{BallTruth, HandTruth, Scene, to_format};

/// Both modes, in the order of the tables.
pub const MODES: [Mode; 2] = [Mode::Paper, Mode::Refined];

/// One way to track a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// `paper` or `refined`.
    pub mode: Mode,
    /// What the cameras send.
    pub format: PixelFormat,
    /// How many of the scene's cameras are used, the first ones.
    pub cameras: usize,
    /// The nominal focal length given to the hand, as a share of the true one.
    pub focal_share: f64,
}

impl Variant {
    /// A mode with RGB pictures, both cameras and the right focal length.
    #[must_use]
    pub const fn of(mode: Mode) -> Self {
        Self { mode, format: PixelFormat::Rgb888, cameras: 2, focal_share: 1.0 }
    }
}

/// A frame of a scene with its truth and what each variant made of it.
#[derive(Debug)]
pub struct Seen<'a> {
    /// The number of the frame.
    pub frame: usize,
    /// The middle of its exposure, seconds.
    pub t_s: f64,
    /// The balls in the picture of each camera.
    pub balls: &'a [[BallTruth; BALLS]],
    /// The hand.
    pub hand: &'a HandTruth,
    /// How long rendering the cameras' pictures took, all together.
    pub rendering: Duration,
    /// What the variants say, in their order.
    pub steps: &'a [Step],
}

/// Why a scene cannot be tracked.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// Nothing can be learnt from its first picture.
    #[error("the scene {scene}: nothing learnt from the first picture of camera {camera} in {format:?}")]
    Learn {
        /// The scene's name.
        scene: String,
        /// The camera's place in the scene.
        camera: usize,
        /// What the camera sends.
        format: PixelFormat,
        /// The balls and the reasons.
        #[source]
        cause: Refused,
    },
    /// What was learnt cannot be tracked.
    #[error("the scene {scene}: camera {camera} cannot be tracked")]
    Track {
        /// The scene's name.
        scene: String,
        /// The camera's place in the scene.
        camera: usize,
        /// The setting or ball.
        #[source]
        cause: TrackerError,
    },
    /// A picture has no size that the format can have.
    #[error("the scene {scene}: its pictures cannot be {format:?}")]
    Picture {
        /// The scene's name.
        scene: String,
        /// What the camera was to send.
        format: PixelFormat,
        /// The refusal.
        #[source]
        cause: FrameError,
    },
    /// The arms of the feature frame cannot be worked with.
    #[error("the scene {scene}: its arms of {arm_m} m cannot be worked with")]
    Arms {
        /// The scene's name.
        scene: String,
        /// Metres.
        arm_m: f64,
        /// The refusal.
        #[source]
        cause: AffineRefusal,
    },
}

/// Renders the first `frames` frames of a scene, as `sensor` takes them, and tracks them in every way of
/// `variants`; `each` gets every frame in order. Balls are taught in the first picture, where they are.
///
/// # Errors
/// [`RunError`] naming the scene, before the first call of `each`.
pub fn run(
    scene: &Scene,
    frames: usize,
    sensor: Sensor,
    variants: &[Variant],
    mut each: impl FnMut(&Seen<'_>),
) -> Result<(), RunError> {
    let mut pictures = Pictures::new(scene, sensor, variants);
    pictures.render(0);
    let mut pipelines = Vec::new();
    for variant in variants {
        pipelines.push(start(scene, variant, &pictures)?);
    }
    let mut steps = Vec::with_capacity(variants.len());
    for frame in 0..frames {
        let rendering = pictures.render(frame);
        let t_us = (scene.time_s(frame) * 1e6).round() as u64;
        let balls: Vec<_> = (0..pictures.cameras.len()).map(|camera| scene.truth(frame, camera)).collect();
        steps.clear();
        for (variant, pipeline) in variants.iter().zip(&mut pipelines) {
            let views = pictures.views(variant)?;
            let views: Vec<_> = views.into_iter().map(|view| (view, t_us)).collect();
            steps.push(pipeline.step(&views));
        }
        each(&Seen {
            frame,
            t_s: scene.time_s(frame),
            balls: &balls,
            hand: &scene.hand(frame),
            rendering,
            steps: &steps,
        });
    }
    Ok(())
}

/// A pipeline that starts on the pictures of frame 0.
fn start(scene: &Scene, variant: &Variant, pictures: &Pictures<'_>) -> Result<Pipeline, RunError> {
    let name = || scene.name.clone();
    let mut starts: Vec<CameraStart> = Vec::new();
    for (camera, view) in pictures.views(variant)?.iter().enumerate() {
        let at = scene.truth(0, camera).map(|ball| {
            let (u, v) = ball.outline_centre;
            Some(ImagePoint::new(u as f32, v as f32))
        });
        let taught = learning::learn_at(view, &at, &LearnConfig::default())
            .map_err(|cause| RunError::Learn { scene: name(), camera, format: variant.format, cause })?;
        let focal_px = (scene.cameras[camera].focal_px * variant.focal_share) as f32;
        starts.push(CameraStart { focal_px: Some(focal_px), ..learning::start_with(&taught) });
    }
    let arms = Arms::equal(scene.arm_m as f32).map_err(|cause| RunError::Arms {
        scene: name(),
        arm_m: scene.arm_m,
        cause,
    })?;
    Pipeline::new(&starts, variant.mode.pipeline(), Some(arms)).map_err(|(camera, cause)| RunError::Track {
        scene: name(),
        camera,
        cause,
    })
}

/// The pictures of one frame, in every format asked for.
struct Pictures<'a> {
    scene: &'a Scene,
    sensor: Sensor,
    formats: Vec<PixelFormat>,
    cameras: Vec<CameraPictures>,
}

#[derive(Default)]
struct CameraPictures {
    rgb: Vec<u8>,
    /// Formats other than RGB.
    converted: Vec<(PixelFormat, Vec<u8>)>,
}

impl<'a> Pictures<'a> {
    fn new(scene: &'a Scene, sensor: Sensor, variants: &[Variant]) -> Self {
        let most = variants.iter().map(|variant| variant.cameras).max().unwrap_or(0).min(scene.cameras());
        let mut formats: Vec<PixelFormat> = Vec::new();
        for variant in variants {
            if variant.format != PixelFormat::Rgb888 && !formats.contains(&variant.format) {
                formats.push(variant.format);
            }
        }
        Self { scene, sensor, formats, cameras: (0..most).map(|_| CameraPictures::default()).collect() }
    }

    /// Takes the pictures of a frame; the time of rendering alone.
    fn render(&mut self, frame: usize) -> Duration {
        let (width, height) = (self.scene.width, self.scene.height);
        let mut rendering = Duration::ZERO;
        for (camera, pictures) in self.cameras.iter_mut().enumerate() {
            let started = std::time::Instant::now();
            self.scene.render_rgb(frame, camera, &mut pictures.rgb);
            rendering += started.elapsed();
            self.sensor.develop(&mut pictures.rgb, usize::from(width));
            pictures.converted.clear();
            let formats = self.formats.iter();
            pictures
                .converted
                .extend(formats.map(|&format| (format, to_format(&pictures.rgb, width, height, format))));
        }
        rendering
    }

    /// What the cameras of a variant send.
    fn views(&self, variant: &Variant) -> Result<Vec<FrameView<'_>>, RunError> {
        let mut views = Vec::new();
        for CameraPictures { rgb, converted } in self.cameras.iter().take(variant.cameras) {
            let converted = converted.iter().find(|(format, _)| *format == variant.format);
            let bytes = converted.map_or(rgb, |(_, bytes)| bytes);
            let view = FrameView::packed(bytes, self.scene.width, self.scene.height, variant.format);
            views.push(view.map_err(|cause| RunError::Picture {
                scene: self.scene.name.clone(),
                format: variant.format,
                cause,
            })?);
        }
        Ok(views)
    }
}
