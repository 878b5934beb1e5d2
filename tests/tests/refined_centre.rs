//! Promise (`refined` mode, the default): how near a ball's centre is to the truth, at rest and moving,
//! in even and in side light, in RGB and in YUYV, wholly in sight and under a finger; and that the
//! covariance says so. 640 x 480, two cameras 1 m away, noise of 2 grey levels.
//!
//! The bounds are those set for this version (docs/method.md), not what happens to be reached: that is
//! printed with `--nocapture`.

mod common;

use common::Tracked;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};
use tetrad_core::config::TrackerConfig;
use tetrad_core::observation::{Ball, ObservationState};
use tetrad_core::vision::frame::PixelFormat;
use tetrad_fixtures::{Light, Scene};

/// Errors of centres, pixels, and of centres over their standard deviations.
#[derive(Default)]
struct Errors {
    px: Vec<f64>,
    /// Sums of squares of the two components, made independent and divided by their deviations.
    normalised: f64,
}

impl Errors {
    fn add(&mut self, tracked: &Tracked, ball: Ball) {
        let (truth, seen) = tracked.ball(ball);
        let (du, dv) = (
            f64::from(seen.centre.u) - truth.outline_centre.0,
            f64::from(seen.centre.v) - truth.outline_centre.1,
        );
        let [uu, uv, vv] = [seen.covariance.uu, seen.covariance.uv, seen.covariance.vv].map(f64::from);
        let determinant = uu * vv - uv * uv;
        assert!(seen.covariance.is_valid() && determinant > 0.0, "{seen:?}");
        self.px.push(du.hypot(dv));
        self.normalised += (du * du * vv - 2.0 * du * dv * uv + dv * dv * uu) / determinant;
    }

    fn pool(&mut self, other: &Self) {
        self.px.extend(&other.px);
        self.normalised += other.normalised;
    }

    fn mean(&self) -> f64 {
        self.px.iter().sum::<f64>() / self.px.len() as f64
    }

    fn max(&self) -> f64 {
        self.px.iter().copied().fold(0.0, f64::max)
    }

    /// Root mean square of the errors over their standard deviations.
    fn ratio(&self) -> f64 {
        (self.normalised / (2.0 * self.px.len() as f64)).sqrt()
    }
}

/// Tracks both cameras of a scene in `refined` mode.
fn track(scene: &Scene, format: PixelFormat, mut each: impl FnMut(&Tracked)) {
    for camera in 0..scene.cameras() {
        common::track_as(scene, camera, TrackerConfig::default(), format, &mut each);
    }
}

/// All balls of a scene in which every ball is in full sight in every frame.
fn in_sight(scene: &Scene, format: PixelFormat) -> Errors {
    let mut errors = Errors::default();
    track(scene, format, |tracked| {
        for ball in Ball::ALL {
            let (truth, seen) = tracked.ball(ball);
            let place = format!("{}, frame {}, {}", scene.name, tracked.frame, ball.name());
            assert!(truth.visible_fraction > 0.999, "{place}: not wholly in sight");
            assert!(seen.state.is_measured(), "{place}: {}", seen.state.name());
            errors.add(tracked, ball);
        }
    });
    errors
}

#[track_caller]
fn hold(what: &str, errors: &Errors, mean: f64, max: f64) {
    let said = format!(
        "{what}: mean {:.4} px (bound {mean}), maximum {:.4} px (bound {max}), {:.2} of the deviation, {} centres",
        errors.mean(),
        errors.max(),
        errors.ratio(),
        errors.px.len()
    );
    println!("{said}");
    assert!(errors.mean() <= mean && errors.max() <= max, "{said}");
}

/// A resting ball in three lights and two formats, and whether the covariance says how good it is.
fn at_rest(diameter: u32, mean: f64, max: f64) {
    let mut pooled = [const { Errors { px: Vec::new(), normalised: 0.0 } }; 2];
    for (light, name) in [(Light::even(), "even"), (Light::side(0.70), "70 %"), (Light::side(0.45), "45 %")] {
        let mut scene = common::scene(&format!("static-{diameter}px"));
        scene.light = light;
        for (format, share) in [(PixelFormat::Rgb888, 1.0), (PixelFormat::Yuyv, 1.5)] {
            let errors = in_sight(&scene, format);
            pooled[usize::from(format == PixelFormat::Yuyv)].pool(&errors);
            hold(&format!("{diameter} px, {name}, {format:?}"), &errors, share * mean, share * max);
        }
    }
    for (errors, format) in pooled.iter().zip(["RGB", "YUYV"]) {
        let said = format!("{diameter} px, {format}: {:.2} of the deviation, lights pooled", errors.ratio());
        println!("{said}");
        assert!((0.7..=1.4).contains(&errors.ratio()), "{said}");
    }
}

macro_rules! sizes {
    ($($name:ident $diameter:literal $mean:literal $max:literal)*) => { $(
        #[test]
        fn $name() {
            at_rest($diameter, $mean, $max);
        }
    )* };
}

sizes! {
    a_ball_of_5_px 5 0.08 0.25
    a_ball_of_8_px 8 0.04 0.12
    a_ball_of_12_px 12 0.04 0.12
    a_ball_of_16_px 16 0.04 0.12
    a_ball_of_24_px 24 0.04 0.12
    a_ball_of_32_px 32 0.04 0.12
    a_ball_of_48_px 48 0.04 0.12
    a_ball_of_65_px 65 0.04 0.12
}

/// Lamps overhead and all around, so that some camera sees the shadow side: the same bounds as for the one
/// of every other test. From several of them yellow, learnt from a bright spot of its own, was once taken
/// for red and never found.
#[test]
fn a_lamp_may_be_anywhere() {
    let around = |degrees: u32| {
        let (v, u) = f64::from(degrees).to_radians().sin_cos();
        [Vector3::new(u, v, 0.0), Vector3::new(0.5 * u, 0.5 * v, 0.866)]
    };
    let overhead = [Vector3::new(0.1, 0.1, 1.0), Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.2, 0.0, 1.0)];
    let lamps = [0, 45, 85, 90, 105, 135, 180, 225, 270, 315].into_iter().flat_map(around).chain(overhead);
    for (lamp, seed) in lamps.flat_map(|lamp| [(lamp, 1), (lamp, 2)]) {
        for diameter in [16, 32] {
            let mut scene = common::scene(&format!("static-{diameter}px"));
            (scene.light, scene.seed, scene.frames) = (Light::side(0.45), seed, 3);
            scene.light.towards = lamp;
            let what = format!("{diameter} px, seed {seed}, lamp {:?}", <[f64; 3]>::from(lamp));
            hold(&what, &in_sight(&scene, PixelFormat::Rgb888), 0.04, 0.12);
        }
    }
}

fn moving(name: &str, exposure_s: f64, mean: f64, max: f64) {
    for (light, of_light) in [(Light::even(), "even"), (Light::side(0.45), "45 %")] {
        let mut scene = common::scene(name);
        scene.light = light;
        scene.exposure_s = exposure_s;
        hold(&format!("{name}, {of_light}"), &in_sight(&scene, PixelFormat::Rgb888), mean, max);
    }
}

#[test]
fn a_line_at_half_a_metre_a_second() {
    moving("linear-0.5-30fps", 0.004, 0.08, 0.3);
}

#[test]
fn a_circle_at_half_a_metre_a_second() {
    moving("circular-0.5-30fps", 0.004, 0.08, 0.3);
}

/// The blur is 4.5 px long. No maximum is set for it.
#[test]
fn a_line_at_0_7_metres_a_second_with_a_slow_shutter() {
    moving("linear-0.7-30fps", 0.008, 0.2, f64::INFINITY);
}

#[test]
fn a_circle_at_0_7_metres_a_second_with_a_slow_shutter() {
    moving("circular-0.7-30fps", 0.008, 0.2, f64::INFINITY);
}

/// Forty per cent of the rim of a ball of 16 px, from four sides and in both lights.
#[test]
fn a_finger_over_the_rim() {
    for (light, of_light) in [(Light::even(), "even"), (Light::side(0.45), "45 %"), (Light::room(), "room")] {
        for from_rad in [0.0, FRAC_PI_2, PI, 4.0] {
            let errors = under_a_finger(from_rad, light.clone());
            hold(&format!("finger from {from_rad:.2}, {of_light}"), &errors, 0.4, f64::INFINITY);
        }
    }
}

/// The green ball of the `finger` scene while the finger rests over it.
fn under_a_finger(from_rad: f64, light: Light) -> Errors {
    let mut scene = common::scene("finger");
    scene.light = light;
    for finger in &mut scene.occluders {
        finger.from_rad = from_rad;
    }
    let mut errors = Errors::default();
    track(&scene, PixelFormat::Rgb888, |tracked| {
        let (_, seen) = tracked.ball(Ball::Green);
        if scene.time_s(tracked.frame) > 1.45 && seen.state.is_measured() {
            errors.add(tracked, Ball::Green);
        }
    });
    assert!(errors.px.len() > 60, "{}: measured in {} frames", scene.name, errors.px.len());
    errors
}

/// Of a ball behind another, the fit is nearer to the truth than eq. 3, and both agree.
#[test]
fn a_ball_behind_another_is_nearer_than_by_equation_3() {
    let scene = common::scene("crossing");
    let (mut fitted, mut equation_3, mut apart) = (Vec::new(), Vec::new(), Vec::new());
    for camera in 0..scene.cameras() {
        let (mut refined, mut paper) = (Vec::new(), Vec::new());
        let mode = |config, list: &mut Vec<_>| {
            common::track_as(&scene, camera, config, PixelFormat::Rgb888, |tracked| {
                list.extend(Ball::ALL.map(|ball| (*tracked.ball(ball).1, tracked.error_px(ball))));
            });
        };
        mode(TrackerConfig::default(), &mut refined);
        mode(TrackerConfig::paper(), &mut paper);
        for ((r, of_r), (p, of_p)) in refined.into_iter().zip(paper) {
            if r.state == ObservationState::Occluded && p.state == ObservationState::Occluded {
                fitted.push(of_r);
                equation_3.push(of_p);
                apart.push(f64::from(r.centre.distance(p.centre)));
            }
        }
    }
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
    let (fitted, equation_3, apart) = (mean(&fitted), mean(&equation_3), mean(&apart));
    println!("crossing: fit {fitted:.3} px, eq. 3 {equation_3:.3} px, apart {apart:.3} px");
    assert!(fitted < equation_3 && apart < 1.0, "{fitted} {equation_3} {apart}");
}

/// In every state the covariance is that of the errors: over plain and cluttered scenes, balls that
/// rest, move, cross, are covered and leave the picture.
#[test]
fn errors_are_as_large_as_the_covariance_says() {
    let mut states = [const { Errors { px: Vec::new(), normalised: 0.0 } }; 3];
    let names = [
        "static-8px",
        "static-16px",
        "static-side-32px",
        "linear-0.5-30fps",
        "circular-0.5-30fps",
        "crossing",
        "cover",
        "cover-all",
        "edge",
        "finger",
        "demo",
    ];
    for name in names {
        let mut scene = common::scene(name);
        scene.frames = scene.frames.min(420);
        track(&scene, PixelFormat::Rgb888, |tracked| {
            for ball in Ball::ALL {
                let (_, seen) = tracked.ball(ball);
                if let Some(errors) = states.get_mut(seen.state as usize) {
                    errors.add(tracked, ball);
                }
            }
        });
    }
    // the covers above are a handful of events, of balls that are hardly moved: a moving hand in the dark
    // is predicted too
    for name in UNSEEN {
        states[ObservationState::Predicted as usize].pool(&unseen(name));
    }
    for (errors, state) in states.iter().zip(["visible", "occluded", "predicted"]) {
        let said = format!("{state}: {:.2} over {} centres", errors.ratio(), errors.px.len());
        println!("{said}");
        assert!(errors.px.len() > 100 && (0.7..=1.4).contains(&errors.ratio()), "{said}");
    }
}

/// Hands that nobody sees for a second, at rest and faster and faster.
const UNSEEN: [&str; 4] = ["static-16px", "circular-0.25-30fps", "circular-0.5-30fps", "circular-0.7-30fps"];

/// Of a hand that nobody sees for a second, calm or fast: where a place is still predicted, it is as
/// far off as its covariance says.
#[test]
fn predictions_are_as_wrong_as_the_covariance_says() {
    let mut all = Errors::default();
    let mut fast = Errors::default();
    for name in UNSEEN {
        let errors = unseen(name);
        let said = format!("{name}: {:.2} over {} predictions", errors.ratio(), errors.px.len());
        println!("{said}");
        assert!(errors.px.len() > 50 && errors.ratio() < 2.0, "{said}");
        all.pool(&errors);
        if ["circular-0.5-30fps", "circular-0.7-30fps"].contains(&name) {
            fast.pool(&errors);
        }
    }
    for (errors, which) in [(all, "all"), (fast, "fast")] {
        let said = format!("{which}: {:.2} over {} predictions", errors.ratio(), errors.px.len());
        println!("{said}");
        assert!((0.7..=1.4).contains(&errors.ratio()), "{said}");
    }
}

/// The predicted balls of a scene whose frames 60 to 89 are black.
fn unseen(name: &str) -> Errors {
    let mut scene = common::scene(name);
    scene.frames = 90;
    let mut errors = Errors::default();
    let dark = |frame: usize, rgb: &mut [u8]| {
        if frame >= 60 {
            rgb.fill(0);
        }
    };
    for camera in 0..scene.cameras() {
        common::track_shown(&scene, camera, TrackerConfig::default(), PixelFormat::Rgb888, dark, |tracked| {
            for ball in Ball::ALL {
                if tracked.ball(ball).1.state == ObservationState::Predicted {
                    errors.add(tracked, ball);
                }
            }
        });
    }
    errors
}
