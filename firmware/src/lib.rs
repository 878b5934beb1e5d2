//! Tetrad on a microcontroller: its tracker as a smart camera, its slave at the arm.
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
//! | pictures over the line in place of a sensor's | `streamed` | no |
//! | packets to a line's bytes | `send` | no |
//! | the same packets for two lines | `share` | no |
//! | a line's bytes in the payloads of CAN FD | `can_fd` | no |
//! | what the log says | `log` | no |
//! | learning by a button | `teach` | no |
//! | setting up the image sensor OV7725 | `ov7725` | no |
//! | pose and arm as bytes, for comparing | `probes` | no |
//! | an operator's packets and drives' frames to set-points | `slave` | no |
//! | what a CAN bus is asked for | `can` | no |
//! | what is particular to a board | `board` | yes |
//!
//! What is computed is `tetrad-core`'s: the same packets, to the byte, as a desktop computes of the same
//! pictures. A picture's buffer is handed over and never copied; nothing allocates.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod board;
pub mod can;
pub mod can_fd;
pub mod capture;
pub mod handover;
mod log;
pub mod ov7725;
pub mod probes;
pub mod receive;
pub mod send;
pub mod share;
pub mod slave;
pub mod streamed;
pub mod teach;
pub mod track;
