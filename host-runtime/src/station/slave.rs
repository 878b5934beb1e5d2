//! The slave station as the host has it: [core's](tetrad_core::arm::station), in double precision, with any arm
//! that can be driven.

use crate::robot::Robot;
use tetrad_core::arm::station::{self, Station};

/// A slave with its arm.
pub type SlaveStation = Station<f64, Box<dyn Robot>>;

/// What came of one cycle.
pub type Cycle = station::Cycle<f64>;
