//! The slave arm: section 5 of the paper.
//!
//! | stage | file | in -> out | refusals |
//! |---|---|---|---|
//! | kinematics | [`puma560`] | pose of the tool <-> joints; the branch to follow | [`puma560::Unreachable`], [`puma560::ChooseRefusal`] |
//!
//! Generic over f32 (the microcontroller) and f64 (the host). Nothing here panics or allocates.

pub mod puma560;
