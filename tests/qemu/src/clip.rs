//! Scenes small enough for a microcontroller's sensor: QVGA, RGB565.

use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::frame::PixelFormat;
use tetrad_fixtures::{Scene, to_format};

/// Pixels lie as most sensors send them.
pub const FORMAT: PixelFormat = PixelFormat::Rgb565Be;

/// A camera's pictures of a scene, in half their size.
#[derive(Debug)]
pub struct Clip {
    scene: Scene,
    camera: usize,
}

impl Clip {
    /// What a camera of the scene of that name sees, in half its width and height.
    #[must_use]
    pub fn named(name: &str, camera: usize) -> Option<Self> {
        let mut scene = Scene::named(name)?;
        (scene.width, scene.height) = (scene.width / 2, scene.height / 2);
        for camera in &mut scene.cameras {
            camera.focal_px /= 2.0;
            camera.principal_px =
                ((f64::from(scene.width) - 1.0) / 2.0, (f64::from(scene.height) - 1.0) / 2.0);
        }
        (camera < scene.cameras()).then_some(Self { scene, camera })
    }

    /// Width and height, pixels.
    #[must_use]
    pub const fn size(&self) -> (u16, u16) {
        (self.scene.width, self.scene.height)
    }

    /// The bytes of a picture.
    #[must_use]
    pub fn picture(&self, frame: usize) -> Vec<u8> {
        let mut rgb = Vec::new();
        self.scene.render_rgb(frame, self.camera, &mut rgb);
        to_format(&rgb, self.scene.width, self.scene.height, FORMAT)
    }

    /// When it was taken, microseconds.
    #[must_use]
    pub fn time_us(&self, frame: usize) -> u64 {
        (self.scene.time_s(frame) * 1e6).round() as u64
    }

    /// Where the balls are in a picture.
    #[must_use]
    pub fn places(&self, frame: usize) -> [(Ball, ImagePoint); BALLS] {
        let truth = self.scene.truth(frame, self.camera);
        Ball::ALL.map(|ball| {
            let (u, v) = truth[ball.index()].outline_centre;
            (ball, ImagePoint::new(u as f32, v as f32))
        })
    }
}

/// What is shown of a scene: balls are taught in its first picture, and then these frames follow.
#[derive(Clone, Debug)]
pub struct Sequence {
    /// The scene.
    pub scene: &'static str,
    /// Its frames behind the first; between two of them any number may be left out.
    pub frames: Vec<usize>,
}

/// Tracking of large and small, fast and hidden balls; their loss, and finding them again. Of `cover-all`
/// six frames of sixty: before, while and after a palm covers all balls. A ball that is looked for everywhere
/// costs a hundred million instructions a frame, which are seconds in QEMU.
#[must_use]
pub fn sequences() -> [Sequence; 9] {
    let sequence = |scene, frames| Sequence { scene, frames };
    [
        sequence("demo", (1..40).collect()),
        sequence("static-30px", (1..20).collect()),
        sequence("static-12px", (1..20).collect()),
        sequence("static-side-48px", (1..20).collect()),
        sequence("linear-0.7-10fps", (1..20).collect()),
        sequence(COVERED, vec![47, 48, 53, 75, 102, 103]),
        sequence("crossing", (114..124).collect()),
        sequence("distractor", (58..64).collect()),
        sequence("edge", (28..38).collect()),
    ]
}

/// A few frames of every other scene: at rest and at its fastest, a ball while it is covered, dimmed or half
/// hidden. Balls of three pixels and less are not learnt, and so not tracked.
#[must_use]
pub fn others() -> [Sequence; 29] {
    let sequence = |scene, frames: &[usize]| Sequence { scene, frames: frames.to_vec() };
    let resting = |scene| sequence(scene, &[1, 2, 3]);
    let moving = |scene| sequence(scene, &[20, 21, 22, 23]);
    [
        resting("still"),
        sequence("cover", &[40, 52, 60, 98]),
        sequence("dimming", &[30, 60, 90, 120, 150]),
        sequence("finger", &[38, 41, 44, 60]),
        resting("static-5px"),
        resting("static-8px"),
        resting("static-16px"),
        resting("static-24px"),
        resting("static-32px"),
        resting("static-48px"),
        resting("static-65px"),
        resting("static-side-5px"),
        resting("static-side-8px"),
        resting("static-side-12px"),
        resting("static-side-16px"),
        resting("static-side-24px"),
        resting("static-side-32px"),
        resting("static-side-65px"),
        moving("linear-0.25-30fps"),
        moving("linear-0.25-10fps"),
        moving("linear-0.5-30fps"),
        moving("linear-0.5-10fps"),
        moving("linear-0.7-30fps"),
        moving("circular-0.25-30fps"),
        moving("circular-0.25-10fps"),
        moving("circular-0.5-30fps"),
        moving("circular-0.5-10fps"),
        moving("circular-0.7-30fps"),
        moving("circular-0.7-10fps"),
    ]
}

/// The scene in which all balls are hidden until they are lost, and found again.
pub const COVERED: &str = "cover-all";
