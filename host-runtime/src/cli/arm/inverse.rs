//! `tetrad arm ik`: pose -> joints.

use super::table::{JOINTS, Output, POSE, Table, TableError, pose_of};
use std::io::{Read, Write};
use tetrad_core::arm::puma560::{Configuration, Elbow, Puma560, Shoulder, Solution, Unreachable, Wrist};

/// The columns before and behind the joints.
const BEFORE: [&str; 5] = ["case", "solution", "shoulder", "elbow", "wrist"];
const BEHIND: [&str; 2] = ["in_range", "reason"];

/// Why a pose has no row of its own although it can be reached.
const OUT_OF_RANGE: &str = "every solution has a joint out of its range";

/// The farthest place that can be meant, metres.
const MAX_PLACE_M: f64 = 1000.0;

/// Writes the solutions of each row, or the reason why there is none.
pub(super) fn convert(
    arm: &Puma560<f64>,
    in_range: bool,
    input: impl Read,
    output: impl Write,
) -> Result<(), TableError> {
    let mut table = Table::open(input, POSE)?;
    let case = table.place("case");
    let mut output = Output::new(output);
    output.fields(BEFORE).fields(JOINTS).fields(BEHIND).end()?;
    output.flush()?;
    let mut number = 0u64;
    while table.advance()? {
        number += 1;
        let numbered = number.to_string();
        let case = case.and_then(|place| table.record().get(place)).unwrap_or(&numbered);
        let Some(numbers) = table.numbers()? else {
            return Err(table.problem("the pose is empty: leave the row out"));
        };
        let [x, y, z, ..] = numbers;
        table.refuse_beyond(MAX_PLACE_M, "metres", &[x, y, z])?;
        match arm.inverse(&pose_of(numbers), &[0.0; 6]) {
            Ok(solutions) => {
                let wanted = solutions.iter().filter(|solution| !in_range || solution.outside.is_empty());
                let mut count = 0;
                for solution in wanted {
                    count += 1;
                    write(&mut output, case, count, solution)?;
                }
                if count == 0 {
                    refuse(&mut output, case, OUT_OF_RANGE)?;
                }
            }
            Err(error @ (Unreachable::NotARotation | Unreachable::PoseNotFinite)) => {
                return Err(table.problem(format!("{error}: check r11 to r33, row by row")));
            }
            Err(reason) => refuse(&mut output, case, &reason.to_string())?,
        }
        output.flush()?;
    }
    Ok(())
}

fn write<W: Write>(
    output: &mut Output<W>,
    case: &str,
    number: u8,
    solution: &Solution<f64>,
) -> Result<(), TableError> {
    let Configuration { shoulder, elbow, wrist } = solution.configuration;
    let shoulder = match shoulder {
        Shoulder::Right => "right",
        Shoulder::Left => "left",
    };
    let elbow = match elbow {
        Elbow::Up => "up",
        Elbow::Down => "down",
    };
    let wrist = match wrist {
        Wrist::NoFlip => "no-flip",
        Wrist::Flip => "flip",
    };
    let in_range = if solution.outside.is_empty() { "true" } else { "false" };
    output.fields([case, &number.to_string(), shoulder, elbow, wrist]).numbers(&solution.joints);
    output.fields([in_range, ""]).end()
}

fn refuse<W: Write>(output: &mut Output<W>, case: &str, reason: &str) -> Result<(), TableError> {
    let empty = BEFORE.len() - 1 + JOINTS.len() + BEHIND.len() - 1;
    output.field(case).fields(std::iter::repeat_n("", empty)).field(reason).end()
}
