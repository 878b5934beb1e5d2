//! Four coloured balls, one to eight ordinary cameras, six degrees of freedom.
//!
//! `tetrad-core` is the part of Tetrad that runs everywhere: on a desktop, in a test and on a
//! microcontroller. It allocates nothing, reads no clock, prints nothing and holds no `unsafe`.
//! Time and identity are arguments. The same frames give the same bits on every target.
//!
//! # The path
//!
//! A module uses only modules above it; a test holds it to that. Sections are the paper's.
//!
//! | stage | module | in -> out | refuses |
//! |---|---|---|---|
//! | words | [`real`], [`geometry`], [`observation`], [`config`] | - | settings that cannot be worked with |
//! | frame | [`vision::frame`] | bytes -> pixels on demand | wrong length, stride, odd chroma widths |
//! | colour (2) | [`vision::colour`] | pixel, reference -> V, D, M; eq. 1 | a ball like its background |
//! | search (3.2) | [`vision::search`] | region -> coordinates, uniform or spiral | - |
//! | edges (3.3) | [`vision::edges`] | pixel inside -> rim, row by row | no match, inconsistent, unbounded |
//! | centre (3.3) | [`vision::centre`] | rim -> centre, diameter, area (eq. 2) | - |
//! | learning (3.1) | [`vision::learn`] | point in a ball -> its colours and size | no ball, too small, no contrast, ... |
//! | appearance (3.5) | [`vision::appearance`] | detections -> colours that follow the light | colours without contrast |
//! | occlusion (3.4) | [`vision::occlusion`] | two balls that touch -> the hidden one's centre (eq. 3) | - |
//! | validation (3.5) | [`vision::validation`] | finds -> do they look and stand right? | - |
//! | detection (3.2) | [`vision::detect`] | region -> scored finds | what is no ball |
//! | tracker (fig. 4) | [`vision::tracker`] | frame, time -> four observations | settings, balls without contrast |
//! | hand (4) | [`hand`] | observations of all views -> alpha, Phi, pose (eq. 4 to 8) | missing balls, degenerate views |
//! | wire | [`wire`] | packets <-> bytes | damaged, foreign or impossible packets |
//! | arm (5) | [`arm`] | pose of the tool <-> joints of a PUMA 560 | out of reach, out of range, silent changes of branch |
//! | smart camera | [`node`] | pictures, commands -> packets | what cannot be learnt or tracked, with a reason |
//!
//! # Conventions
//!
//! SI units: metres, seconds, radians, f32. Times are microseconds (`_us`) of a clock that the
//! caller names. Image: x right, y down, pixel centres at integers, (0, 0) the centre of the
//! top-left pixel. Transforms are `a_from_b`, points `x_in_a`, matrices act on column vectors.
//! Balls are ordered red (origin), green (E1), blue (E2), yellow (E3).
//!
//! # Features
//!
//! - `eight-views`, on by default: up to eight cameras may look at a hand ([`config::MAX_VIEWS`]); without it two,
//!   and a hand's tracker takes an eighth of the memory.
//! - `defmt`: what a firmware may want to log can be formatted.
//!
//! # Panics
//!
//! None, once a checked constructor has succeeded; the firmware checks prove it at link time.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

// In the order of the path: a module uses only modules above it.

pub mod real;

pub mod geometry;

pub mod observation;

pub mod config;

// How far something goes while nobody sees it: what the balls of one camera and the hand share.
mod unseen;

pub mod vision;

pub mod hand;

pub mod wire;

pub mod arm;

pub mod node;
