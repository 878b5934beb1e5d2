//! The PUMA 560: where its tool is, how fast it moves, and which joints bring it to a pose.
//!
//! | job | file |
//! |---|---|
//! | link table, ranges, tool | `model` |
//! | sets of joints | `joint_set` |
//! | shoulder, elbow and wrist; distance from singularities | `posture` |
//! | joints -> pose | `forward` |
//! | joints -> Jacobian | `jacobian` |
//! | angles that mean the same, within ranges | `turns` |
//! | pose -> all eight joint vectors | `inverse` |
//! | pose, last joints -> the one to follow | `choose` |
//! | joints <-> counts of the motors' encoders | `drives` |
//!
//! Angles in radians, zero as in the standard Denavit-Hartenberg table of
//! [`PumaConfig`](crate::config::PumaConfig); lengths in metres; the base is the mounting surface,
//! z up. The link table is configuration, the kind of arm is not: three parallel or crossing axes, an
//! offset shoulder, a spherical wrist.
//!
//! # Two precisions
//!
//! Joints, ranges and history are in the precision of the arm, `Puma560<f32>` on a microcontroller. A
//! pose brings its own: [`Puma560::inverse`] and [`Puma560::choose`] compute in that of the pose and
//! round the joints at the end, so an arm in f32 may be asked in f64.
//!
//! It makes a difference beside singularities. The numbers of an f32 pose are themselves off by 6e-8;
//! in the joints that is 6e-8 over the smallest singular value of the Jacobian, and the root of it
//! where the arm is stretched or beside its axis, whoever solves it. Beside reference data
//! (`tests/tests/puma560_single.rs`, 13,440 solutions of random poses and 3,000 at and beside
//! singularities):
//!
//! | an f32 arm's pose in | joints | tool |
//! |---|---|---|
//! | f64 | within 6e-7 rad everywhere | within 1e-6 m |
//! | f32 | 7e-6 rad where the smallest singular value is 0.01 or more; 2e-3 rad on some random poses, 2e-2 rad near the wrist's singularity, and on it any share of q4 + q6 | within 1e-6 m |
//!
//! The slave in f32 tells its poses in f32. The hand comes in f32 on the wire and is known to a tenth of
//! a millimetre, so the goal would not be known better in f64; and the governor, run with both beside
//! singularities, was as smooth with one as with the other. The tool's place is right to f32 rounding.

mod model;

mod joint_set;

mod posture;

mod forward;

mod jacobian;

mod turns;

mod inverse;

mod choose;

mod drives;

pub use choose::{Change, ChangeKind, Choice, ChooseRefusal, Fixed, Passages, Policy, Recent};
pub use drives::{BeyondCounts, Counts, Drives};
pub use inverse::{Solution, Solutions, Unreachable};
pub use jacobian::Jacobian;
pub use joint_set::JointSet;
pub use model::{Joints, LinkRow, Puma560};
pub use posture::{Configuration, Elbow, Shoulder, Singularities, Singularity, Wrist};

#[cfg(test)]
mod tests;
