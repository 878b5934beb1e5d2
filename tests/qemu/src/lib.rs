//! The firmware on QEMU's boards and on real ones, on the pictures that the desktop has.
//!
//! | job | file |
//! |---|---|
//! | scenes small enough for a microcontroller's sensor | `clip` |
//! | pictures and commands as the firmware reads them | `tape` |
//! | balls a camera is told of instead of learning them, as a tape | `given` |
//! | the repository's recorded frames, as a tape | `recorded` |
//! | what two cameras saw of a hand, as a tape | `hand` |
//! | the arm's cases, as a tape | `arm` |
//! | what the desktop makes of a tape | `desktop` |
//! | pose and arm as bytes: the firmware's own file | `probes` |
//! | what a board makes of it | `board` |
//! | what an operator and six drives do to a slave, and what the desktop makes of it | `slave` |
//! | a board whose serial line somebody is at | `live` |
//! | a camera that is shown its pictures over its line, beside the desktop | `sender` |
//! | a real board, named by a file | `board_file` |
//! | hardware in the loop: that board shown what its file names | `hil` |
//! | a line that loses bytes, and brings others | `relay` |
//! | what a line carries beside good commands | `garbage` |
//! | what a board logs, with the feature `boards` | `log` |
//! | how much memory a program takes, and where its code is | `elf` |
//! | instructions that round once where others round twice | `fused` |
//!
//! The runs are in `tests/`, behind the feature `boards`: `cargo verify --only firmware-qemu` builds the
//! firmware and runs them.

pub mod arm;
pub mod board;
pub mod board_file;
pub mod clip;
pub mod desktop;
pub mod elf;
pub mod fused;
pub mod garbage;
pub mod given;
pub mod hand;
pub mod hil;
pub mod live;
#[cfg(any(feature = "boards", feature = "stm32h743"))]
pub mod log;
#[path = "../../../firmware/src/probes.rs"]
pub mod probes;
pub mod recorded;
pub mod relay;
pub mod sender;
pub mod slave;
pub mod tape;
