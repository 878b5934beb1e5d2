//! Sessions: what cameras saw and what became of it in one MCAP file, which replays to the same bits.
//!
//! ```text
//! record:    streams -> Pipeline -> Steps ----------+
//! operator:  camera threads, loop -> StationTape ---+--> Tape (queue, thread) --> Writer --> FILE.mcap
//! replay:    FILE.mcap --> Reader --> Replay: the same pipeline --> Compared: same bits, or where not
//!            FILE.mcap --> Reader --> source::McapSource, export (CSV), report (one page)
//! console:   FILE.mcap --> Index, Lookup --> Moment: what is looked at and no more
//! ```
//!
//! What cameras and hand are taught meanwhile stands between the pictures and the instants that it counts for,
//! and a replay begins anew there as the run did.
//!
//! docs/sessions.md lists the topics. Frames are stored as they were captured, everything that was
//! computed with its bits, beside what Foxglove and others show of it.

mod compare;
mod configuration;
mod convert;
mod error;
mod export;
mod index;
mod moment;
mod picture;
mod reader;
mod replay;
pub mod schema;
mod stations;
mod steps;
mod summary;
mod tape;
mod taught;
#[cfg(test)]
pub(crate) mod testing;
mod topic;
mod writer;

pub use compare::Compared;
pub use configuration::{Beginning, CameraBeginning, Pictures};
pub use error::SessionError;
pub use export::{Export, ExportError, export};
pub use index::{Index, Lookup, Spot};
pub use moment::{CameraThen, HandThen, Moment, steps as moments};
pub use reader::{Entry, Reader};
pub use replay::{Made, Outcome, replay};
pub use stations::StationTape;
pub use steps::Steps;
pub use summary::{Summary, report};
pub use tape::{Feed, Recorded, Tape};
pub use topic::{Topic, camera_names};
pub use writer::Written;

pub(crate) use picture::view as picture_view;
