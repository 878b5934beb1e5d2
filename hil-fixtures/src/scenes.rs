//! Scenes by name.

use crate::background::Background;
use crate::camera::Camera;
use crate::light::Light;
use crate::motion::{Motion, about, degrees};
use crate::occluder::{Anchor, Occluder};
use crate::scene::{Albedo, Distractor, Scene};
use crate::truth::HandTruth;
use core::f64::consts::PI;
use nalgebra::{Matrix3, Vector3};
use tetrad_core::observation::{BALLS, Ball};

/// Saturated as matt plastic is: red, green, blue, yellow.
const ALBEDO: [Albedo; BALLS] =
    [[206.0, 36.0, 40.0], [38.0, 158.0, 62.0], [34.0, 72.0, 186.0], [228.0, 196.0, 44.0]];

/// From each camera to the middle of the workspace, metres; with the focal length below a ball of
/// 20 mm appears 16 px wide.
const DISTANCE_M: f64 = 1.0;

/// Pixels.
const FOCAL_PX: f64 = 800.0;

/// Half the angle between the cameras, degrees.
const HALF_ANGLE_DEG: f64 = 30.0;

/// How far above the horizon the cameras stand, degrees.
const ELEVATION_DEG: f64 = 12.0;

/// The sizes of `static-<D>px`, pixels: the paper's range, section 5.
const SIZES_PX: [u32; 8] = [5, 8, 12, 16, 24, 32, 48, 65];

/// The speeds of `linear-<v>` and `circular-<v>`, m/s: the paper's 0.5 and 0.7, and a calm one.
const SPEEDS: [f64; 3] = [0.25, 0.5, 0.7];

/// The rates of the same, frames a second: today's cameras and the paper's.
const RATES: [u32; 2] = [30, 10];

/// Scenes without a parameter, and what they show.
const PLAIN: [(&str, &str); 9] = [
    ("demo", "all six degrees of freedom, with pauses, before a desk; ten minutes"),
    ("still", "the hand at rest before a desk"),
    ("cover", "a finger covers the red ball for a second, the hand moving slowly"),
    ("cover-all", "a palm covers the whole hand for a second, the hand moving slowly"),
    ("crossing", "green passes before red, first in one camera, then in the other"),
    ("dimming", "the light falls by half over four seconds"),
    ("distractor", "a second red ball, 120 px away, while a finger covers the first for a second"),
    ("edge", "the hand leaves the picture in part and returns"),
    ("finger", "a finger comes over 40 % of the green ball's rim and stays"),
];

impl Scene {
    /// The scene of that name, or `None`. See [`Scene::names`]; `static-<D>px` and
    /// `static-side-<D>px` take any whole diameter from 3 to 80, `linear-<v>-<n>fps` and
    /// `circular-<v>-<n>fps` any speed above 0 and up to 2 m/s and any rate from 1 to 240.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let mut scene = match name {
            "demo" => demo(),
            "still" => still(),
            "cover" => cover(finger_over_red()),
            "cover-all" => cover(palm()),
            "crossing" => crossing(),
            "dimming" => dimming(),
            "distractor" => distractor(),
            "edge" => edge(),
            "finger" => finger(),
            _ => parametrised(name)?,
        };
        name.clone_into(&mut scene.name);
        Some(scene)
    }

    /// Every scene that has a name of its own, with a line on what it shows.
    #[must_use]
    pub fn names() -> Vec<(String, &'static str)> {
        let plain = PLAIN.iter().map(|&(name, about)| (name.to_owned(), about));
        let sizes = SIZES_PX.iter().flat_map(|size| {
            [
                (
                    format!("static-{size}px"),
                    "balls of that diameter in even light, moved a little every frame",
                ),
                (format!("static-side-{size}px"), "the same, lit from one side: the shadow side has 45 %"),
            ]
        });
        let speeds = SPEEDS.iter().flat_map(|speed| {
            RATES.iter().flat_map(move |fps| {
                [
                    (format!("linear-{speed}-{fps}fps"), "0.3 m to and fro at that speed in m/s"),
                    (format!("circular-{speed}-{fps}fps"), "round a circle of 0.1 m at that speed in m/s"),
                ]
            })
        });
        plain.chain(sizes).chain(speeds).collect()
    }
}

fn parametrised(name: &str) -> Option<Scene> {
    if let Some(rest) = name.strip_prefix("static-") {
        let (light, size) = match rest.strip_prefix("side-") {
            Some(size) => (Light::side(0.45), size),
            None => (Light::even(), rest),
        };
        let diameter = size.strip_suffix("px")?.parse::<u32>().ok()?;
        return (3..=80).contains(&diameter).then(|| sized(f64::from(diameter), light));
    }
    let (kind, rest) = name.split_once('-')?;
    let (speed, rate) = rest.strip_suffix("fps")?.split_once('-')?;
    let speed = speed.parse::<f64>().ok().filter(|v| *v > 0.0 && *v <= 2.0)?;
    let fps = rate.parse::<u32>().ok().filter(|n| (1..=240).contains(n))?;
    let motion = match kind {
        "linear" => Motion::Linear { path_m: Vector3::new(0.30, 0.80, 0.52).normalize() * 0.3, speed },
        "circular" => Motion::Circular { radius_m: 0.1, normal: Vector3::new(1.0, 0.3, 0.4), speed },
        _ => return None,
    };
    Some(Scene {
        fps: f64::from(fps),
        frames: 10 * fps as usize,
        motion,
        background: Background::Gradient(186.0, 138.0),
        ..base()
    })
}

/// What the scenes share: two cameras, a hand of 20 mm balls on arms of 80 mm in the middle.
fn base() -> Scene {
    let (width, height) = (640, 480);
    let camera = |side: f64| {
        let (azimuth, elevation) = (degrees(side * HALF_ANGLE_DEG), degrees(ELEVATION_DEG));
        let direction = Vector3::new(
            libm::cos(elevation) * libm::cos(azimuth),
            libm::cos(elevation) * libm::sin(azimuth),
            libm::sin(elevation),
        );
        Camera::looking_at(direction * DISTANCE_M, Vector3::zeros(), FOCAL_PX, width, height)
    };
    let arm_m = 0.080;
    Scene {
        name: String::new(),
        seed: 1,
        fps: 30.0,
        frames: 300,
        exposure_s: 0.004,
        width,
        height,
        cameras: vec![camera(-1.0), camera(1.0)],
        ball_diameter_m: 0.020,
        arm_m,
        rest: centred(held(), arm_m),
        motion: Motion::Still,
        light: Light::room(),
        background: Background::Plain(168.0),
        noise_sigma: 2.0,
        albedo: ALBEDO,
        occluders: Vec::new(),
        distractors: Vec::new(),
        rods: false,
        kept: Default::default(),
    }
}

/// How the hand is held: green to the right, blue down, yellow up, all three away from the cameras.
/// Of all orientations one of the best to see the four balls apart with both cameras: no two are
/// nearer than 0.75 arm lengths in either picture.
fn held() -> Matrix3<f64> {
    about(&Vector3::z(), degrees(95.0)) * about(&Vector3::x(), degrees(-59.0))
}

/// The pose of that orientation with the four balls' middle in the middle of the workspace.
fn centred(rotation: Matrix3<f64>, arm_m: f64) -> HandTruth {
    let middle = rotation * Vector3::repeat(arm_m / 4.0);
    HandTruth { rotation, translation: -middle }
}

/// An operator who holds the hand almost still: under 0.1 m/s.
fn slow() -> Motion {
    Motion::Tour { reach_m: Vector3::new(0.02, 0.04, 0.025), turn_rad: Vector3::repeat(0.06), pace: 1.0 }
}

fn demo() -> Scene {
    Scene {
        frames: 18_000,
        motion: Motion::Tour {
            reach_m: Vector3::new(0.05, 0.11, 0.07),
            turn_rad: Vector3::new(0.22, 0.20, 0.26),
            pace: 1.0,
        },
        background: Background::Clutter { seed: 11 },
        ..base()
    }
}

fn still() -> Scene {
    Scene { background: Background::Clutter { seed: 12 }, ..base() }
}

fn sized(diameter_px: f64, light: Light) -> Scene {
    let ball_diameter_m = diameter_px * DISTANCE_M / FOCAL_PX;
    // large balls need longer arms to stay apart
    let arm_m = 0.080f64.max(2.4 * ball_diameter_m);
    let half_pixel_m = 0.5 * DISTANCE_M / FOCAL_PX;
    Scene {
        frames: 60,
        ball_diameter_m,
        arm_m,
        rest: centred(held(), arm_m),
        motion: Motion::Steps { period_s: 1.0 / 30.0, amplitude_m: half_pixel_m },
        light,
        ..base()
    }
}

/// Comes into the picture, is over its anchor from 2 s to 3 s, and leaves.
fn over_for_a_second(reach: f64) -> Vec<(f64, f64)> {
    let (outside, near) = (-40.0, reach - 3.0);
    vec![(1.2, outside), (1.7, near), (2.0, reach), (3.0, reach), (3.3, near), (3.8, outside)]
}

/// A finger from the left, between the blue and the yellow ball.
fn finger_over_red() -> Occluder {
    Occluder::finger(Anchor::Ball(Ball::Red), PI, 0.8, over_for_a_second(0.72))
}

/// A palm from below.
fn palm() -> Occluder {
    Occluder::finger(Anchor::Hand, PI / 2.0, 6.0, over_for_a_second(6.0))
}

fn cover(occluder: Occluder) -> Scene {
    Scene {
        frames: 180,
        motion: slow(),
        background: Background::Clutter { seed: 13 },
        occluders: vec![occluder],
        ..base()
    }
}

fn crossing() -> Scene {
    // E1 turns in the plane of the two optical axes, 60 degrees to either side of the plane of
    // symmetry; the cameras stand 30 degrees to either side, less what their height takes away
    let bisector = Vector3::new(
        libm::cos(degrees(ELEVATION_DEG)) * libm::cos(degrees(HALF_ANGLE_DEG)),
        0.0,
        libm::sin(degrees(ELEVATION_DEG)),
    )
    .normalize();
    let normal = bisector.cross(&Vector3::y()).normalize();
    let held = Matrix3::from_columns(&[bisector, Vector3::y(), normal]);
    // of all rolls the one that keeps the other pairs farthest apart all the way: two diameters
    let rotation = held * about(&Vector3::x(), degrees(145.0));
    Scene {
        frames: 420,
        rest: HandTruth { rotation, translation: Vector3::zeros() },
        motion: Motion::Turn {
            axis: normal,
            from_to_rad: (degrees(-60.0), degrees(60.0)),
            from_to_s: (1.0, 13.0),
        },
        background: Background::Clutter { seed: 14 },
        ..base()
    }
}

fn dimming() -> Scene {
    Scene {
        frames: 210,
        motion: slow(),
        light: Light { level: vec![(1.0, 1.0), (5.0, 0.5)], ..Light::room() },
        background: Background::Clutter { seed: 15 },
        ..base()
    }
}

fn distractor() -> Scene {
    let scene = cover(finger_over_red());
    let above = scene.rest.translation + Vector3::new(0.0, 0.0, 0.143);
    let second = Distractor { centre_m: above, diameter_m: scene.ball_diameter_m, albedo: scene.albedo[0] };
    Scene { distractors: vec![second], ..scene }
}

fn edge() -> Scene {
    Scene {
        frames: 210,
        motion: Motion::Excursion { to_m: Vector3::new(0.0, 0.0, 0.28), times_s: [1.0, 2.5, 3.5, 5.0] },
        background: Background::Clutter { seed: 16 },
        ..base()
    }
}

fn finger() -> Scene {
    // a tip of 0.9 diameters' radius that reaches 0.02 short of the centre hides 144 degrees of rim
    let reach = vec![(1.0, -40.0), (1.4, -0.02)];
    Scene {
        frames: 150,
        motion: slow(),
        background: Background::Clutter { seed: 17 },
        occluders: vec![Occluder::finger(Anchor::Ball(Ball::Green), 0.0, 0.9, reach)],
        ..base()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::Outline;

    #[test]
    fn finger_hides_40_percent_of_the_rim() {
        let scene = finger();
        for camera in 0..2 {
            for frame in [45, 80, 149] {
                let things = scene.things(camera, scene.time_s(frame));
                let finger = things.iter().find(|thing| matches!(thing.outline, Outline::Capsule(_)));
                let finger = finger.expect("one finger").outline;
                let green = scene.truth(frame, camera)[Ball::Green.index()];
                let hidden = (0..3600).filter(|tenth| {
                    let angle = degrees(f64::from(*tenth) / 10.0);
                    let (u, v) = green.outline_centre;
                    let x = u + green.diameter / 2.0 * libm::cos(angle);
                    let y = v + green.diameter / 2.0 * libm::sin(angle);
                    finger.interval(y).is_some_and(|(left, right)| left < x && x < right)
                });
                let share = hidden.count() as f64 / 3600.0;
                assert!((share - 0.4).abs() < 0.005, "{share}");
            }
        }
    }
}
