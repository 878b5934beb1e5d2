//! Four stations and nothing else.

use super::{FASTEST_M_S, FIND};
use crate::stations::arm_record;
use crate::stations::cell::Cell;
use crate::stations::crew::{Others, operator, well};
use crate::stations::memory::Memory;
use std::fmt::Write as _;
use std::time::{Duration, Instant};

const POLL: Duration = Duration::from_millis(200);

pub(super) fn run(cell: &Cell, length: Duration) -> Result<String, String> {
    let others = Others::start(cell)?;
    let mut operator = operator(cell, length)?;
    let mut memory = Memory::default();
    let began = Instant::now();
    while operator.runs() {
        if began.elapsed() > length + FIND {
            return Err(format!("operator does not end:\n{}", operator.said()));
        }
        let [left, right, slave] = others.each();
        // warm after a quarter: rings are filled, pictures have gone
        memory.look([left, right, slave, &operator], began.elapsed() > length / 4);
        std::thread::sleep(POLL);
    }
    let ended = operator.wait(FIND)?;
    let others = others.end()?;
    well(&ended)?;
    let arm = arm_record::read(&cell.out("slave"))?;
    let mut report = ended.said;
    for station in &others {
        let _ = writeln!(report, "--- {}\n{}", station.name, station.said.trim_end());
    }
    let (way_m, fastest_m_s) = (arm.way_m(), arm.fastest_m_s());
    let _ = writeln!(report, "--- all\nthe tool was sent {way_m:.2} m, at most {fastest_m_s:.3} m/s");
    memory.judge(&mut report)?;
    // the hand goes 0.25 m each second, and the arm finds, latches and slows at either end
    if way_m < 0.25 * length.as_secs_f64() * 0.5 {
        return Err(format!("the arm did not follow: it went {way_m:.2} m\n{report}"));
    }
    if fastest_m_s > FASTEST_M_S {
        return Err(format!("the arm jumped: {fastest_m_s:.3} m/s\n{report}"));
    }
    Ok(report)
}
