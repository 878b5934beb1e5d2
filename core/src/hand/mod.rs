//! Two (or up to eight) cameras become one hand: section 4 of the paper.
//!
//! | stage | file | in -> out | refusals |
//! |---|---|---|---|
//! | view | [`view`] | one camera's observations and the little that is known of it | |
//! | state | [`state`] | how a pose is known, and how well | |
//! | affine | [`affine`] | reference views, a point in each -> its coordinates (eq. 5 to 8) | [`affine::AffineRefusal`] |
//! | orientation | [`orientation`] | three arms -> a proper rotation (eq. 4, Gram-Schmidt) | [`orientation::OrientationRefusal`] |
//! | motion | [`motion`] | observations -> alpha, Phi and the pose since engage | [`motion::MotionRefusal`] |
//! | report | [`report`] | what is known of the hand after a frame | |
//! | perspective | [`perspective`] | a pinhole view of the known frame; its pose (POSIT) | |
//! | pose | [`pose`] | views -> the refined pose since engage | [`motion::MotionRefusal`] |
//! | tracker | [`tracker`] | views -> pose, covariance, state; both modes | [`motion::MotionRefusal`] |
//! | filter | [`filter`] | measured poses -> smoothed, and where the hand will be | [`filter::FilterRefusal`] |
//!
//! Nothing here knows a left or a right camera: views are a list, and a view is known by its
//! place in it. Nothing here panics: what cannot be solved is refused by a value with a reason.

pub mod view;

pub mod state;

pub(crate) mod so3;

pub mod affine;

pub mod orientation;

pub mod motion;

pub mod report;

pub mod perspective;

pub mod pose;

pub mod tracker;

pub mod filter;

#[cfg(test)]
pub(crate) mod synthetic;
