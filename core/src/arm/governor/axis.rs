//! One joint from set-point to set-point: speed, acceleration and jerk bounded, and always able to
//! stop before the end of its range.
//!
//! Time is counted in cycles and the differences of the set-points ARE the speed, the acceleration
//! and the jerk: `q' = q + v' dt`, `v' = v + a' dt`, and a' within `J dt` of a. So the bounds hold for what
//! is sent, not for a curve between.
//!
//! # Why the bounds always hold
//!
//! There is one way to stop ([`Axis::stopped`]), a function of speed and acceleration alone. A step
//! is taken only if, from where it leads to, stopping that way would keep all bounds to the end. If
//! the step that is wished for fails that, one between it and the stop's own is taken; and the stop's
//! own first step passes, because the step before it was tested the same way.

use crate::real::Real;

/// Steps of a stop that are followed. [`crate::config::GovernorConfig::check`] lets no joint take
/// longer than 2 s, 2,000 cycles at 1000 Hz; roundings at the end may add some.
pub(super) const MAX_STOP_CYCLES: u32 = 2_100;

/// Halvings between the stop and what is wished for.
const HALVINGS: u32 = 4;

/// What one joint may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds<T> {
    /// Seconds from set-point to set-point.
    pub(super) cycle: T,
    /// The largest speed, rad/s.
    pub(super) speed: T,
    /// The largest acceleration, rad/s^2.
    pub(super) acceleration: T,
    /// By how much the acceleration may change in a cycle, rad/s^2.
    pub(super) jerk_cycle: T,
}

/// Where a joint may be, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span<T> {
    pub(super) min: T,
    pub(super) max: T,
}

/// Set-point, speed and acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis<T> {
    pub(super) angle: T,
    pub(super) speed: T,
    pub(super) acceleration: T,
}

fn between<T: Real>(x: T, least: T, most: T) -> T {
    x.max(least).min(most)
}

impl<T: Real> Bounds<T> {
    /// The acceleration from which, falling to 0 by the largest jerk, exactly this change of speed comes
    /// about; with it the change begins. As quick as the jerk allows.
    ///
    /// From m such steps and a rest comes `m (m + 1) / 2` steps of jerk and `(m + 1)` rests.
    pub(super) fn landing(&self, change: T) -> T {
        let half = T::of(0.5);
        let sum = change.abs() / self.cycle;
        let root = (T::one() + T::of(8.0) * sum / self.jerk_cycle).sqrt();
        let whole = ((root - T::one()) * half).floor();
        let steps = self.jerk_cycle * whole * (whole + T::one()) * half;
        let size = (sum + steps) / (whole + T::one());
        if change < T::zero() { -size } else { size }
    }

    /// A joint that brakes rests after so many cycles, however it moved: the acceleration that it has is turned round,
    /// stays, and falls.
    pub(super) fn cycles_to_rest(&self) -> u16 {
        let stays = self.speed / (self.acceleration * self.cycle);
        let turns = self.acceleration / self.jerk_cycle * T::of(3.0);
        // saturating, as such a conversion is
        (stays + turns).ceil().to_f64() as u16
    }

    /// The change of speed that still comes about while an acceleration falls to 0 by the largest jerk.
    fn still_to_come(&self, acceleration: T) -> T {
        let size = acceleration.abs();
        let whole = (size / self.jerk_cycle).floor();
        let sum = whole * size - self.jerk_cycle * whole * (whole + T::one()) * T::of(0.5);
        let change = sum * self.cycle;
        if acceleration < T::zero() { -change } else { change }
    }

    /// The greatest speed from which the joint comes to rest within `way` radians, begun without
    /// acceleration: the acceleration builds up, stays, and falls.
    pub(super) fn stoppable(&self, way: T) -> T {
        let a = self.acceleration;
        // a^2 / 2 J: half of the speed that building up takes away
        let build_up = a * a * self.cycle / (self.jerk_cycle + self.jerk_cycle);
        let gained = (a + a) * way;
        // the difference of root and build-up, written so that little way is not lost in rounding
        gained / ((build_up * build_up + gained).sqrt() + build_up)
    }
}

impl<T: Real> Axis<T> {
    /// At rest.
    pub(super) fn at(angle: T) -> Self {
        Self { angle, speed: T::zero(), acceleration: T::zero() }
    }

    pub(super) fn is_at_rest(&self) -> bool {
        self.speed == T::zero() && self.acceleration == T::zero()
    }

    /// One cycle later with this acceleration.
    pub(super) fn moved(&self, acceleration: T, bounds: &Bounds<T>) -> Self {
        let mut speed = self.speed + acceleration * bounds.cycle;
        // what rounding leaves of a speed that was to be 0
        if speed.abs() <= T::EPSILON * T::of(16.0) * bounds.speed {
            speed = T::zero();
        }
        Self { angle: self.angle + speed * bounds.cycle, speed, acceleration }
    }

    /// Keeps an acceleration within its bound and what jerk allows.
    fn reachable(&self, acceleration: T, bounds: &Bounds<T>) -> T {
        let jerked = between(
            acceleration,
            self.acceleration - bounds.jerk_cycle,
            self.acceleration + bounds.jerk_cycle,
        );
        between(jerked, -bounds.acceleration, bounds.acceleration)
    }

    /// The next cycle on the way to rest, as quick as the bounds allow.
    pub(super) fn stopped(&self, bounds: &Bounds<T>) -> Self {
        self.moved(self.reachable(bounds.landing(-self.speed), bounds), bounds)
    }

    /// The next cycle with the acceleration that comes nearest to the one wished for and from which
    /// the joint can be stopped in its span.
    pub(super) fn stepped(&self, wish: T, bounds: &Bounds<T>, span: Span<T>) -> Self {
        let wished = self.moved(self.reachable(wish, bounds), bounds);
        if wished.is_safe(bounds, span) {
            return wished;
        }
        let mut best = self.stopped(bounds);
        let mut bad = wished.acceleration;
        for _ in 0..HALVINGS {
            let tried = self.moved((best.acceleration + bad) * T::of(0.5), bounds);
            if tried.is_safe(bounds, span) {
                best = tried;
            } else {
                bad = tried.acceleration;
            }
        }
        best
    }

    /// Whether the speed stays bounded and the joint in its span if it is stopped from here on.
    pub(super) fn is_safe(&self, bounds: &Bounds<T>, span: Span<T>) -> bool {
        let peak = self.peak_speed(bounds);
        // written so that NaN is not safe
        let slow = peak.abs() <= bounds.speed && self.speed.abs() <= bounds.speed;
        slow && (self.is_far_from_ends(bounds, span) || self.stops_within(bounds, span))
    }

    /// Whether a stop cannot come near to the ends: greatest speed times longest time.
    fn is_far_from_ends(&self, bounds: &Bounds<T>, span: Span<T>) -> bool {
        let way = self.farthest_stop(bounds);
        self.angle - way >= span.min && self.angle + way <= span.max
    }

    /// More than it goes until it is stopped, radians: greatest speed times longest time.
    pub(super) fn farthest_stop(&self, bounds: &Bounds<T>) -> T {
        let per_jerk = bounds.cycle / bounds.jerk_cycle;
        let turning = self.acceleration.abs() * per_jerk + bounds.cycle;
        let fastest = self.speed.abs() + self.acceleration.abs() * turning;
        let build_up = (bounds.acceleration + bounds.acceleration) * per_jerk;
        let time = turning + fastest / bounds.acceleration + build_up + bounds.cycle * T::of(4.0);
        fastest * time
    }

    /// The speed that it comes to when its acceleration is taken away as fast as jerk allows.
    pub(super) fn peak_speed(&self, bounds: &Bounds<T>) -> T {
        self.speed + bounds.still_to_come(self.acceleration)
    }

    /// The same after a cycle with this acceleration.
    pub(super) fn peak_speed_with(&self, acceleration: T, bounds: &Bounds<T>) -> T {
        self.speed + acceleration * bounds.cycle + bounds.still_to_come(acceleration)
    }

    fn stops_within(&self, bounds: &Bounds<T>, span: Span<T>) -> bool {
        let mut axis = *self;
        for _ in 0..MAX_STOP_CYCLES {
            if !(axis.angle >= span.min && axis.angle <= span.max) {
                return false;
            }
            if axis.is_at_rest() {
                return true;
            }
            axis = axis.stopped(bounds);
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::teleop::tests::{Random, sequences};

    fn bounds(random: &mut Random) -> Bounds<f64> {
        let cycle = [0.001, 0.004, 0.01, 0.1][(random.bits() % 4) as usize];
        let acceleration = random.within(2.0, 40.0);
        let build_up = random.within(0.02, 0.3);
        Bounds {
            cycle,
            speed: random.within(0.1, 5.0),
            acceleration,
            jerk_cycle: acceleration / build_up * cycle,
        }
    }

    #[test]
    fn an_acceleration_that_lands_brings_about_its_change_and_no_more() {
        let mut random = Random::new(1);
        for _ in 0..sequences(20_000) {
            let bounds = bounds(&mut random);
            let change = random.within(-5.0, 5.0);
            let landing = bounds.landing(change);
            let total = landing * bounds.cycle + bounds.still_to_come(landing);
            assert!((total - change).abs() < 1e-12, "{change}: {total}");
        }
    }

    #[test]
    fn random_wishes_never_break_a_bound() {
        let mut random = Random::new(2);
        let (mut ends, mut at_speed) = (0, 0);
        for _ in 0..sequences(4_000) {
            let bounds = bounds(&mut random);
            let span = Span { min: -random.within(0.01, 2.0), max: random.within(0.01, 2.0) };
            let mut axis = Axis::at(random.within(span.min, span.max));
            let mut wish = 0.0;
            let (mut angle, mut speed, mut acceleration) = (axis.angle, 0.0, 0.0);
            for _ in 0..300 {
                if random.chance(0.05) {
                    wish = random.within(-2.0, 2.0) * bounds.acceleration;
                }
                axis = axis.stepped(wish, &bounds, span);
                let v = (axis.angle - angle) / bounds.cycle;
                let a = (v - speed) / bounds.cycle;
                let j = (a - acceleration) / bounds.cycle;
                // what the rounding of angles near 1 makes of differences
                let noise = 4e-16 / bounds.cycle;
                assert!(v.abs() <= bounds.speed + 2.0 * noise, "{v} {bounds:?}");
                let noise = 2.0 * noise / bounds.cycle;
                assert!(a.abs() <= bounds.acceleration + 2.0 * noise, "{a} {bounds:?}");
                let noise = 2.0 * noise / bounds.cycle;
                assert!(j.abs() <= bounds.jerk_cycle / bounds.cycle + 2.0 * noise, "{j} {bounds:?}");
                assert!(axis.angle >= span.min && axis.angle <= span.max, "{axis:?} {span:?}");
                ends += usize::from((axis.angle - span.max).abs().min(axis.angle - span.min) < 1e-3);
                at_speed += usize::from(v.abs() > 0.95 * bounds.speed);
                (angle, speed, acceleration) = (axis.angle, v, a);
            }
        }
        assert!(ends > 100 && at_speed > 100, "{ends} at an end, {at_speed} at full speed");
    }

    #[test]
    fn a_stop_ends_in_time_and_the_quick_test_only_passes_what_stops() {
        let mut random = Random::new(3);
        let mut passed = 0;
        for _ in 0..sequences(20_000) {
            let bounds = bounds(&mut random);
            let mut axis = Axis {
                angle: 0.0,
                speed: random.within(-1.0, 1.0) * bounds.speed,
                acceleration: random.within(-1.0, 1.0) * bounds.acceleration,
            };
            let wide = Span { min: -100.0, max: 100.0 };
            if !axis.is_safe(&bounds, wide) {
                continue;
            }
            let side = random.within(0.0, 4.0);
            let span = Span { min: -side, max: side };
            if axis.is_far_from_ends(&bounds, span) {
                passed += 1;
                assert!(axis.stops_within(&bounds, span), "{axis:?} {bounds:?}");
            }
            let build_up = 2.0 * bounds.acceleration * bounds.cycle / bounds.jerk_cycle;
            let longest = 2.0 * build_up + 2.0 * bounds.speed / bounds.acceleration + 8.0 * bounds.cycle;
            let mut cycles = 0.0;
            while !axis.is_at_rest() {
                axis = axis.stopped(&bounds);
                cycles += 1.0;
                assert!(cycles * bounds.cycle < longest, "{axis:?} {bounds:?}");
            }
        }
        assert!(passed > 100, "{passed}");
    }
}
