//! The host side of Tetrad.

pub mod balls;
pub mod colours;
pub mod exit;
pub mod output;
pub mod pipeline;
pub mod scene_file;
pub mod settings;
pub mod source;
