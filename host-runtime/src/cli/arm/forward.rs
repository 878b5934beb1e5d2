//! `tetrad arm fk`: joints -> pose.

use super::table::{JOINTS, Output, POSE, Table, TableError, numbers_of};
use std::io::{Read, Write};
use tetrad_core::arm::puma560::Puma560;

/// The largest angle that can be meant, radians: 160 turns, as far as the inverse believes one. Beyond,
/// angles lose digits, and their sums are no numbers in the end.
const MAX_ANGLE_RAD: f64 = 1000.0;

/// Copies the table, each row with the pose of the tool behind it.
pub(super) fn convert(arm: &Puma560<f64>, input: impl Read, output: impl Write) -> Result<(), TableError> {
    let mut table = Table::open(input, JOINTS)?;
    table.refuse(&POSE)?;
    let mut output = Output::new(output);
    output.fields(table.header()).fields(POSE).end()?;
    output.flush()?;
    while table.advance()? {
        let joints = table.numbers()?;
        output.fields(table.record());
        match joints {
            Some(joints) => {
                table.refuse_beyond(MAX_ANGLE_RAD, "radians", &joints)?;
                output.numbers(&numbers_of(&arm.forward(&joints)))
            }
            None => output.fields(POSE.map(|_| "")),
        };
        output.end()?;
        output.flush()?;
    }
    Ok(())
}
