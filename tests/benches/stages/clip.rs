//! A clip that is rendered once, and played to and fro for as long as a benchmark runs.

use std::sync::OnceLock;
use tetrad::learning::tracked_as;
use tetrad_core::config::LearnConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::Primary;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::vision::learn::learn;
use tetrad_fixtures::{Scene, to_format};

/// Two cameras look at balls of 16 px that move at 0.25 m/s.
const SCENE: &str = "linear-0.25-30fps";

/// Of each camera: 18 MB in RGB, more than a processor keeps near, as new frames from a camera are.
const FRAMES: usize = 20;

/// Cameras of the scene.
pub(crate) const CAMERAS: usize = 2;

/// Time from a frame to the next, microseconds.
pub(crate) const FRAME_US: u64 = 33_333;

/// The frames of both cameras in one format.
pub(crate) struct Clip {
    pub(crate) scene: Scene,
    format: PixelFormat,
    frames: [Vec<Vec<u8>>; CAMERAS],
}

impl Clip {
    /// The clip in a format.
    pub(crate) fn new(format: PixelFormat) -> Self {
        let (scene, rendered) = rendered();
        let convert = |rgb: &Vec<u8>| to_format(rgb, scene.width, scene.height, format);
        let frames = rendered.each_ref().map(|frames| frames.iter().map(convert).collect());
        Self { scene: scene.clone(), format, frames }
    }

    /// The picture of a camera in the step `step`, counted from 0 without an end.
    pub(crate) fn view(&self, camera: usize, step: usize) -> FrameView<'_> {
        let turn = step % (2 * FRAMES - 2);
        let frame = if turn < FRAMES { turn } else { 2 * FRAMES - 2 - turn };
        let bytes = &self.frames[camera][frame];
        FrameView::packed(bytes, self.scene.width, self.scene.height, self.format)
            .expect("a rendered frame is whole")
    }

    /// Where the balls are in the first frame.
    pub(crate) fn places(&self, camera: usize) -> [ImagePoint; BALLS] {
        self.scene.truth(0, camera).map(|ball| {
            let (u, v) = ball.outline_centre;
            ImagePoint::new(u as f32, v as f32)
        })
    }

    /// The balls as they are learnt there.
    pub(crate) fn learnt(&self, camera: usize) -> [LearntBall; BALLS] {
        let (view, places) = (self.view(camera, 0), self.places(camera));
        Ball::ALL.map(|ball| {
            let at = places[ball.index()];
            let learnt = learn(&view, Primary::of(ball), at, &LearnConfig::default());
            tracked_as(&learnt.unwrap_or_else(|refused| panic!("{}: {refused}", ball.name())))
        })
    }
}

fn rendered() -> &'static (Scene, [Vec<Vec<u8>>; CAMERAS]) {
    static CLIP: OnceLock<(Scene, [Vec<Vec<u8>>; CAMERAS])> = OnceLock::new();
    CLIP.get_or_init(|| {
        let scene = Scene::named(SCENE).expect("the scene exists");
        let frames = [0, 1].map(|camera| {
            let render = |frame| {
                let mut rgb = Vec::new();
                scene.render_rgb(frame, camera, &mut rgb);
                rgb
            };
            (0..FRAMES).map(render).collect()
        });
        (scene, frames)
    })
}
