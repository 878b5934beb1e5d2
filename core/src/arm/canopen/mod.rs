//! Six CiA 402 drives on a CAN bus, in cyclic synchronous position: the same master on the host and on a
//! microcontroller. docs/canopen.md says how to wire and commission an arm of such drives.
//!
//! | job | file |
//! |---|---|
//! | frames and their COB-IDs | [`frame`] |
//! | frames as the lines of a serial adapter | [`slcan`] |
//! | reading and writing objects | [`sdo`] |
//! | the state machine of a drive | [`cia402`] |
//! | why the arm was stopped, in words | `cause` |
//! | what is written to a drive first | `setup` |
//! | one drive as the master sees it | `node` |
//! | the master: what it makes of frames, what it sends | [`master`] |
//! | the robot port of a program without threads | `port` |
//!
//! Nodes, cycle, homing and counts are set by [`CanopenConfig`](crate::config::CanopenConfig). Nothing here
//! knows a bus or a clock: tests run it through every failure in simulated time.

pub mod frame;

pub mod slcan;

pub mod sdo;

pub mod cia402;

mod cause;

mod setup;

mod node;

pub mod master;

mod port;

pub use cause::{Cause, DriveName, Foreign, Nonsense};
pub use frame::Frame;
pub use port::{CanopenArm, CanopenArmError, Frames};
