//! The One Euro filter (Casiez, Roussel and Vogel, CHI 2012) on poses.
//!
//! A first-order low pass whose cut-off rises with the speed: a slow hand is smoothed, a fast one is
//! followed. As printed, but: place and orientation are each one quantity, not three coordinates, so
//! that the axes do not matter; orientation is averaged along the shortest turn; and the speed is
//! that of [`super::kinematics`], which knows it sooner than the printed low pass of differences.

use super::so3;
use crate::config::OneEuroConfig;
use crate::geometry::Pose;
use crate::hand::orientation::nearest_rotation_step;
use core::f32::consts::TAU;

/// The next smoothed pose, `dt` seconds after `last`, of a hand that moves at `speed` m/s and turns
/// at `turn_speed` rad/s.
pub(super) fn smooth(
    config: &OneEuroConfig,
    last: &Pose,
    measured: &Pose,
    dt: f32,
    speed: f32,
    turn_speed: f32,
) -> Pose {
    let place = share(dt, config.min_cutoff_hz + config.cutoff_per_m_s * speed);
    let turn = share(dt, config.turn_min_cutoff_hz + config.turn_cutoff_per_rad_s * turn_speed);
    let turned = so3::log(&(measured.rotation * last.rotation.transpose()));
    Pose {
        translation: last.translation + (measured.translation - last.translation) * place,
        rotation: nearest_rotation_step(&(so3::exp(&(turned * turn)) * last.rotation)),
    }
}

/// alpha of the paper: how much of the way to the measurement is gone.
fn share(dt: f32, cutoff_hz: f32) -> f32 {
    let turns = TAU * cutoff_hz * dt;
    turns / (turns + 1.0)
}
