//! Four coloured balls, one to eight ordinary cameras, six degrees of freedom.
//!
//! `tetrad-core` is the part of Tetrad that runs everywhere: on a desktop, in a test and on a
//! microcontroller. It allocates nothing, reads no clock, prints nothing and holds no `unsafe`.
//! Time and identity are arguments. The same frames give the same bits on every target.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

// In the order of the path: a module uses only modules above it.

pub mod geometry;

pub mod observation;

pub mod config;

pub mod vision;

pub mod hand;

pub mod wire;
