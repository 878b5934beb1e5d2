//! How the hand has been moving, and what that tells of where it is when it is not seen.
//!
//! Constant velocity: the red ball's place and the hand's orientation are carried on. How wrong that
//! will be is told by how wrong it was: the excess of each prediction's error over the centres' noise
//! gives the hand's acceleration, from which follows how far off it is later (`crate::unseen`).

use super::solve::difference;
use crate::config::PoseConfig;
use crate::geometry::Pose;
use crate::hand::orientation::nearest_rotation_step;
use crate::hand::so3;
use crate::unseen::{Moved, Unseen};
use nalgebra::{Matrix3, Matrix6, Vector2, Vector3, Vector6};

/// The share of the newest difference in the velocity.
const NEWEST: f32 = 0.6;

/// The variance of a one-step prediction in variances of a measured pose: that of
/// `x(t+1) - x(t) - v(t)` for the smoothed velocity v, which is 2 + 2 b + 2 b^2 / (2 - b), b = NEWEST.
const NOISE_OF_SURPRISE: f32 = 2.0 + 2.0 * NEWEST + 2.0 * NEWEST * NEWEST / (2.0 - NEWEST);

/// That of the smoothed velocity times the time between two frames.
const NOISE_OF_VELOCITY: f32 = 2.0 * NEWEST * NEWEST / (2.0 - NEWEST);

/// By how much the smoothed velocity is late, in frames: half a frame for the difference itself.
const LAG_FRAMES: f32 = 1.0 / NEWEST - 0.5;

/// Frames over which accelerations and speeds are averaged.
const MEMORY: f32 = 60.0;

/// A frame that comes so many times later or sooner than the last one did is not regular: half way to a
/// frame that was lost.
const IRREGULAR: f32 = 1.5;

/// A hand's acceleration before it was seen to move, m/s^2 and rad/s^2: that of a slow, careful one (the
/// paper's fastest path, 0.7 m/s round 0.1 m, has 5 m/s^2).
const FIRST_ACCELERATION: Vector2<f32> = Vector2::new(0.5, 1.0);

/// Its speed, m/s and rad/s.
const FIRST_SPEED: Vector2<f32> = Vector2::new(0.1, 0.3);

/// The weight of both, of one frame: what was seen tells soon what this hand does. A pose comes from all
/// balls, so that its errors tell more than those of one centre, whose first values weigh three.
const FIRST_WEIGHT: f32 = 1.0;

/// A mean square, for translation and turn, that forgets, of values that are known differently well.
#[derive(Clone, Copy, Debug)]
struct MeanSquare {
    sum: Vector2<f32>,
    weight: Vector2<f32>,
}

impl MeanSquare {
    fn new(first: Vector2<f32>, weight: Vector2<f32>) -> Self {
        Self { sum: first.component_mul(&first).component_mul(&weight), weight }
    }

    /// A value whose square may come out negative: noise was taken off.
    fn add(&mut self, square: Vector2<f32>, weight: Vector2<f32>) {
        let kept = 1.0 - 1.0 / MEMORY;
        self.sum = self.sum * kept + square.component_mul(&weight);
        self.weight = self.weight * kept + weight;
    }

    fn get(&self) -> Vector2<f32> {
        self.sum.zip_map(&self.weight, |sum, weight| if weight > 0.0 { (sum / weight).max(0.0) } else { 0.0 })
    }
}

/// No pose is better than a micrometre or a microradian; it keeps the weights in f32's range.
const LEAST_VARIANCE: f32 = 1e-12;

/// The hand's last measured pose and its movement.
#[derive(Clone, Debug)]
pub struct Course {
    pose: Pose,
    /// Of the last measured pose.
    covariance: Matrix6<f32>,
    /// Of its noise alone.
    noise: Matrix6<f32>,
    t_us: u64,
    /// m/s and rad/s, world axes.
    velocity: Vector6<f32>,
    /// Along an axis, m/s^2 and rad/s^2.
    acceleration: MeanSquare,
    /// Along an axis, m/s and rad/s.
    speed: MeanSquare,
    /// Seconds between the last two measured frames.
    interval_s: f32,
}

impl Course {
    /// A hand at rest.
    #[must_use]
    pub fn new(pose: Pose, covariance: Matrix6<f32>, t_us: u64) -> Self {
        let (_, weight) = excess(&Vector6::zeros(), &covariance, 0.0);
        let weight = weight * FIRST_WEIGHT;
        Self {
            pose,
            covariance,
            noise: covariance,
            t_us,
            velocity: Vector6::zeros(),
            acceleration: MeanSquare::new(FIRST_ACCELERATION, weight),
            speed: MeanSquare::new(FIRST_SPEED, weight),
            interval_s: 0.0,
        }
    }

    /// The last measured pose.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// How well it is known.
    #[must_use]
    pub const fn covariance(&self) -> &Matrix6<f32> {
        &self.covariance
    }

    /// The last measured pose is known so well, as after a latch at it.
    pub const fn is_known_to(&mut self, covariance: Matrix6<f32>) {
        self.covariance = covariance;
    }

    /// Microseconds since the last measured pose.
    #[must_use]
    pub const fn age_us(&self, t_us: u64) -> u64 {
        t_us.saturating_sub(self.t_us)
    }

    /// Takes a measured pose with its covariance and the part of it that is new in every frame.
    pub fn follow(&mut self, pose: &Pose, covariance: &Matrix6<f32>, noise: &Matrix6<f32>, t_us: u64) {
        let s = self.age_us(t_us) as f32 * 1e-6;
        if s > 0.0 {
            let measured = difference(pose, &self.pose) / s;
            let surprise = (measured - self.velocity) * s;
            // after a gap there is no velocity yet: the next surprise tells of the gap, not of an
            // acceleration
            let frames = s / self.interval_s;
            let regular = frames < IRREGULAR && frames * IRREGULAR > 1.0;
            if regular {
                let lateness = s * s * (0.5 + LAG_FRAMES);
                let (of_surprise, weight) = excess(&surprise, noise, NOISE_OF_SURPRISE);
                self.acceleration.add(of_surprise / (lateness * lateness), weight);
                let (of_measured, weight) = excess(&measured, noise, 2.0 / (s * s));
                self.speed.add(of_measured, weight);
            }
            let newest = if regular { NEWEST } else { 1.0 };
            self.velocity += (measured - self.velocity) * newest;
            self.interval_s = s;
        }
        (self.pose, self.covariance, self.noise, self.t_us) = (*pose, *covariance, *noise, t_us);
    }

    /// Where the hand is expected at `t_us`.
    #[must_use]
    pub fn pose_at(&self, t_us: u64, config: &PoseConfig) -> Pose {
        let s = self.age_us(t_us).min(config.predict_us) as f32 * 1e-6;
        let [x, y, z, wx, wy, wz] = (self.velocity * s).into();
        Pose {
            rotation: nearest_rotation_step(&(so3::exp(&Vector3::new(wx, wy, wz)) * self.pose.rotation)),
            translation: self.pose.translation + Vector3::new(x, y, z),
        }
    }

    /// How well [`Self::pose_at`] is known.
    #[must_use]
    pub fn covariance_at(&self, t_us: u64, config: &PoseConfig) -> Matrix6<f32> {
        let age_us = self.age_us(t_us);
        let s = age_us.min(config.predict_us) as f32 * 1e-6;
        let held_s = age_us.saturating_sub(config.predict_us) as f32 * 1e-6;
        let frames = if self.interval_s > 0.0 { s / self.interval_s } else { 0.0 };
        // the noise of x + k v: 1 + 2 b k + k^2 2 b^2 / (2 - b), of which the 1 is in the pose's own
        let of_velocity = 2.0 * NEWEST * frames + frames * frames * NOISE_OF_VELOCITY;
        let unseen = Unseen { carried_s: s, held_s, lag_s: LAG_FRAMES * self.interval_s };
        let (acceleration2, usual2) = (self.acceleration.get(), self.speed.get());
        let strayed2 = |acceleration2: f32, usual2: f32, velocity: Vector3<f32>, noise: Matrix3<f32>| {
            let last2 = self.last2(usual2, &velocity, &noise);
            unseen.strayed2(&Moved { acceleration2, usual2, last2 })
        };
        let (v, n) = (&self.velocity, &self.noise);
        let (of_t, of_w) = (v.fixed_rows::<3>(0).into(), v.fixed_rows::<3>(3).into());
        let (noise_t, noise_w) = (n.fixed_view::<3, 3>(0, 0).into(), n.fixed_view::<3, 3>(3, 3).into());
        let t = strayed2(acceleration2.x, usual2.x, of_t, noise_t);
        let w = strayed2(acceleration2.y, usual2.y, of_w, noise_w);
        let diagonal = Vector6::new(t, t, t, w, w, w);
        self.covariance + self.noise * of_velocity + Matrix6::from_diagonal(&diagonal)
    }

    /// The mean square along an axis of the last velocity, of translation or of turn, of a pose with this
    /// noise: where it is mostly noise, as a lone camera's along its line of sight, little of it is
    /// believed, and the rest may be as usual.
    fn last2(&self, usual2: f32, velocity: &Vector3<f32>, noise: &Matrix3<f32>) -> f32 {
        // in units of a frame
        let per_s2 = self.interval_s * self.interval_s;
        let least = Matrix3::from_diagonal_element(usual2 * per_s2 + LEAST_VARIANCE);
        let Some(inverse) = (least + noise * NOISE_OF_VELOCITY).try_inverse() else { return usual2 };
        let believed = inverse * (usual2 * per_s2);
        let rest = 1.0 - believed.trace() / 3.0;
        (believed * velocity).norm_squared() / 3.0 + usual2 * rest
    }

    /// Tells of the same movement in a new world, which stands so in the old one.
    pub fn change_world(&mut self, old_from_new: &Pose) {
        self.pose = old_from_new.inverse().compose(&self.pose);
        self.velocity = turned(&old_from_new.rotation.transpose(), &self.velocity);
        self.covariance = turned_covariance(&old_from_new.rotation.transpose(), &self.covariance);
        self.noise = turned_covariance(&old_from_new.rotation.transpose(), &self.noise);
    }
}

/// What is left of the mean square along an axis, of translation and of turn, when `share` times the
/// noise is taken off, and its weight.
///
/// For `E[v v'] = share N + a^2 1` the best estimate of a small `a^2` weighs the directions by `N^-2`:
/// one camera's depth is ten times noisier than what it sees across, and says a hundredth of what that
/// says about squares of a size with its own.
fn excess(v: &Vector6<f32>, noise: &Matrix6<f32>, share: f32) -> (Vector2<f32>, Vector2<f32>) {
    let (of_t, weight_t) =
        excess_of(&v.fixed_rows::<3>(0).into(), &noise.fixed_view::<3, 3>(0, 0).into(), share);
    let (of_w, weight_w) =
        excess_of(&v.fixed_rows::<3>(3).into(), &noise.fixed_view::<3, 3>(3, 3).into(), share);
    (Vector2::new(of_t, of_w), Vector2::new(weight_t, weight_w))
}

fn excess_of(v: &Vector3<f32>, noise: &Matrix3<f32>, share: f32) -> (f32, f32) {
    let floored = noise + Matrix3::identity() * LEAST_VARIANCE;
    let Some(information) = floored.try_inverse() else { return (0.0, 0.0) };
    let weight = information.norm_squared() / 3.0;
    let weighed = (information * v).norm_squared() - share * information.trace();
    (weighed / (3.0 * weight), weight)
}

/// A translation and a turn in other axes.
fn turned(by: &Matrix3<f32>, v: &Vector6<f32>) -> Vector6<f32> {
    let [x, y, z, wx, wy, wz] = (*v).into();
    let (t, w) = (by * Vector3::new(x, y, z), by * Vector3::new(wx, wy, wz));
    Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z)
}

/// Their covariance in other axes.
#[must_use]
pub fn turned_covariance(by: &Matrix3<f32>, covariance: &Matrix6<f32>) -> Matrix6<f32> {
    let mut whole = Matrix6::zeros();
    whole.fixed_view_mut::<3, 3>(0, 0).copy_from(by);
    whole.fixed_view_mut::<3, 3>(3, 3).copy_from(by);
    whole * covariance * whole.transpose()
}
