//! Promise: what an operator does in a browser moves the arm, and whatever goes wrong there stops it.
//!
//! Chromium is driven over WebDriver (`browser`), `tetrad` runs as a process (`program`), somebody else looks
//! on over a socket of their own (`witness`), and what the arm did is read from what the slave told by its
//! own clock. One test at a time: two browsers more would leave nothing of a small computer for the arm.
//!
//! `cargo verify --only console` installs the browser and runs this; without one the tests are skipped by name.
//! Pictures of the pages are left in target/verify/screens.

mod browser;
mod driver;
mod encrypted;
mod eyes;
mod full_screen;
mod holding;
mod late;
mod line_clock;
mod others;
mod pages;
mod program;
mod proxy;
mod replay;
mod scale_and_home;
mod setup;
mod silent;
mod start;
mod stops;
mod strangers;
mod teaching;
mod webdriver;
mod witness;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Nobody else's turn while this is kept.
fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    // a test that has failed is no reason for the next to fail
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}
