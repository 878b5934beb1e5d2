//! How wrong a predicted place is, told by how wrong the predictions of the same ball have been.
//!
//! In every frame in which a ball is measured its prediction can be judged: the excess of the error
//! over the centre's noise gives an acceleration, from which follows how far off it is later
//! (`crate::unseen`). Where the other balls of a rigid frame carry it, what
//! counts is how fast it has been leaving the places that they carry it to.

use crate::geometry::ImagePoint;
use crate::unseen::{Moved, Unseen};

/// How far ahead the linear prediction reaches, microseconds: past that a hand has turned round.
pub(super) const MAX_EXTRAPOLATION_US: u64 = 150_000;

/// By how much the speed between two frames is late, in frames.
const LAG_FRAMES: f32 = 0.5;

/// A noise that is plainly less than what a moving ball does in a frame, pixels. Centres in full sight
/// are known to 0.01 to 0.05 px, slivers to 0.2 and more: this lies between.
const PLAIN_PX: f32 = 0.1;

/// The variance of a one-step prediction's error in variances of a centre: x(t+1) - 2 x(t) + x(t-1).
const NOISE_OF_SURPRISE: f32 = 6.0;

/// The variance of a difference in variances of a centre.
const NOISE_OF_DIFFERENCE: f32 = 2.0;

/// Frames over which accelerations and speeds are averaged.
const MEMORY: f32 = 60.0;

/// A frame that comes so many times later or sooner than the last one did is not regular: half way to a
/// frame that was lost.
const IRREGULAR: f32 = 1.5;

/// What a ball does before it was seen to move: diameters a second squared and a second. A hand that
/// rests moves a little: 20 mm balls give 0.02 m/s^2 and 0.01 m/s.
const FIRST_ACCELERATION: f32 = 1.0;
const FIRST_SPEED: f32 = 0.5;

/// Their weight in frames: outweighed by what is seen in a tenth of a second.
const FIRST_WEIGHT: f32 = 3.0;

/// The standard deviation of the predictions of calm hands, in diameters: it grows with the time and
/// its square, since a hand that rests may begin to move. Set by hand so that the errors of
/// predicted places come out honest in the simulated scenes in which the hand rests or moves slowly.
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

    /// A square of which `noise` is to be taken off: it may come out negative. What is mostly noise
    /// says little of the rest, and must not outweigh what was plain to see.
    fn add(&mut self, square: f32, noise: f32, plain: f32) {
        let share = plain / (plain + noise);
        let weight = share * share;
        let kept = 1.0 - 1.0 / MEMORY;
        self.sum = self.sum * kept + (square - noise) * weight;
        self.weight = self.weight * kept + weight;
    }

    fn get(&self) -> f32 {
        if self.weight > 0.0 { (self.sum / self.weight).max(0.0) } else { 0.0 }
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
    /// Of a ball that begins to move.
    begins2: f32,
    /// Pixels a second, in which what was seen well counts most.
    velocity: ImagePoint,
    /// Its variance along an axis; infinite while nothing is known of it.
    velocity2: f32,
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
            begins2: FIRST_ACCELERATION * diameter * FIRST_ACCELERATION * diameter,
            velocity: ImagePoint::default(),
            velocity2: f32::INFINITY,
        }
    }

    /// The ball was not seen, or came back from somewhere else.
    pub(super) fn interrupted(&mut self) {
        self.velocity = ImagePoint::default();
        self.velocity2 = f32::INFINITY;
    }

    /// Learns from a ball that was predicted and measured.
    pub(super) fn learn(&mut self, outcome: &Outcome) {
        let Outcome { measured, before, predicted, carried, variance, s } = *outcome;
        // after a gap there is no speed yet: the next error tells of the gap, not of an acceleration
        let frames = s / self.interval_s;
        let regular = self.velocity2.is_finite() && frames < IRREGULAR && frames * IRREGULAR > 1.0;
        if regular {
            let lateness = s * s * (0.5 + LAG_FRAMES);
            let learn = |of: &mut MeanSquare, error: ImagePoint, share: f32, s: f32| {
                let plain = (PLAIN_PX * PLAIN_PX).max(of.get() * s * s);
                let per = 1.0 / (s * s);
                of.add(square(error) * per, share * variance * per, plain * per);
            };
            learn(&mut self.acceleration, measured - predicted, NOISE_OF_SURPRISE, lateness);
            learn(&mut self.speed, measured - before, NOISE_OF_DIFFERENCE, s);
            if let Some(carried) = carried {
                learn(&mut self.carried_speed, measured - carried, NOISE_OF_DIFFERENCE, s);
            }
        }
        let noise2 = (variance + self.variance) / (s * s);
        let newest = (measured - before) * (1.0 / s);
        if regular {
            // its variance now, when it may have changed
            let changed2 = self.velocity2 + self.acceleration.get().max(self.begins2) * s * s;
            let gain = changed2 / (changed2 + noise2);
            self.velocity = self.velocity + (newest - self.velocity) * gain;
            self.velocity2 = gain * noise2;
        } else {
            (self.velocity, self.velocity2) = (newest, noise2);
        }
        self.variance = variance;
        self.interval_s = s;
    }

    /// The standard deviation along an axis, pixels, of a place predicted for a ball of `diameter`
    /// that was measured `absent_us` ago.
    pub(super) fn sigma(&self, diameter: f32, absent_us: u64) -> f32 {
        let carried_s = absent_us.min(MAX_EXTRAPOLATION_US) as f32 * 1e-6;
        let held_s = absent_us.saturating_sub(MAX_EXTRAPOLATION_US) as f32 * 1e-6;
        let unseen = Unseen { carried_s, held_s, lag_s: LAG_FRAMES * self.interval_s };
        let frames = if self.interval_s > 0.0 { carried_s / self.interval_s } else { 0.0 };
        let of_velocity = 2.0 * frames + 2.0 * frames * frames;
        let (acceleration2, usual2) = (self.acceleration.get(), self.speed.get());
        let strayed2 = unseen.strayed2(&Moved { acceleration2, usual2, last2: self.last2(usual2) });
        libm::sqrtf(calm2(diameter, absent_us) + self.variance * of_velocity + strayed2)
    }

    /// The same of a place where the other balls have carried it.
    pub(super) fn carried_sigma(&self, diameter: f32, absent_us: u64) -> f32 {
        let s = absent_us as f32 * 1e-6;
        libm::sqrtf(calm2(diameter, absent_us) + self.carried_speed.get() * s * s)
    }

    /// The mean square of its last speed along an axis: of a velocity that is mostly noise little is
    /// believed, and the rest may be as usual.
    fn last2(&self, usual2: f32) -> f32 {
        let both = usual2 + self.velocity2;
        if both > 0.0 && both.is_finite() {
            let believed = usual2 / both;
            square(self.velocity) * believed * believed + usual2 * (1.0 - believed)
        } else {
            usual2
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    const D: f32 = 16.0;
    const S: f32 = 1.0 / 30.0;
    const GOOD: f32 = 0.02 * 0.02;

    /// A ball on a parabola, 60 frames of it, predicted by the two frames before.
    fn along(acceleration: f32) -> (Forecast, impl Fn(f32) -> ImagePoint) {
        let at = move |s: f32| ImagePoint::new(60.0 * s + 0.5 * acceleration * s * s, 0.0);
        let mut forecast = Forecast::new(D);
        for frame in 1..60_u8 {
            let s = f32::from(frame) * S;
            forecast.learn(&outcome(at, s, GOOD));
        }
        (forecast, at)
    }

    fn outcome(at: impl Fn(f32) -> ImagePoint, s: f32, variance: f32) -> Outcome {
        let (before, earlier) = (at(s - S), at(s - 2.0 * S));
        let predicted = before + (before - earlier);
        Outcome { measured: at(s), before, predicted, carried: None, variance, s: S }
    }

    #[test]
    fn what_a_gap_feigns_is_not_learnt() {
        let (mut forecast, at) = along(5.0);
        let before = forecast.sigma(D, 150_000);
        // back after a second, and predicted where it was found: it had no velocity yet
        forecast.interrupted();
        let back = 3.0;
        let found = at(back - S);
        forecast.learn(&Outcome { predicted: found, ..outcome(&at, back, GOOD) });
        forecast.learn(&outcome(&at, back + S, GOOD));
        let after = forecast.sigma(D, 150_000);
        assert!((after / before - 1.0).abs() < 0.1, "{before} then {after}");
    }

    #[test]
    fn a_sliver_that_is_poorly_known_wipes_out_nothing() {
        let (mut forecast, at) = along(200.0);
        let before = forecast.sigma(D, 400_000);
        forecast.learn(&outcome(&at, 2.0, 1.0));
        // the variance of the last place itself is not the movement's
        forecast.variance = GOOD;
        let after = forecast.sigma(D, 400_000);
        assert!((after / before - 1.0).abs() < 0.1, "{before} then {after}");
    }

    #[test]
    fn a_ball_that_has_just_begun_to_move_is_thought_to_go_on() {
        let begins = |s: f32| ImagePoint::new(if s > 1.6 { 60.0 * (s - 1.6) } else { 0.0 }, 0.0);
        let mut forecast = Forecast::new(D);
        for frame in 2..60_u8 {
            forecast.learn(&outcome(begins, f32::from(frame) * S, GOOD));
        }
        // 0.35 s after it is held it will be 21 px away: 15 px along an axis
        let sigma = forecast.sigma(D, 500_000);
        assert!((10.0..25.0).contains(&sigma), "{sigma}");
    }
}
