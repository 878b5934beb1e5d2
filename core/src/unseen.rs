//! How far something goes while nobody sees it, told by how it has been moving.
//!
//! Its last velocity is carried on for a while; then its place is held. What is wrong with the place
//! has two parts. It goes where nobody knows, by the acceleration `a` that it was seen to have: that
//! grows with the time as `a (t^2 / 2 + lag t)`, where the lag is that of the velocity, but no farther
//! than its usual speed takes it. And from the held place it goes on as it went, the less of its
//! velocity being left the sooner the acceleration uses up such a speed.
//!
//! All in mean squares along an axis. A direction is not told: a hand turns aside too easily for a
//! covariance that is long along its last velocity alone.

/// A time without sight, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unseen {
    /// While its velocity was carried on.
    pub(crate) carried_s: f32,
    /// While its place was held, after that.
    pub(crate) held_s: f32,
    /// By how much the velocity was late at the beginning.
    pub(crate) lag_s: f32,
}

/// How it moved, mean squares along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moved {
    /// Of its acceleration.
    pub(crate) acceleration2: f32,
    /// Of its speed in the last seconds.
    pub(crate) usual2: f32,
    /// Of its speed when it was last seen.
    pub(crate) last2: f32,
}

impl Unseen {
    /// How far the place may be off.
    pub(crate) fn strayed2(&self, moved: &Moved) -> f32 {
        let Self { carried_s, held_s, lag_s } = *self;
        let Moved { acceleration2, usual2, last2 } = *moved;
        let speed2 = usual2.max(last2);
        let travel = |s: f32| s * (0.5 * s + lag_s);
        let (carried, whole) = (travel(carried_s), travel(carried_s + held_s));
        let whole_s = carried_s + held_s;
        let aside2 = lesser(acceleration2 * whole * whole, speed2 * whole_s * whole_s);
        let half_way_s = lag_s + carried_s + 0.5 * held_s;
        let left = share(speed2, acceleration2 * half_way_s * half_way_s);
        aside2.max(acceleration2 * carried * carried) + left * last2 * held_s * held_s
    }
}

/// Near the lesser of two squares, and under both.
fn lesser(a: f32, b: f32) -> f32 {
    a * share(b, a)
}

/// The share of `a` in both.
fn share(a: f32, b: f32) -> f32 {
    let both = a + b;
    if both > 0.0 { a / both } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNSEEN: Unseen = Unseen { carried_s: 0.15, held_s: 0.5, lag_s: 0.02 };

    fn moved(acceleration: f32, usual: f32, last: f32) -> Moved {
        Moved { acceleration2: acceleration * acceleration, usual2: usual * usual, last2: last * last }
    }

    fn strayed(unseen: &Unseen, moved: &Moved) -> f32 {
        libm::sqrtf(unseen.strayed2(moved))
    }

    #[test]
    fn what_goes_straight_on_is_off_by_its_way_since_it_is_held() {
        let off = strayed(&UNSEEN, &moved(0.0, 0.3, 0.3));
        assert!((off - 0.15).abs() < 1e-6, "{off}");
        let carried = Unseen { held_s: 0.0, ..UNSEEN };
        assert_eq!(strayed(&carried, &moved(0.0, 0.3, 0.3)), 0.0);
    }

    #[test]
    fn a_bend_grows_with_the_square_of_the_time_while_the_velocity_is_carried_on() {
        let carried = Unseen { held_s: 0.0, ..UNSEEN };
        let off = strayed(&carried, &moved(2.0, 0.3, 0.3));
        assert!((off - 2.0 * (0.5 * 0.15 * 0.15 + 0.02 * 0.15)).abs() < 1e-6, "{off}");
    }

    #[test]
    fn what_turns_round_is_off_no_farther_than_its_speed_takes_it() {
        for acceleration in [1e1, 1e3, 1e6] {
            // carried on for no time: what is known of the bend by then is not capped
            let held = Unseen { carried_s: 0.0, ..UNSEEN };
            let off = strayed(&held, &moved(acceleration, 0.3, 0.1));
            assert!(off > 0.1 && off < 0.3 * 0.5 + 1e-3, "{acceleration}: {off}");
        }
        // from a turning point it may be off as far as it bends, though it stood still there
        let off = strayed(&UNSEEN, &moved(0.2, 0.3, 0.0));
        assert!(off > 0.03 && off < 0.06, "{off}");
    }

    #[test]
    fn it_is_never_better_known_later() {
        for moved in [moved(0.0, 0.0, 0.0), moved(1.0, 0.2, 0.4), moved(5.0, 0.4, 0.0), moved(0.1, 0.0, 0.0)]
        {
            let mut before = 0.0;
            for ms in 0..650_u16 {
                let s = f32::from(ms) * 1e-3;
                let unseen = Unseen { carried_s: s.min(0.15), held_s: (s - 0.15).max(0.0), lag_s: 0.02 };
                let off = strayed(&unseen, &moved);
                assert!(off >= before - 1e-6, "{moved:?} at {s}: {off} after {before}");
                before = off;
            }
        }
    }
}
