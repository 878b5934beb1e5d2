//! What runs where: the parts of the stations that cross threads and wires.
//!
//! ```text
//! operator:  pipeline --Step--> MotionSender --motion packet--> (pipe, file; later the link)
//! slave:     packets, hold-to-run --> SlaveStation --set-point--> robot port
//! ```
//!
//! Nothing here reads a clock or opens a device: the commands do, and hand in what came and when.

mod following;
mod motion;
pub mod pairing;
mod slave;

pub use following::{Closeness, Following, Truth};
pub use motion::MotionSender;
pub use slave::{Cycle, EnableThenReset, SlaveStation};
