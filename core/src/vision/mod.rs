//! One camera: from a borrowed frame to an observation of each ball.

pub mod centre;
pub mod colour;
pub mod edges;
pub mod frame;
pub mod search;
