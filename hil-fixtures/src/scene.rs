//! A scene: everything a picture depends on.

use crate::background::{Background, Kept};
use crate::camera::Camera;
use crate::light::{Lamp, Light};
use crate::motion::Motion;
use crate::occluder::{Occluder, rod};
use crate::outline::{CapsuleOutline, Outline, SphereOutline};
use crate::truth::HandTruth;
use nalgebra::Vector3;
use tetrad_core::observation::{BALLS, Ball};

/// Half the thickness of the rods that hold the balls, metres.
const ROD_RADIUS_M: f64 = 0.0015;

/// Dark grey.
const ROD_ALBEDO: [f64; 3] = [52.0, 54.0, 58.0];

/// Grey levels (red, green, blue; 0 to 255) of a surface in full light.
pub type Albedo = [f64; 3];

/// A ball that is none of the four and stands still.
#[derive(Clone, Debug, PartialEq)]
pub struct Distractor {
    /// Its centre in the world, metres.
    pub centre_m: Vector3<f64>,
    /// Metres.
    pub diameter_m: f64,
    /// In full light.
    pub albedo: Albedo,
}

/// A feature frame before two cameras. Change any field before rendering; a picture depends on the
/// fields, the frame number and the camera only.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What it is called.
    pub name: String,
    /// Another seed is other noise and other random steps.
    pub seed: u64,
    /// Frames a second.
    pub fps: f64,
    /// How many frames it has; rendering goes on beyond.
    pub frames: usize,
    /// How long the shutter is open, seconds.
    pub exposure_s: f64,
    /// Pixels.
    pub width: u16,
    /// Pixels.
    pub height: u16,
    /// Left, right.
    pub cameras: Vec<Camera>,
    /// Metres.
    pub ball_diameter_m: f64,
    /// From the red ball's centre to each of the others, metres.
    pub arm_m: f64,
    /// The hand's pose before `motion`.
    pub rest: HandTruth,
    /// What is added to `rest`.
    pub motion: Motion,
    /// Where it comes from and how strong it is.
    pub light: Light,
    /// What is behind.
    pub background: Background,
    /// Standard deviation of the sensor's noise, grey levels.
    pub noise_sigma: f64,
    /// The balls' colours: red, green, blue, yellow.
    pub albedo: [Albedo; BALLS],
    /// Fingers and palms, in front of everything.
    pub occluders: Vec<Occluder>,
    /// Other balls.
    pub distractors: Vec<Distractor>,
    /// Whether the rods that hold the balls are drawn.
    pub rods: bool,
    pub(crate) kept: Kept,
}

/// One visible thing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Thing {
    pub(crate) outline: Outline,
    pub(crate) surface: Surface,
    /// From the camera, metres; what is farther is hidden.
    pub(crate) distance_m: f64,
    /// Which of the four balls it is.
    pub(crate) ball: Option<Ball>,
}

/// How a thing is shaded.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Surface {
    /// A sphere, given in camera axes.
    Sphere { centre: Vector3<f64>, radius: f64, albedo: Albedo },
    /// A finger or a rod: a little darker towards its rim.
    Round { outline: CapsuleOutline, albedo: Albedo },
}

impl Scene {
    /// How many frames the scene has.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// How many cameras see it: left is 0, right is 1.
    #[must_use]
    pub fn cameras(&self) -> usize {
        self.cameras.len()
    }

    /// The middle of a frame's exposure, seconds after that of frame 0.
    #[must_use]
    pub fn time_s(&self, frame: usize) -> f64 {
        frame as f64 / self.fps
    }

    /// The balls' grey levels in full light: red, green, blue, yellow.
    #[must_use]
    pub fn colours(&self) -> [Albedo; BALLS] {
        self.albedo
    }

    /// The hand's pose at any time.
    #[must_use]
    pub fn hand_at(&self, time_s: f64) -> HandTruth {
        let (turn, shift) = self.motion.at(time_s, self.seed);
        HandTruth { rotation: turn * self.rest.rotation, translation: self.rest.translation + shift }
    }

    /// The balls' centres in the world at any time, metres.
    #[must_use]
    pub fn balls_at(&self, time_s: f64) -> [Vector3<f64>; BALLS] {
        let hand = self.hand_at(time_s);
        let ends = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
        ends.map(|x_in_hand| hand.rotation * (x_in_hand * self.arm_m) + hand.translation)
    }

    /// All that a camera has before it at a time, the farthest first.
    pub(crate) fn things(&self, camera_index: usize, time_s: f64) -> Vec<Thing> {
        let camera = &self.cameras[camera_index];
        let mut things = Vec::new();
        let mut sphere = |centre_in_world: &Vector3<f64>, radius: f64, albedo, ball| {
            let centre = camera.in_camera(centre_in_world);
            let outline = SphereOutline::new(camera, centre, radius)?;
            things.push(Thing {
                outline: Outline::Sphere(outline),
                surface: Surface::Sphere { centre, radius, albedo },
                distance_m: centre.norm(),
                ball,
            });
            Some(outline)
        };
        let balls = self.balls_at(time_s);
        let radius = self.ball_diameter_m / 2.0;
        let outlines = Ball::ALL.map(|ball| {
            let i = ball.index();
            sphere(&balls[i], radius, self.albedo[i], Some(ball))
        });
        for other in &self.distractors {
            sphere(&other.centre_m, other.diameter_m / 2.0, other.albedo, None);
        }
        let mut round = |outline: CapsuleOutline, albedo, distance_m| {
            let surface = Surface::Round { outline, albedo };
            things.push(Thing { outline: Outline::Capsule(outline), surface, distance_m, ball: None });
        };
        if self.rods {
            let [red, others @ ..] = balls;
            for end in others {
                // from surface to surface
                let bare = (end - red) * (radius / self.arm_m);
                let from_to = [red + bare, end - bare].map(|x| camera.in_camera(&x));
                let distance_m = ((from_to[0] + from_to[1]) / 2.0).norm();
                if let Some(outline) = rod(camera, from_to, ROD_RADIUS_M) {
                    round(outline, ROD_ALBEDO, distance_m);
                }
            }
        }
        for occluder in &self.occluders {
            if let Some(outline) = occluder.outline(camera_index, time_s, &outlines) {
                round(outline, occluder.albedo, 0.0);
            }
        }
        things.sort_by(|a, b| b.distance_m.total_cmp(&a.distance_m));
        things
    }

    /// The light as one camera sees it.
    pub(crate) fn lamp(&self, camera: usize) -> Lamp {
        Lamp {
            towards_in_camera: self.cameras[camera].camera_from_world * self.light.towards.normalize(),
            ambient: self.light.ambient,
            diffuse: self.light.diffuse,
            specular: self.light.specular,
        }
    }
}
