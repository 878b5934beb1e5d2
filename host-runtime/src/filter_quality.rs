//! How late and how noisy a setting of the pose filter is, on a simulated hand whose truth is known.
//!
//! The hand rests, and then goes round a circle at constant speed while it turns at a constant rate,
//! measured at a camera's rate with normally distributed errors. [`Tracked`] is also of use by itself,
//! for poses of any hand whose truth is known.

use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;
use tetrad_core::config::{FilterConfig, FilterConfigError};
use tetrad_core::geometry::Pose;
use tetrad_core::hand::filter::PoseFilter;

/// The simulated hand and its measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatedHand {
    /// Measurements a second.
    pub fps: f64,
    /// Standard deviation of each coordinate of a measured place, metres.
    pub noise_m: f64,
    /// The same of the rotation vector of the error of a measured orientation, radians.
    pub noise_rad: f64,
    /// How fast it goes once it goes, m/s.
    pub speed_m_s: f64,
    /// How fast it turns then, rad/s.
    pub turn_rad_s: f64,
    /// How long it rests, and how long it moves, seconds.
    pub seconds: f64,
    /// Of the random errors.
    pub seed: u64,
}

impl Default for SimulatedHand {
    fn default() -> Self {
        Self {
            fps: 30.0,
            noise_m: 0.5e-3,
            noise_rad: 5e-3,
            speed_m_s: 0.5,
            turn_rad_s: 1.0,
            seconds: 20.0,
            seed: 1,
        }
    }
}

/// Radius of the circle: that of the paper's section 5.
const RADIUS_M: f64 = 0.1;

/// What is left out at the beginning of rest and motion, until the filter has settled, seconds.
const SETTLING_S: f64 = 2.0;

/// What a filter makes of a [`SimulatedHand`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterQuality {
    /// At rest, as measured.
    pub rest_in: Noise,
    /// At rest, as filtered.
    pub rest_out: Noise,
    /// In motion.
    pub moving: Tracked,
}

/// Root mean square of a coordinate about the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Of the place, metres.
    pub place_m: f64,
    /// Of the rotation vector of the error, radians.
    pub turn_rad: f64,
}

/// A moving hand as it should have been given, and as it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Where the hand is at the time the pose is meant for: that of the frame plus the lead.
    pub truth: Pose,
    /// Its velocity then, m/s, in the axes of the pose.
    pub velocity: Vector3<f64>,
    /// Its angular velocity then, rad/s, in the same axes.
    pub turn_rate: Vector3<f64>,
    /// The pose that was given.
    pub given: Pose,
}

/// How poses follow a moving hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tracked {
    /// The delay that explains most of the error of the place, seconds: negative when it runs ahead.
    pub lag_s: f64,
    /// The same of the orientation.
    pub turn_lag_s: f64,
    /// Root mean square distance from the truth, metres.
    pub error_m: f64,
    /// Root mean square angle from the truth, radians.
    pub error_rad: f64,
}

impl Tracked {
    /// Least squares over the samples: `error = -lag velocity`. Zero of no samples or no motion.
    #[must_use]
    pub fn of(samples: impl IntoIterator<Item = Sample>) -> Self {
        let (mut place, mut turn) = (Delay::default(), Delay::default());
        for sample in samples {
            let (moved, turned) = difference(&sample.given, &sample.truth);
            place.add(&moved, &sample.velocity);
            turn.add(&turned, &sample.turn_rate);
        }
        Self {
            lag_s: place.lag_s(),
            turn_lag_s: turn.lag_s(),
            error_m: place.root_mean_square(),
            error_rad: turn.root_mean_square(),
        }
    }
}

/// Sums of a least squares fit of a delay.
#[derive(Clone, Copy, Debug, Default)]
struct Delay {
    count: f64,
    squares: f64,
    along: f64,
    speeds: f64,
}

impl Delay {
    fn add(&mut self, error: &Vector3<f64>, velocity: &Vector3<f64>) {
        self.count += 1.0;
        self.squares += error.norm_squared();
        self.along += error.dot(velocity);
        self.speeds += velocity.norm_squared();
    }

    fn lag_s(&self) -> f64 {
        if self.speeds > 0.0 { -self.along / self.speeds } else { 0.0 }
    }

    fn root_mean_square(&self) -> f64 {
        (self.squares / self.count.max(1.0)).sqrt()
    }
}

/// Given minus true: metres, and the rotation vector w of `R_given = exp(w) R_true`.
fn difference(given: &Pose, truth: &Pose) -> (Vector3<f64>, Vector3<f64>) {
    let turned = given.rotation.cast::<f64>() * truth.rotation.cast::<f64>().transpose();
    let moved = given.translation.cast::<f64>() - truth.translation.cast::<f64>();
    (moved, Rotation3::from_matrix_unchecked(turned).scaled_axis())
}

/// Measures a setting of the filter.
///
/// # Errors
/// [`FilterConfigError`] for a setting that cannot be worked with.
pub fn measure(config: &FilterConfig, hand: &SimulatedHand) -> Result<FilterQuality, FilterConfigError> {
    let lead_s = f64::from(config.lead_us) * 1e-6;
    let mut random = Random(hand.seed);
    let mut filter = PoseFilter::new(*config)?;
    let (mut rest_in, mut rest_out) = (Delay::default(), Delay::default());
    let (mut turned_in, mut turned_out) = (Delay::default(), Delay::default());
    let still = Vector3::zeros();
    for (t_us, t_s) in hand.times() {
        let truth = hand.truth(0.0).truth;
        let measured = hand.measured(&truth, &mut random);
        let given = filter.measure(t_us, &measured).unwrap_or(measured);
        if t_s >= SETTLING_S {
            for (pose, place, turn) in
                [(&measured, &mut rest_in, &mut turned_in), (&given, &mut rest_out, &mut turned_out)]
            {
                let (moved, turned) = difference(pose, &truth);
                place.add(&moved, &still);
                turn.add(&turned, &still);
            }
        }
    }
    filter.reset();
    let mut samples = Vec::new();
    for (t_us, t_s) in hand.times() {
        let measured = hand.measured(&hand.truth(t_s).truth, &mut random);
        let given = filter.measure(t_us, &measured).unwrap_or(measured);
        if t_s >= SETTLING_S {
            samples.push(Sample { given, ..hand.truth(t_s + lead_s) });
        }
    }
    let noise = |place: Delay, turn: Delay| Noise {
        place_m: place.root_mean_square() / 3.0_f64.sqrt(),
        turn_rad: turn.root_mean_square() / 3.0_f64.sqrt(),
    };
    Ok(FilterQuality {
        rest_in: noise(rest_in, turned_in),
        rest_out: noise(rest_out, turned_out),
        moving: Tracked::of(samples),
    })
}

impl SimulatedHand {
    /// The times of the measurements, in microseconds and seconds.
    fn times(&self) -> impl Iterator<Item = (u64, f64)> + use<> {
        let fps = self.fps;
        (0..(self.seconds * fps) as u64).map(move |frame| {
            let t_us = (frame as f64 * 1e6 / fps).round() as u64;
            (t_us, t_us as f64 * 1e-6)
        })
    }

    /// The hand after moving for `t_s` seconds; `given` is the truth as well.
    fn truth(&self, t_s: f64) -> Sample {
        let round = self.speed_m_s / RADIUS_M;
        let (sin, cos) = (round * t_s).sin_cos();
        let turn_rate = Vector3::new(1.0, 2.0, -2.0) / 3.0 * self.turn_rad_s;
        let rotation = *Rotation3::new(turn_rate * t_s).matrix();
        let translation = Vector3::new(0.8 * cos, sin, 0.6 * cos) * RADIUS_M;
        let velocity = Vector3::new(-0.8 * sin, cos, -0.6 * sin) * self.speed_m_s;
        let truth = Pose { rotation: rotation.cast(), translation: translation.cast() };
        Sample { truth, velocity, turn_rate, given: truth }
    }

    fn measured(&self, truth: &Pose, random: &mut Random) -> Pose {
        let error = random.normal_vector() * self.noise_m;
        let turn = Rotation3::new(random.normal_vector() * self.noise_rad).matrix().cast::<f32>();
        Pose { translation: truth.translation + error.cast::<f32>(), rotation: turn * truth.rotation }
    }
}

/// SplitMix64 (Steele, Lea and Flood, 2014): enough for errors of measurement, and the same everywhere.
struct Random(u64);

impl Random {
    /// Evenly between 0 and 1, both excluded.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// Three standard normal numbers (Box and Muller).
    fn normal_vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| (-2.0 * self.unit().ln()).sqrt() * (TAU * self.unit()).cos())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::config::{Prediction, Smoothing};

    fn quality(config: FilterConfig) -> FilterQuality {
        measure(&config, &SimulatedHand::default()).unwrap()
    }

    #[test]
    fn the_measurement_measures_what_was_put_in() {
        let raw = quality(FilterConfig { smoothing: Smoothing::Off, ..FilterConfig::default() });
        assert_eq!(raw.rest_in, raw.rest_out);
        assert!((raw.rest_in.place_m - 0.5e-3).abs() < 0.02e-3, "{raw:?}");
        assert!((raw.rest_in.turn_rad - 5e-3).abs() < 0.2e-3, "{raw:?}");
        assert!(raw.moving.lag_s.abs() < 2e-4 && raw.moving.turn_lag_s.abs() < 2e-3, "{raw:?}");
        assert!((raw.moving.error_m - 0.5e-3 * 3.0_f64.sqrt()).abs() < 0.05e-3, "{raw:?}");

        // a pose told 40 ms late
        let hand = SimulatedHand::default();
        let late =
            hand.times().map(|(_, t_s)| Sample { given: hand.truth(t_s - 0.04).truth, ..hand.truth(t_s) });
        let tracked = Tracked::of(late);
        assert!(
            (tracked.lag_s - 0.04).abs() < 5e-4 && (tracked.turn_lag_s - 0.04).abs() < 5e-4,
            "{tracked:?}"
        );
        assert_eq!(Tracked::of([]), Tracked::default());
    }

    /// The promise of the defaults, and of both models of motion.
    #[test]
    fn a_hand_at_rest_is_quiet_and_a_moving_one_is_less_than_a_frame_late() {
        let frame_s = 1.0 / SimulatedHand::default().fps;
        for prediction in [Prediction::Velocity, Prediction::Acceleration] {
            let one_euro = quality(FilterConfig { prediction, ..FilterConfig::default() });
            let (rest, moving) = (one_euro.rest_out, one_euro.moving);
            assert!(rest.place_m < 0.4 * one_euro.rest_in.place_m, "{one_euro:?}");
            assert!(rest.turn_rad < 0.45 * one_euro.rest_in.turn_rad, "{one_euro:?}");
            assert!(moving.lag_s < 0.5 * frame_s && moving.turn_lag_s < frame_s, "{one_euro:?}");
        }
    }

    #[test]
    fn a_lead_brings_the_pose_forward() {
        let led = |prediction| {
            let smoothing = Smoothing::Off;
            quality(FilterConfig { smoothing, prediction, lead_us: 50_000, ..FilterConfig::default() })
        };
        // the circle is all acceleration, 2.5 m/s^2 off the tangent, and the hand has moved 25 mm by then
        let (velocity, acceleration) = (led(Prediction::Velocity), led(Prediction::Acceleration));
        assert!(velocity.moving.lag_s < 0.015 && acceleration.moving.lag_s.abs() < 0.01);
        assert!(acceleration.moving.error_m < 0.5 * velocity.moving.error_m, "{velocity:?} {acceleration:?}");
        assert!(velocity.rest_out.place_m < acceleration.rest_out.place_m, "steadier at rest");
    }
}
