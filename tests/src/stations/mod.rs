//! Four stations on this computer's loopback: two cameras before a simulated hand, an operator, and a
//! simulated arm, each a process of its own, with keys of their own making.
//!
//! | job | file |
//! |---|---|
//! | keys, files and ports of the four | `cell` |
//! | one process: started, told to end, killed; its memory | `station` |
//! | the four, started and ended together | `crew` |
//! | what is done to them, and has to be true: a run a file | `runs` |
//! | datagrams that nobody asked for | `garbage` |
//! | what the arm did, how long stages took, whether stations grow | `arm_record`, `delays`, `memory` |
//! | when the operator had pictures | `pictures` |
//! | a page of the console, looked at | `browser` |
//!
//! Like `verify` it knows `tetrad` as a program alone, and needs nothing but the standard library.

mod arm_record;
mod browser;
mod cell;
mod crew;
mod delays;
mod garbage;
mod memory;
mod page_reader;
mod pictures;
mod runs;
mod station;

pub use cell::Cell;
pub use runs::{RUNS, Run};
pub use station::{Ended, Station};
