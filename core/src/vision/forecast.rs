//! How wrong a predicted place is, told by how wrong the predictions of the same ball have been.
//!
//! In every frame in which a ball is measured its prediction can be judged: the excess of the error
//! over the centre's noise gives an acceleration, and that grows with the time as `a (t^2 / 2 + lag t)`,
//! where the lag is that of the last difference. Once the prediction stands still, the ball's usual
//! speed tells how far it may have gone since. Where the other balls of a rigid frame carry it, what
//! counts is how fast it has been leaving the places that they carry it to.

use crate::geometry::ImagePoint;

/// How far ahead the linear prediction reaches, microseconds: past that a hand has turned round.
pub(super) const MAX_EXTRAPOLATION_US: u64 = 150_000;

/// By how much the speed between two frames is late, in frames.
const LAG_FRAMES: f32 = 0.5;

/// The variance of a one-step prediction's error in variances of a centre: x(t+1) - 2 x(t) + x(t-1).
const NOISE_OF_SURPRISE: f32 = 6.0;

/// The variance of a difference in variances of a centre.
const NOISE_OF_DIFFERENCE: f32 = 2.0;

/// Frames over which accelerations and speeds are averaged.
const MEMORY: f32 = 60.0;

/// What a ball does before it was seen to move: diameters a second squared and a second.
const FIRST_ACCELERATION: f32 = 1.0;
const FIRST_SPEED: f32 = 0.5;

/// Their weight in frames.
const FIRST_WEIGHT: f32 = 3.0;

/// The standard deviation of the predictions of calm hands, in diameters: it grows with the time and
/// its square, since a hand that rests may begin to move.
const CALM: [f32; 3] = [0.005, 0.14, 0.12];

/// A mean square that forgets.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MeanSquare {
    sum: f32,
    weight: f32,
}

impl MeanSquare {
    fn new(first: f32) -> Self {
        Self { sum: first * first * FIRST_WEIGHT, weight: FIRST_WEIGHT }
    }

    /// A value whose square may come out negative: noise was taken off.
    fn add(&mut self, square: f32) {
        let kept = 1.0 - 1.0 / MEMORY;
        self.sum = self.sum * kept + square;
        self.weight = self.weight * kept + 1.0;
    }

    fn get(&self) -> f32 {
        (self.sum / self.weight).max(0.0)
    }
}

/// What one frame says of the prediction that was made for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    /// Where the ball is.
    pub(super) measured: ImagePoint,
    /// Where it was in the frame before.
    pub(super) before: ImagePoint,
    /// Where it was expected.
    pub(super) predicted: ImagePoint,
    /// Where the others carried it.
    pub(super) carried: Option<ImagePoint>,
    /// Of the measured centre along an axis, pixels squared.
    pub(super) variance: f32,
    /// Seconds since the frame before.
    pub(super) s: f32,
}

/// How a ball has surprised, pixels and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Forecast {
    acceleration: MeanSquare,
    speed: MeanSquare,
    /// Against the other balls.
    carried_speed: MeanSquare,
    /// Of the last measured centre.
    variance: f32,
    /// Between the last two measured frames.
    interval_s: f32,
}

impl Forecast {
    /// Of a ball of `diameter` pixels that was not seen to move.
    pub(super) fn new(diameter: f32) -> Self {
        Self {
            acceleration: MeanSquare::new(FIRST_ACCELERATION * diameter),
            speed: MeanSquare::new(FIRST_SPEED * diameter),
            carried_speed: MeanSquare::new(FIRST_SPEED * diameter),
            variance: 0.0,
            interval_s: 0.0,
        }
    }

    /// Learns from a ball that was predicted and measured.
    pub(super) fn learn(&mut self, outcome: &Outcome) {
        let Outcome { measured, before, predicted, carried, variance, s } = *outcome;
        // after a gap, and before there is a speed, an error says little
        let regular = self.interval_s > 0.0 && s < 1.5 * self.interval_s;
        if regular {
            let lateness = s * s * (0.5 + LAG_FRAMES);
            let excess = square(measured - predicted) - variance * NOISE_OF_SURPRISE;
            self.acceleration.add(excess / (lateness * lateness));
            let per = 1.0 / (s * s);
            self.speed.add((square(measured - before) - variance * NOISE_OF_DIFFERENCE) * per);
            if let Some(carried) = carried {
                self.carried_speed.add((square(measured - carried) - variance * NOISE_OF_DIFFERENCE) * per);
            }
        }
        self.variance = variance;
        self.interval_s = s;
    }

    /// The standard deviation along an axis, pixels, of a place predicted for a ball of `diameter`
    /// that was measured `absent_us` ago.
    pub(super) fn sigma(&self, diameter: f32, absent_us: u64) -> f32 {
        let s = absent_us.min(MAX_EXTRAPOLATION_US) as f32 * 1e-6;
        let held_s = absent_us.saturating_sub(MAX_EXTRAPOLATION_US) as f32 * 1e-6;
        let frames = if self.interval_s > 0.0 { s / self.interval_s } else { 0.0 };
        let of_velocity = 2.0 * frames + 2.0 * frames * frames;
        let travel = s * s * 0.5 + LAG_FRAMES * self.interval_s * s;
        let grown = self.acceleration.get() * travel * travel + self.strayed2(held_s);
        libm::sqrtf(calm2(diameter, absent_us) + self.variance * of_velocity + grown)
    }

    /// The same of a place where the other balls have carried it.
    pub(super) fn carried_sigma(&self, diameter: f32, absent_us: u64) -> f32 {
        let s = absent_us as f32 * 1e-6;
        libm::sqrtf(calm2(diameter, absent_us) + self.carried_speed.get() * s * s)
    }

    /// How far it has gone in a time, the mean square along an axis.
    fn strayed2(&self, s: f32) -> f32 {
        self.speed.get() * s * s
    }
}

/// The variance of the predictions of a calm hand.
fn calm2(diameter: f32, absent_us: u64) -> f32 {
    let s = absent_us as f32 * 1e-6;
    let [at_once, with_time, with_square] = CALM;
    let sigma = diameter * (at_once + (with_time + with_square * s) * s);
    sigma * sigma
}

/// The mean square along an axis.
fn square(v: ImagePoint) -> f32 {
    (v.u * v.u + v.v * v.v) * 0.5
}
