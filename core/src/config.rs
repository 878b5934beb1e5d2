//! Every capacity and threshold of the core in one table: value, unit, origin.

/// The most cameras that may look at one hand (DESIGN: one to eight).
pub const MAX_VIEWS: usize = 8;
