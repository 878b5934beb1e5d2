//! Pose of the tool -> the eight joint vectors that bring it there, in closed form.
//!
//! Three arcs, each of which may be taken two ways:
//!
//! 1. shoulder: the wrist centre's distance from the first axis leaves two q1;
//! 2. elbow: its distance from the shoulder leaves two q3 for each, and q2 follows;
//! 3. wrist: the rotation that is left is Rz(q4) Ry(-q5) Rz(q6), which has two solutions.
//!
//! Where two ways meet (a singularity) rounding may put the pose outside the arc; within
//! [`Real::SLACK`] the arc is clamped. Sines and cosines of what is being solved for come out of the
//! lengths without a detour over angles; then the angles are put into the forward kinematics, and
//! what does not come back to the pose is not a solution.

use super::forward::{Turn, wrist_rotation};
use super::joint_set::JointSet;
use super::model::{Geometry, Joints, Puma560};
use super::posture::{Configuration, Signs};
use super::turns::wrapped;
use crate::geometry::Pose;
use crate::real::Real;
use core::fmt;
use nalgebra::{Matrix3, Vector3};

/// How far R^T R of what is taken for a rotation may be from the identity; within, the nearest
/// rotation is meant.
const MAX_SKEW: f64 = 0.01;

/// Steps of Newton's iteration to that rotation: the skew is squared in each, 0.01 is 1e-16 after three.
const SQUARING_STEPS: usize = 4;

/// The largest reference angle that is believed, radians. Farther out whole turns lose digits.
const MAX_REFERENCE_RAD: f64 = 1000.0;

/// Slacks by which a solution's own pose may be off: 1e-9 m or in an entry of the rotation in f64,
/// 4e-5 in f32.
const CHECK_SLACKS: f64 = 10.0;

/// Why no joints bring the tool to a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unreachable {
    /// A number of the pose is not finite.
    PoseNotFinite,
    /// The nine numbers of the rotation are not a rotation's.
    NotARotation,
    /// An angle of the joints to stay near to is not finite, or is 1000 radians and more.
    JointsNotFinite,
    /// The wrist centre would be inside the cylinder about the first axis that the shoulder's offset
    /// keeps free.
    InsideShoulderCylinder,
    /// The wrist centre would be beyond the stretched arm.
    TooFar,
    /// The wrist centre would be nearer to the shoulder than the folded arm.
    TooNear,
    /// Joints were found, but not within what is asked of the pose's precision. It takes lengths far from
    /// a PUMA's and a pose in single precision.
    Inexact,
}

impl fmt::Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PoseNotFinite => "the pose asked of the arm has a number that is not finite",
            Self::NotARotation => "the rotation asked of the arm is not orthonormal and right-handed",
            Self::JointsNotFinite => "the joints to stay near to are not finite or beyond 1000 rad",
            Self::InsideShoulderCylinder => {
                "out of reach: the wrist would be too near to the arm's vertical axis; move it outwards"
            }
            Self::TooFar => "out of reach: too far even for the stretched arm; move the tool towards it",
            Self::TooNear => "out of reach: too near to the shoulder; move the tool away from it",
            Self::Inexact => "the joints found miss the pose; tell poses of this arm in double precision",
        })
    }
}

impl core::error::Error for Unreachable {}

/// Joints that bring the tool to the pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T> {
    /// How the arm then stands.
    pub configuration: Configuration,
    /// The angles. Of those that mean the same the nearest to the reference that is in the joint's
    /// range; the nearest of all where none is.
    pub joints: Joints<T>,
    /// The joints that cannot be in their range in this configuration.
    pub outside: JointSet,
}

/// What the inverse gives: up to eight solutions, in the order of [`Configuration::ALL`]. At a
/// singularity two of them are one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solutions<T> {
    found: [Option<Solution<T>>; 8],
}

impl<T> Solutions<T> {
    /// All of them, whether their joints are in range or not.
    pub fn iter(&self) -> impl Iterator<Item = &Solution<T>> {
        self.found.iter().flatten()
    }

    /// Those with all joints in their ranges.
    pub fn within_ranges(&self) -> impl Iterator<Item = &Solution<T>> {
        self.iter().filter(|solution| solution.outside.is_empty())
    }

    /// The one of this configuration.
    #[must_use]
    pub fn get(&self, configuration: Configuration) -> Option<&Solution<T>> {
        self.iter().find(|solution| solution.configuration == configuration)
    }
}

impl<T: Real> Puma560<T> {
    /// The joints that bring the tool to `base_from_tool`, in all configurations.
    ///
    /// Computed in the precision in which the pose is told, and rounded to that of the joints at the
    /// end; see [the module](super) for what that means beside singularities.
    ///
    /// `near` (the last joints, or those expected now) decides what the pose leaves open: whole
    /// turns, and at the wrist's singularity how q4 and q6 share what only their sum has to be. There
    /// the solution that `near` leads to is told as bent the way `near` is.
    ///
    /// # Errors
    /// [`Unreachable`] says why there are none.
    pub fn inverse<P: Real>(
        &self,
        base_from_tool: &Pose<P>,
        near: &Joints<T>,
    ) -> Result<Solutions<T>, Unreachable> {
        let mut solutions = Solutions { found: [None; 8] };
        let mut places = solutions.found.iter_mut();
        self.solve(base_from_tool, near, |configuration, joints| {
            if let Some(place) = places.next() {
                let (joints, outside) = self.fit(joints, near);
                *place = Some(Solution { configuration, joints, outside });
            }
        })?;
        Ok(solutions)
    }

    /// Calls `each` with every solution, whole turns and ranges aside, in the order of
    /// [`Configuration::ALL`].
    pub(super) fn solve<P: Real>(
        &self,
        base_from_tool: &Pose<P>,
        near: &Joints<T>,
        mut each: impl FnMut(Configuration, &Joints<T>),
    ) -> Result<(), Unreachable> {
        let near = near.map(|angle| P::of(angle.to_f64()));
        self.exact.rounded::<P>().solve(base_from_tool, &near, |configuration, joints| {
            each(configuration, &joints.map(|angle| T::of(angle.to_f64())));
        })
    }
}

impl<T: Real> Geometry<T> {
    /// As [`Puma560::solve`], in one precision.
    fn solve(
        &self,
        base_from_tool: &Pose<T>,
        near: &Joints<T>,
        mut each: impl FnMut(Configuration, &Joints<T>),
    ) -> Result<(), Unreachable> {
        if !near.iter().all(|angle| angle.abs() <= T::of(MAX_REFERENCE_RAD)) {
            return Err(Unreachable::JointsNotFinite);
        }
        if !base_from_tool.translation.iter().chain(base_from_tool.rotation.iter()).all(|x| x.is_finite()) {
            return Err(Unreachable::PoseNotFinite);
        }
        let rotation = nearest_rotation(&base_from_tool.rotation)?;
        let target = Pose { rotation, translation: base_from_tool.translation }.compose(&self.wrist_in_tool);
        let arcs = self.arcs(&target.translation)?;
        let mut any = false;
        for right in [true, false] {
            let q1 = self.shoulder(&target.translation, &arcs, right);
            let turn1 = Turn::by(q1);
            for up in [true, false] {
                // the elbow's factor is positive where a right arm's elbow is down
                let signs = Signs { wrist: false, elbow: right != up, shoulder: right };
                let (q2, q3) = self.elbow(&arcs, signs);
                let arm = self.arm(turn1, Turn::by(q2), Turn::by(q2 + q3));
                if !within(&(arm.translation - target.translation)) {
                    continue;
                }
                let wrist = arm.rotation.tr_mul(&target.rotation);
                let bent = bend_wrist(&wrist, near);
                let [q4, q5, q6] = bent.angles;
                if !within(&(wrist_rotation(Turn::by(q4), Turn::by(q5), Turn::by(q6)) - wrist)) {
                    continue;
                }
                any = true;
                // half a turn of q4 and q6, and q5 the other way, is the same rotation
                let [turned4, turned6] = [half_turn(q4), half_turn(q6)];
                let (no_flip, flip) = if bent.flip {
                    ([turned4, -q5, turned6], bent.angles)
                } else {
                    (bent.angles, [turned4, -q5, turned6])
                };
                for (wrist, [q4, q5, q6]) in [(false, no_flip), (true, flip)] {
                    each(Configuration::of_signs(Signs { wrist, ..signs }), &[q1, q2, q3, q4, q5, q6]);
                }
            }
        }
        if any { Ok(()) } else { Err(Unreachable::Inexact) }
    }

    /// The lengths of both arcs, or why the wrist centre cannot be there.
    fn arcs(&self, wrist: &Vector3<T>) -> Result<Arcs<T>, Unreachable> {
        let from_axis = (wrist.x * wrist.x + wrist.y * wrist.y).sqrt();
        // products of sums and differences: they do not cancel near 0 as differences of squares do
        let free = from_axis - self.offset;
        if free < -T::SLACK {
            return Err(Unreachable::InsideShoulderCylinder);
        }
        let out = (left_over(free) * (from_axis + self.offset)).sqrt();
        let up = wrist.z - self.base;
        let square = out * out + up * up;
        let distance = square.sqrt();
        let (reach, inner) = (self.reach(), self.inner_reach());
        let (spare, excess) = (reach - distance, distance - inner);
        // an overflow is too far as well
        if !spare.is_finite() || spare < -T::SLACK {
            return Err(Unreachable::TooFar);
        }
        if excess < -T::SLACK {
            return Err(Unreachable::TooNear);
        }
        let (a, b) = (self.upper_arm, self.lower_arm);
        // cosine and sine of the angle at the elbow, times 2 a b; halved and over a, the lower arm
        // along the upper arm's line and across it
        let cos = square - a * a - b * b;
        let sin = (left_over(spare) * (reach + distance) * left_over(excess) * (distance + inner)).sqrt();
        let raised = (sin / (a + a)).atan2(a + cos / (a + a));
        Ok(Arcs { out, direction: up.atan2(out), bend: sin.atan2(cos), raised })
    }

    /// q1 of a right or a left arm.
    fn shoulder(&self, wrist: &Vector3<T>, arcs: &Arcs<T>, right: bool) -> T {
        let out = if right { arcs.out } else { -arcs.out };
        let sin = wrist.x * self.offset + wrist.y * out;
        let cos = wrist.x * out - wrist.y * self.offset;
        sin.atan2(cos)
    }

    /// q2 and q3 of an arm whose two factors of det J have these signs.
    fn elbow(&self, arcs: &Arcs<T>, signs: Signs) -> (T, T) {
        let direction = if signs.shoulder { arcs.direction } else { T::pi() - arcs.direction };
        let (bend, raised) = if signs.elbow { (arcs.bend, arcs.raised) } else { (-arcs.bend, -arcs.raised) };
        (direction - raised, bend - self.bend)
    }
}

/// The triangle of shoulder, elbow and wrist centre in the plane of the arm.
struct Arcs<T> {
    /// From the shoulder out to the wrist centre, metres, of a right arm.
    out: T,
    /// From the horizontal up to the line from shoulder to wrist centre, of a right arm.
    direction: T,
    /// From the upper arm's line to the lower arm's, 0 to pi.
    bend: T,
    /// From the line between shoulder and wrist centre to the upper arm.
    raised: T,
}

/// What is left of a length, metres, or 0 where that may be rounding: the arc's angle is its root, and
/// a root of rounding would be a thousand times that of everything else.
#[inline]
fn left_over<T: Real>(length: T) -> T {
    if length > T::EPSILON * T::of(4.0) { length } else { T::zero() }
}

/// Whether every entry is as small as a solution's error may be.
#[inline]
fn within<T: Real, const N: usize>(error: &nalgebra::SMatrix<T, 3, N>) -> bool {
    let most = T::SLACK * T::of(CHECK_SLACKS);
    error.iter().all(|x| x.abs() <= most)
}

/// One way to bend the wrist.
struct BentWrist<T> {
    angles: [T; 3],
    flip: bool,
}

/// A solution of `wrist = Rz(q4) Ry(-q5) Rz(q6)`: the one with sin(q5) > 0, and where that is 0 the one
/// that is nearest to `near`, bent the way `near` is.
fn bend_wrist<T: Real>(wrist: &Matrix3<T>, near: &Joints<T>) -> BentWrist<T> {
    let (x, y) = (-wrist.m13, -wrist.m23);
    let sine = (x * x + y * y).sqrt();
    let mut flip = true;
    let (q4, turn) = if sine > T::SLACK {
        (y.atan2(x), Turn { sin: y / sine, cos: x / sine })
    } else {
        let [_, _, _, near4, near5, near6] = *near;
        flip = near5 > T::zero();
        // q4 + q6 (q4 - q6 of a wrist bent back on itself) is all there is: both go half of the way
        let off = if wrist.m33 > T::zero() {
            (wrist.m21 - wrist.m12).atan2(wrist.m11 + wrist.m22) - (near4 + near6)
        } else {
            (-wrist.m21 - wrist.m12).atan2(wrist.m22 - wrist.m11) - (near4 - near6)
        };
        let q4 = near4 + wrapped(off) * T::of(0.5);
        (q4, Turn::by(q4))
    };
    // q5 and q6 out of this q4, so that its rounding does no harm
    let Turn { sin: s4, cos: c4 } = turn;
    let q5 = (c4 * x + s4 * y).atan2(wrist.m33);
    let q6 = (c4 * wrist.m21 - s4 * wrist.m11).atan2(c4 * wrist.m22 - s4 * wrist.m12);
    BentWrist { angles: [q4, q5, q6], flip }
}

fn half_turn<T: Real>(angle: T) -> T {
    if angle > T::zero() { angle - T::pi() } else { angle + T::pi() }
}

/// The rotation nearest to `matrix`, which must be nearly one.
fn nearest_rotation<T: Real>(matrix: &Matrix3<T>) -> Result<Matrix3<T>, Unreachable> {
    let mut rotation = *matrix;
    let mut skew = rotation.tr_mul(&rotation) - Matrix3::identity();
    if !skew.iter().all(|x| x.abs() <= T::of(MAX_SKEW)) || rotation.determinant() <= T::zero() {
        return Err(Unreachable::NotARotation);
    }
    let exact = T::EPSILON * T::of(8.0);
    for _ in 0..SQUARING_STEPS {
        if skew.iter().all(|x| x.abs() <= exact) {
            break;
        }
        rotation -= rotation * skew * T::of(0.5);
        skew = rotation.tr_mul(&rotation) - Matrix3::identity();
    }
    Ok(rotation)
}
