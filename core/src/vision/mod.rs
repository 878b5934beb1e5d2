//! One camera: from a borrowed frame to an observation of each ball.
//!
//! The modules stand in the order of the path; each uses only those before it.

pub mod frame;

#[cfg(test)]
pub(crate) mod painter;

pub mod colour;

pub mod search;

pub mod edges;

pub mod centre;

pub mod rim;

pub mod learn;

pub mod appearance;

pub mod occlusion;

pub mod validation;

pub mod detect;

mod forecast;

mod track;

mod reacquire;

mod locate;

pub mod tracker;
