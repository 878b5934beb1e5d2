//! Promise (`refined` mode, the default): with a third of the rim in sight the centre stays usable. A
//! finger lies over two thirds of the green ball's rim, and over nine tenths of its disc, from four
//! sides, in three lights. What cannot be measured is said to be predicted or lost.
//!
//! 640 x 480, two cameras 1 m away, noise of 2 grey levels, clutter behind.

mod common;

use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};
use tetrad_core::config::TrackerConfig;
use tetrad_core::observation::Ball;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_fixtures::{Light, Scene};

/// How far past the ball's middle a tip of 0.9 diameters' radius reaches that hides 240 degrees of the
/// rim, in diameters.
const TWO_THIRDS: f64 = 0.361;

/// What became of the covered ball.
#[derive(Default)]
struct Outcome {
    errors: Vec<f64>,
    /// Sums of squares of the two components, made independent and divided by their deviations.
    normalised: f64,
    frames: usize,
}

impl Outcome {
    fn add(&mut self, other: Self) {
        self.errors.extend(other.errors);
        self.normalised += other.normalised;
        self.frames += other.frames;
    }

    fn mean(&self) -> f64 {
        self.errors.iter().sum::<f64>() / self.errors.len() as f64
    }

    fn max(&self) -> f64 {
        self.errors.iter().copied().fold(0.0, f64::max)
    }

    fn measured(&self) -> f64 {
        self.errors.len() as f64 / self.frames as f64
    }

    /// Root mean square of the errors over their standard deviations.
    fn ratio(&self) -> f64 {
        (self.normalised / (2.0 * self.errors.len() as f64)).sqrt()
    }

    fn said(&self) -> String {
        format!(
            "mean {:.3} px, maximum {:.2} px, {:.2} of the deviation, measured in {:.0} % of {} frames",
            self.mean(),
            self.max(),
            self.ratio(),
            100.0 * self.measured(),
            self.frames
        )
    }
}

/// The `finger` scene with balls of another size and a finger that reaches farther.
fn scene(diameter: f64, light: &Light, from_rad: f64, reach: f64) -> Scene {
    let mut scene = common::scene("finger");
    scene.light = light.clone();
    scene.ball_diameter_m *= diameter / 16.0;
    // large balls need longer arms to stay apart
    scene.arm_m = scene.arm_m.max(2.4 * scene.ball_diameter_m);
    scene.rest.translation = -(scene.rest.rotation * Vector3::repeat(scene.arm_m / 4.0));
    for finger in &mut scene.occluders {
        finger.from_rad = from_rad;
        if let Some((_, last)) = finger.reach.last_mut() {
            *last = reach;
        }
    }
    scene
}

/// The green ball while the finger rests over it.
fn under_a_finger(scene: &Scene) -> Outcome {
    let mut outcome = Outcome::default();
    for camera in 0..scene.cameras() {
        common::track_as(scene, camera, TrackerConfig::default(), PixelFormat::Rgb888, |tracked| {
            if scene.time_s(tracked.frame) <= 1.45 {
                return;
            }
            outcome.frames += 1;
            let (truth, seen) = tracked.ball(Ball::Green);
            if !seen.state.is_measured() {
                return;
            }
            let du = f64::from(seen.centre.u) - truth.outline_centre.0;
            let dv = f64::from(seen.centre.v) - truth.outline_centre.1;
            let [uu, uv, vv] = [seen.covariance.uu, seen.covariance.uv, seen.covariance.vv].map(f64::from);
            outcome.errors.push(du.hypot(dv));
            outcome.normalised += (du * du * vv - 2.0 * du * dv * uv + dv * dv * uu) / (uu * vv - uv * uv);
        });
    }
    outcome
}

/// All sides and lights.
fn from_all_sides(diameter: f64, reach: f64) -> Outcome {
    let mut all = Outcome::default();
    for (light, of_light) in [(Light::even(), "even"), (Light::side(0.45), "45 %"), (Light::room(), "room")] {
        for from_rad in [0.0, FRAC_PI_2, PI, 4.0] {
            let outcome = under_a_finger(&scene(diameter, &light, from_rad, reach));
            let said = format!("{diameter} px, finger from {from_rad:.2}, {of_light}: {}", outcome.said());
            println!("{said}");
            assert!(outcome.max() <= diameter / 2.0, "{said}");
            all.add(outcome);
        }
    }
    println!("{diameter} px: {}", all.said());
    all
}

/// The mean error is at most a sixteenth of a diameter of 16 px.
fn a_third_of_the_rim(diameter: f64, mean: f64, measured: f64) {
    let all = from_all_sides(diameter, TWO_THIRDS);
    assert!(all.mean() <= mean && all.measured() >= measured, "{}", all.said());
    assert!((0.7..=1.4).contains(&all.ratio()), "{}", all.said());
}

#[test]
fn a_third_of_the_rim_of_16_px() {
    a_third_of_the_rim(16.0, 0.8, 0.7);
}

#[test]
fn a_third_of_the_rim_of_24_px() {
    a_third_of_the_rim(24.0, 0.8, 0.9);
}

#[test]
fn a_third_of_the_rim_of_32_px() {
    a_third_of_the_rim(32.0, 0.8, 0.9);
}

/// Forty per cent of the rim hidden: no single frame is far off.
#[test]
fn no_outlier_with_most_of_the_rim_in_sight() {
    let all = from_all_sides(16.0, -0.02);
    assert!(all.mean() <= 0.4 && all.measured() >= 0.99, "{}", all.said());
}
