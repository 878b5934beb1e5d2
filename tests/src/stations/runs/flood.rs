//! Garbage as fast as it goes to the slave's port, while the arm follows.

use super::FIND;
use crate::stations::arm_record;
use crate::stations::cell::Cell;
use crate::stations::crew::{Others, operator, well};
use crate::stations::delays::p99_ms;
use crate::stations::garbage;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Datagrams in the flood.
const GARBAGE: u64 = 10_000_000;

/// What garbage may delay motion by, ms: the 99th percentile of the motions that came.
const FLOODED_MS: f64 = 10.0;

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
    let held = arm.holds();
    let _ = writeln!(report, "the arm held {held} times for want of fresh commands");
    Ok(report)
}
