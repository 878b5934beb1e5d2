//! Tetrad's tracker as a smart camera on a microcontroller.
//!
//! ```text
//! sensor ─picture─► capture ──┐                              ┌─► send ─frames─► serial line
//!            ▲                ├─ inputs ─► track ─ packets ──┘
//! serial line ─bytes─► receive┘              │
//!            └──────── buffers, emptied ─────┘
//! ```
//!
//! | job | file | knows a board |
//! |---|---|---|
//! | what tasks hand to each other | `handover` | no |
//! | pictures from a sensor into free buffers | `capture` | no |
//! | commands out of a line's bytes | `receive` | no |
//! | pictures and commands to packets | `track` | no |
//! | packets to a line's bytes | `send` | no |
//! | what is particular to a board | `board` | yes |
//!
//! What is computed is `tetrad-core`'s: the same packets, to the byte, as a desktop computes of the same
//! pictures. A picture's buffer is handed over and never copied; nothing allocates.
#![no_std]

pub mod board;
pub mod capture;
pub mod handover;
pub mod receive;
pub mod send;
pub mod track;
