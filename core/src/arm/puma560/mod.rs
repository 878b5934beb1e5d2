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
