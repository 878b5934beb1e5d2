//! Four stations on this computer's loopback: two cameras before a simulated hand, an operator, and a
//! simulated arm, each a process of its own, with keys of their own making.
//!
//! | job | file |
//! |---|---|
//! | keys, files and ports of the four | `cell` |
//! | one process: started, told to end, killed; its memory | `station` |
//! | a run without faults; strangers, garbage, deaths | `runs` |
//! | what the arm did, from arm.csv | `arm_record` |
//!
//! Like `verify` it knows `tetrad` as a program alone, and needs nothing but the standard library.

mod arm_record;
mod cell;
mod runs;
mod station;

pub use cell::Cell;
pub use runs::{RUNS, Run};
pub use station::{Ended, Station};
