//! Promise: a change of accuracy shows. A grid of size, light, noise and a finger over the rim is
//! tracked, and the table of errors is compared with tests/snapshots/accuracy.txt.
//!
//! Not a bound but a picture of where `paper` mode is good and where it is not, and where `refined` is,
//! at one noise.
//! `TETRAD_BLESS=1 cargo test -p tetrad-tests --test accuracy_grid` rewrites it: read the difference.

mod common;

use std::f64::consts::PI;
use std::fmt::Write as _;
use tetrad_core::config::{CentreMode, TrackerConfig};
use tetrad_core::observation::Ball;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_fixtures::golden::{self, GoldenError};
use tetrad_fixtures::{Anchor, Light, Occluder};

const DIAMETERS_PX: [u32; 4] = [8, 16, 32, 65];
const NOISES: [f64; 3] = [1.0, 3.0, 8.0];
/// The noise at which `refined` is tracked too.
const REFINED_NOISE: f64 = 3.0;
const FRAMES: usize = 30;

/// The finger rests over the red ball from this frame on; it comes from outside in the ten before.
const COVERED_FROM: usize = 15;

/// Errors of the frames in which a ball was measured, and how many frames there were.
#[derive(Default)]
struct Cell {
    errors_px: Vec<f64>,
    frames: usize,
}

impl Cell {
    fn add(&mut self, measured: bool, error_px: f64) {
        self.frames += 1;
        if measured {
            self.errors_px.push(error_px);
        }
    }

    /// Mean and maximum to so many places, and the share of frames that were measured.
    fn text(&self, places: usize) -> String {
        let share = 100 * self.errors_px.len() / self.frames.max(1);
        if self.errors_px.is_empty() {
            return format!("{:>16} {share:3} %", "-");
        }
        let mean = self.errors_px.iter().sum::<f64>() / self.errors_px.len() as f64;
        let max = self.errors_px.iter().copied().fold(0.0, f64::max);
        format!("{mean:7.places$} {max:8.places$} {share:3} %")
    }
}

/// One line of the table: balls in full sight, and the red ball under a finger.
fn row(config: TrackerConfig, diameter: u32, light: &str, noise_sigma: f64) -> String {
    let name = if light == "side" { "static-side" } else { "static" };
    let mut scene = common::scene(&format!("{name}-{diameter}px"));
    if light == "room" {
        scene.light = Light::room();
    }
    scene.noise_sigma = noise_sigma;
    scene.frames = FRAMES;
    // A tip of 0.9 diameters' radius that ends 0.15 diameters short of the centre: a third is hidden.
    let arrival = scene.time_s(COVERED_FROM);
    let reach = vec![(scene.time_s(COVERED_FROM - 10), -4.0), (arrival, -0.15)];
    scene.occluders = vec![Occluder::finger(Anchor::Ball(Ball::Red), PI, 0.9, reach)];

    let (mut whole, mut covered) = (Cell::default(), Cell::default());
    common::track_as(&scene, 0, config, PixelFormat::Rgb888, |tracked| {
        for ball in Ball::ALL {
            let (truth, seen) = tracked.ball(ball);
            let (measured, error_px) = (seen.state.is_measured(), tracked.error_px(ball));
            if truth.visible_fraction > 0.999 {
                whole.add(measured, error_px);
            } else if tracked.frame >= COVERED_FROM {
                covered.add(measured, error_px);
            }
        }
    });
    assert!(whole.frames > 3 * FRAMES && covered.frames > 5, "{} and {}", whole.frames, covered.frames);
    let places = if config.centre.mode == CentreMode::Refined { 3 } else { 2 };
    format!("{diameter:>5} {light:<5} {noise_sigma:>5} | {} | {}", whole.text(places), covered.text(places))
}

#[test]
fn errors_over_size_light_noise_and_a_finger() -> Result<(), GoldenError> {
    let mut table = String::from(
        "# Error of the centre in px over 30 frames of the static scenes, one camera, paper mode. Share: frames\n\
         # in which the ball was measured. Light: even, room (a lamp above, a highlight), side (the shadow\n\
         # side has 45 %). Noise: standard deviation in grey levels. Finger: over a third of the red ball.\n\
         #                  |       in full sight     |     under a finger\n\
         # px light noise |    mean      max share |    mean      max share\n",
    );
    for diameter in DIAMETERS_PX {
        for light in ["even", "room", "side"] {
            for noise_sigma in NOISES {
                // writing to a string cannot fail
                let _ = writeln!(table, "{}", row(TrackerConfig::paper(), diameter, light, noise_sigma));
            }
        }
    }
    table.push_str("# The same in refined mode\n");
    for diameter in DIAMETERS_PX {
        for light in ["even", "room", "side"] {
            let _ = writeln!(table, "{}", row(TrackerConfig::default(), diameter, light, REFINED_NOISE));
        }
    }
    golden::check_file(&tetrad_tests::repository().join("tests/snapshots/accuracy.txt"), table.as_bytes())
}
