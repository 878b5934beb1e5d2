//! The pose of the hand without its noise, and where it will be when the arm gets there.
//!
//! ```text
//! measured pose --+--> kinematics: velocity, acceleration --+
//!                 |                |                        |
//!                 +--> One Euro <--+ speed                  +--> carried on by the lead --> pose
//!                          |                                |
//!                          +--------- smoothed pose --------+
//! ```
//!
//! Smoothing makes a pose late, the lead makes up for that and for what cameras, computer and cable
//! take. Both are independent: with smoothing off and no lead the filter gives back what it got.
//! The paper has neither. Poses are `a_from_b` in any one pair of axes; where the axes change (a new
//! engage) the filter is reset. Nothing is carried on further than the configuration says.

mod kinematics;

mod one_euro;

use crate::config::{FilterConfig, FilterConfigError, Smoothing};
use crate::geometry::Pose;
use crate::hand::so3;
use kinematics::{Kinematics, seconds};
use nalgebra::Matrix3;

#[cfg(test)]
mod tests;

/// The farthest place that is taken, metres: beyond it single precision is coarser than any use.
const MAX_PLACE_M: f32 = 1000.0;

/// How far R^T R of what is taken for a rotation may be from the identity.
const MAX_SKEW: f32 = 0.01;

/// Why a measurement was not taken; the filter is as it was before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FilterRefusal {
    /// A number of the pose is not finite, or its place is over a kilometre away.
    NotFinite,
    /// The nine numbers of the rotation are not a rotation's.
    NotARotation,
    /// The time is that of the last measurement, or earlier. A clock that was set back takes a
    /// [`PoseFilter::reset`].
    NotLater,
}

impl core::fmt::Display for FilterRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "the pose to filter is not made of finite numbers within a kilometre",
            Self::NotARotation => "the rotation of the pose to filter is not orthonormal and right-handed",
            Self::NotLater => "the pose to filter is no later than the one before; reset after a clock jump",
        })
    }
}

impl core::error::Error for FilterRefusal {}

/// Smooths a pose and carries it on.
#[derive(Clone, Debug)]
pub struct PoseFilter {
    config: FilterConfig,
    state: Option<State>,
}

/// What is known after a measurement.
#[derive(Clone, Copy, Debug)]
struct State {
    t_us: u64,
    smoothed: Pose,
    kinematics: Kinematics,
}

impl Default for PoseFilter {
    /// A filter with the settings of [`FilterConfig::default`], which can be worked with.
    fn default() -> Self {
        Self { config: FilterConfig::default(), state: None }
    }
}

impl PoseFilter {
    /// A filter that has seen nothing.
    ///
    /// # Errors
    /// [`FilterConfigError`] for a setting that cannot be worked with.
    pub fn new(config: FilterConfig) -> Result<Self, FilterConfigError> {
        config.check()?;
        Ok(Self { config, state: None })
    }

    /// The settings.
    #[must_use]
    pub const fn config(&self) -> &FilterConfig {
        &self.config
    }

    /// Forgets everything: the next measurement is given back as it is, at rest. For a new engage,
    /// whose poses are in other axes, and after a clock jump.
    pub const fn reset(&mut self) {
        self.state = None;
    }

    /// Takes the pose measured at `t_us` and gives the one expected `lead_us` later. The first one,
    /// and the first one after a pause of over `restart_us`, is given back as it is.
    ///
    /// # Errors
    /// [`FilterRefusal`]; nothing is changed then.
    pub fn measure(&mut self, t_us: u64, pose: &Pose) -> Result<Pose, FilterRefusal> {
        check(pose)?;
        let state = match &self.state {
            Some(last) => {
                let elapsed = t_us.checked_sub(last.t_us).filter(|&us| us > 0);
                let elapsed = elapsed.ok_or(FilterRefusal::NotLater)?;
                match u32::try_from(elapsed) {
                    Ok(us) if us <= self.config.restart_us => last.next(&self.config, t_us, us, pose),
                    _ => State::first(t_us, pose),
                }
            }
            None => State::first(t_us, pose),
        };
        self.state = Some(state);
        Ok(state.ahead(self.config.lead_us))
    }

    /// The pose expected `lead_us` after `t_us`, at which none was measured: carried on for up to
    /// `coast_us` from the last measurement and standing still from then on. `None` before the
    /// first measurement, and from `restart_us` after the last one.
    #[must_use]
    pub fn coast(&self, t_us: u64) -> Option<Pose> {
        let state = self.state.as_ref()?;
        // a time before the measurement is taken for that of the measurement
        let elapsed = u32::try_from(t_us.saturating_sub(state.t_us)).unwrap_or(u32::MAX);
        (elapsed <= self.config.restart_us)
            .then(|| state.ahead(elapsed.min(self.config.coast_us).saturating_add(self.config.lead_us)))
    }
}

impl State {
    fn first(t_us: u64, pose: &Pose) -> Self {
        Self { t_us, smoothed: *pose, kinematics: Kinematics::at(pose) }
    }

    fn next(&self, config: &FilterConfig, t_us: u64, elapsed_us: u32, pose: &Pose) -> Self {
        let dt = seconds(elapsed_us);
        let mut kinematics = self.kinematics;
        kinematics.correct(pose, dt, config);
        let smoothed = match &config.smoothing {
            Smoothing::OneEuro(euro) => {
                let (speed, turn_speed) = (kinematics.speed(), kinematics.turn_speed());
                one_euro::smooth(euro, &self.smoothed, pose, dt, speed, turn_speed)
            }
            Smoothing::Off => *pose,
        };
        Self { t_us, smoothed, kinematics }
    }

    fn ahead(&self, us: u32) -> Pose {
        // by nothing it is the same pose to the bit
        if us == 0 { self.smoothed } else { self.kinematics.carry(&self.smoothed, seconds(us)) }
    }
}

fn check(pose: &Pose) -> Result<(), FilterRefusal> {
    // comparisons written so that NaN fails them
    if !pose.translation.iter().all(|x| x.abs() <= MAX_PLACE_M)
        || !pose.rotation.iter().all(|x| x.is_finite())
    {
        return Err(FilterRefusal::NotFinite);
    }
    let skew = pose.rotation.transpose() * pose.rotation - Matrix3::identity();
    if skew.iter().all(|x| x.abs() <= MAX_SKEW) && pose.rotation.determinant() > 0.0 {
        Ok(())
    } else {
        Err(FilterRefusal::NotARotation)
    }
}
