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

/// The scene in which all balls are hidden until they are lost, and found again.
pub const COVERED: &str = "cover-all";
