//! The refined pose on simulated pinhole cameras, by theme.

mod accuracy;
mod any_input;
mod cameras;
mod degraded;
mod engaging;
mod simulated;
mod tally;
mod trust;
