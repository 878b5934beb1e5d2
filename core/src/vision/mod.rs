//! One camera: from a borrowed frame to an observation of each ball.

pub mod colour;
pub mod frame;
