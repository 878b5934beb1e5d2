//! What runs where: the parts of the stations that cross threads and wires.
//!
//! ```text
//! operator:  pipeline --Step--> MotionSender --motion packet--> (pipe, file; later the link)
//! slave:     packets, hold-to-run --> SlaveStation --set-point--> robot port
//!            the link's motion, buttons --> LinkedSlave (a SlaveStation in it) --arm state--> the link
//! ```
//!
//! Nothing here opens a device, and only [`serve`] reads a clock by itself: the commands hand in what came
//! and when.

mod announcement;
mod following;
mod linked_slave;
mod motion;
pub mod pairing;
mod resetting;
mod serve;
mod settling;
mod slave;

pub use announcement::{SlaveAnnouncement, UnreadableAnnouncement};
pub use following::{Closeness, Following, Truth};
pub use linked_slave::LinkedSlave;
pub use motion::MotionSender;
pub use resetting::{Reset, Resetting};
pub use serve::{Served, serve};
pub use slave::{Cycle, EnableThenReset, SlaveStation};
