//! The firmware on QEMU's boards, on the pictures that the desktop has.
//!
//! | job | file |
//! |---|---|
//! | scenes small enough for a microcontroller's sensor | `clip` |
//! | pictures and commands as the firmware reads them | `tape` |
//! | what the desktop makes of a tape | `desktop` |
//! | what a board makes of it | `board` |
//! | a board whose serial line somebody is at | `live` |
//! | what a line carries beside good commands | `garbage` |
//! | what a board logs, with the feature `boards` | `log` |
//! | how much memory a program takes | `elf` |
//!
//! The runs are in `tests/`, behind the feature `boards`: `cargo verify --only firmware-qemu` builds the
//! firmware and runs them.

pub mod board;
pub mod clip;
pub mod desktop;
pub mod elf;
pub mod garbage;
pub mod live;
#[cfg(feature = "boards")]
pub mod log;
pub mod tape;
