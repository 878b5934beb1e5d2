//! `val2:/dev/ttyUSB0?baud=9600`: a PUMA 560 with its own controller, driven as a person would at the
//! terminal of VAL II.
//!
//! | job | file |
//! |---|---|
//! | the address and its settings | `settings` |
//! | bytes -> lines, questions, errors, the prompt | `reader` |
//! | commands and numbers as text | `text` |
//! | VAL's joint angles against the model's | `convention` |
//! | how far apart set-points may be | `pace` |
//! | the conversation, without a line | `dialogue` |
//! | the serial line, the log | `line` |
//! | the thread between both | `worker` |
//! | the port | `port` |
//!
//! # What it can do
//!
//! A terminal is no servo loop. One joint point is about 71 characters, 74 ms at 9600 baud, and a
//! reading of the joints 250 ms: 8 to 10 points a second open loop where the controller knows PPOINT
//! (V+), about 3 where POINT is answered (every VAL) or joints are read each time. Set-points come
//! faster; the newest one is sent when the prompt is back, none is kept. Each point is a move of its
//! own, with its own acceleration and braking. [`Val2Port::notice`] says so to the user.
//!
//! # Stopping
//!
//! What is certain: after a stop nothing that moves is sent. The move under way is finished by the
//! controller; no command is known to be sure to end it early (ABORT ends programs), so moves are kept
//! to a quarter of a second at the speed the controller was given, and what cuts a move short is the
//! arm's own emergency stop.
//!
//! # What is taken for granted of VAL, and what is not
//!
//! Certain: 8N1, commands end in CR and are echoed, the prompt, questions and error texts as `reader`
//! has them. Not certain: the columns of WHERE, the wording of questions and errors, whether the
//! prompt after a move means begun or finished (either will do: another point is sent when it is
//! back). Everything was tried against an emulator, nothing against an arm. `log=FILE` keeps every
//! byte: send it with a report.

mod reader;

mod convention;
mod text;

mod pace;
mod settings;

mod dialogue;

mod line;
mod worker;

mod port;

pub use convention::{Convention, ValDegrees};
pub use dialogue::Dialogue;
pub use pace::Moves;
pub use port::{Val2OpenError, Val2Port, open};
pub use reader::{Heard, Reader};
pub use settings::{Dialect, Val2AddressError, Val2Config, parse};
