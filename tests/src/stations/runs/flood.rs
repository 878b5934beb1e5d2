//! Garbage as fast as it goes to the slave's port, while the arm follows.

use super::FIND;
use crate::stations::arm_record;
use crate::stations::cell::Cell;
use crate::stations::crew::{Others, operator, well};
use crate::stations::delays::p99_ms;
use crate::stations::garbage;
use crate::stations::pictures::pauses;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Datagrams in the flood.
const GARBAGE: u64 = 10_000_000;

/// What garbage may delay motion by, ms: the 99th percentile of the motions that came.
const FLOODED_MS: f64 = 10.0;

/// An operator that has no picture for so long sends nothing that is fresh, seconds: an arm that holds has
/// not heard for 0.1 s, and a picture is on its way for some ms.
const PAUSE_S: f64 = 0.08;

/// The longest it may take.
const LONGEST: Duration = Duration::from_secs(600);

const POLL: Duration = Duration::from_millis(50);

pub(super) fn run(cell: &Cell, length: Duration) -> Result<String, String> {
    let others = Others::start(cell)?;
    let mut operator = operator(cell, length.max(LONGEST))?;
    operator.until_said("engaged", FIND)?;
    let ended = AtomicBool::new(false);
    let target = cell.slave_address();
    let began = Instant::now();
    let sent = std::thread::scope(|scope| {
        let garbage = scope.spawn(|| garbage::send(target, GARBAGE, &ended));
        while !garbage.is_finished() {
            if !operator.runs() {
                ended.store(true, Ordering::Relaxed);
            }
            std::thread::sleep(POLL);
        }
        garbage.join().unwrap_or_else(|_| Err("the thread that floods ended".to_owned()))
    })?;
    let took_s = began.elapsed().as_secs_f64();
    let operator = operator.end()?;
    others.end()?;
    well(&operator)?;
    let arm = arm_record::read(&cell.out("slave"))?;
    let mut report = operator.said;
    let way_m = arm.way_m();
    let _ = writeln!(
        report,
        "--- flood\n{sent} datagrams of garbage in {took_s:.1} s; the tool was sent {way_m:.2} m"
    );
    if sent < GARBAGE {
        return Err(format!("the operator ended after {sent} datagrams\n{report}"));
    }
    if !arm.followed() {
        return Err(format!("the arm did not follow\n{report}"));
    }
    for stage in ["sent to slave", "total sent to port written"] {
        let p99_ms = p99_ms(&cell.out("operator"), stage)?;
        let _ = writeln!(report, "{stage}: p99 {p99_ms:.1} ms under garbage");
        if p99_ms > FLOODED_MS {
            return Err(format!("motion was delayed: {stage} p99 {p99_ms:.1} ms\n{report}"));
        }
    }
    let holds = arm.holds();
    let unsent = pauses(&cell.out("operator"), PAUSE_S)?;
    let _ = writeln!(
        report,
        "the arm held {} times for want of fresh commands: {} times the slave's own cycles did not come, {unsent} \
         times the operator had no picture",
        holds.count, holds.starved
    );
    if holds.count > holds.starved + unsent {
        return Err(format!("garbage held up the arm: what was sent did not come\n{report}"));
    }
    Ok(report)
}
