//! The host side of Tetrad: what surrounds `tetrad-core` on a desktop.
//!
//! The path of a frame, and where each part of it lives:
//!
//! ```text
//! SRC --source--> frames --streams--> pairs --pipeline--> observations, motion, pose --output--> files
//! ```
//!
//! [`source`] opens cameras, folders, films and simulated scenes and lends one frame at a time.
//! [`streams`] reads one or two of them in step and says where they do not match.
//!
//! [`learning`] teaches the balls' colours and says in words what cannot be taught; [`colours`] is the
//! file they are kept in, [`scene_file`] the file that says where the balls are in a recording,
//! [`camera_start`] what a tracker makes of either, and [`balls`] the list of those that are meant.
//!
//! [`pipeline`] joins one tracker a camera with the hand that they see. It knows no files and no
//! devices: stations and tests feed it frames.
//!
//! [`output`] writes results as they come, [`comparison`] measures them against the truth of a
//! simulated scene. [`evaluate`] does so for the experiments of the paper, and [`report`] makes tables,
//! figures and a page of the numbers.
//!
//! [`robot`] opens what is to be driven: the ports between the slave's law and a controller of an arm.
//!
//! [`console`] is the operator's page in a browser: what the operator's loop knows, and its buttons.
//!
//! [`link`] joins the stations: packets, pictures and clocks over QUIC, between named stations only.
//!
//! Files are opened by `regular_file`, which no name of a pipe can hold up, and those of text read by `text_file`;
//! a film may come through a pipe.
//!
//! [`settings`] turns flags and files into checked settings, [`cli`] runs a command with them, and
//! [`exit`] carries what went wrong to `main`, which alone prints errors and ends the process.

pub mod balls;
pub mod camera_start;
pub mod cli;
pub mod colours;
pub mod comparison;
pub mod console;
pub mod evaluate;
pub mod exit;
pub mod filter_quality;
pub mod learning;
pub mod link;
mod locked;
pub mod output;
pub mod pipeline;
mod precedence;
mod regular_file;
pub mod report;
pub mod robot;
pub mod scene_file;
pub mod session;
pub mod settings;
pub mod source;
pub mod station;
pub mod streams;
mod text_file;
