//! The operator's console: a page in a browser that shows what the operator's loop knows, and a third place
//! for its buttons.
//!
//! ```text
//! browser --WebSocket /live (buttons in, snapshots out), /pictures (JPEG out, thanks in), POST /api/stop-->
//!    app: one table of routes, on one thread of its own, one niceness lower (serve)
//!       ^ newest snapshot, newest pictures            | who drives, what is pressed
//!       |                      desk                   v
//!    the operator's loop, which publishes after its turns, and asks for the buttons before each
//!    preview threads, which make JPEG of a camera's pictures while somebody looks
//! ```
//!
//! Nothing here is in the motion's way: what both sides share is a place for the newest of each kind, locked
//! for a copy, and no queue. What decides who drives and whether the button is held ([`control`]) knows no
//! sockets and is told the time. [`app`] makes the routes without a socket, so that tests ask them directly.
//!
//! docs/console.md says what the pages do, the rules they keep, and every route.

pub mod access;
pub mod app;
mod arm;
mod checklist;
pub mod control;
pub mod desk;
mod files;
mod live;
mod metrics;
mod onlooker;
mod pages;
mod pictures;
mod plotly;
mod replay;
mod room;
mod serve;
mod setup;
pub mod snapshot;
#[cfg(test)]
pub(crate) mod testing;

pub use access::{Access, Token};
pub use checklist::{Checker, Checklist};
pub use desk::{Desk, ViewKind};
pub(crate) use files::Files;
pub use files::FilesError;
pub use onlooker::onlooker;
pub use replay::Sessions;
pub use serve::{Console, ConsoleError};
pub use setup::{SetUp, SetUpCamera, SetUpPlace};
