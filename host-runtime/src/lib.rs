//! The host side of Tetrad.

pub mod balls;
pub mod cli;
pub mod colours;
pub mod comparison;
pub mod exit;
pub mod learning;
pub mod output;
pub mod pipeline;
pub mod scene_file;
pub mod settings;
pub mod source;
pub mod streams;
