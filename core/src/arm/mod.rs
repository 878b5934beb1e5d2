//! The slave arm: section 5 of the paper.
//!
//! | stage | file | in -> out | refusals |
//! |---|---|---|---|
//! | kinematics | [`puma560`] | pose of the tool <-> joints; the branch to follow | [`puma560::Unreachable`], [`puma560::ChooseRefusal`] |
//! | law | [`teleop`] | commands, the operator's button, the arm -> goal of the tool, or stop | [`teleop::CommandRefusal`], [`teleop::Status`] |
//! | governor | [`governor`] | goal or stop -> the joints' next set-point, within every limit | [`governor::Limit`], [`governor::StartRefusal`] |
//! | port | [`port`] | what every controller of an arm can be asked | [`port::PortError`] |
//! | set-points | [`set_point`] | set-point -> one that a port takes | [`port::PortError`] |
//! | drives | [`canopen`] | set-points <-> frames of a CAN bus | [`canopen::Cause`] |
//! | cycle | [`slave`] | commands, button, joints -> what is to be done at the port | all of the above |
//! | station | [`station`] | an operator's packets -> the port told, the arm's state | [`station::NoReset`] |
//! | on wires | [`wired`] | packets of a serial line, frames of a CAN bus -> both | all of the above |
//!
//! Generic over f32 (the microcontroller) and f64 (the host). Nothing here panics or allocates.

pub mod puma560;

pub mod teleop;

pub mod governor;

pub mod port;

pub mod set_point;

pub mod canopen;

pub mod slave;

pub mod station;

pub mod wired;
