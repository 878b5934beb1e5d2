//! `arm_state.csv`: what the slave told its operator, one row a packet that came.

use super::csv::{CsvFile, OutputError, Row};
use crate::link::Received;
use crate::station::arm_words;
use std::path::Path;
use tetrad_core::arm::governor::Limits;
use tetrad_core::wire::ArmStatePacket;

/// `t,slave_t,sequence,state,why,limits,share,age_ms,s1..s6,q1..q6,x,y,z,r11..r33`: when it came, by the
/// operator's clock, and when it was so, by the slave's, seconds; the law's state and its reason's number
/// (docs/wire.md); the names of what limits the arm with a space between them (a joint's number behind
/// it); the share of its speed that is asked for; the age of the newest motion, by the slave's clock;
/// set-points and measured joints in radians; the tool at the set-point, metres in the robot's base. What
/// is not known is empty.
#[derive(Debug)]
pub struct ArmStateCsv(CsvFile);

impl ArmStateCsv {
    /// Creates the file in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        let header = "t,slave_t,sequence,state,why,limits,share,age_ms,s1,s2,s3,s4,s5,s6,\
                      q1,q2,q3,q4,q5,q6,x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33";
        CsvFile::create(dir, "arm_state.csv", header).map(Self)
    }

    /// Adds a packet.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn write(&mut self, came: &Received<ArmStatePacket>) -> Result<(), OutputError> {
        let packet = &came.what;
        self.0.row(|row| {
            row.time(seconds(came.received_us)).time(seconds(packet.time_us)).field(packet.sequence);
            row.field(arm_words::state_name(packet.state)).field(packet.reason as u8);
            let names = Limits::from_bits(packet.limits).iter().map(|limit| match limit.joint() {
                Some(joint) => format!("{}_{joint}", limit.name()),
                None => limit.name().to_owned(),
            });
            row.field(names.collect::<Vec<_>>().join(" ")).number(packet.speed_share);
            match packet.command_age_us() {
                Some(us) => row.field(us as f64 / 1e3),
                None => row.empty(),
            };
            numbers(row, &packet.set_point);
            numbers(row, &packet.measured.map_or([f32::NAN; 6], |measured| measured.joints));
            numbers(row, &packet.tool.translation);
            numbers(row, &packet.tool.rotation);
        })
    }
}

fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

fn numbers(row: &mut Row<'_>, values: &[f32]) {
    for value in values {
        row.number(*value);
    }
}
