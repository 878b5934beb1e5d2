//! The operator is killed in the middle of a movement and started again at once, killed again and started
//! again later, then silent for a second, as behind a cable that is cut; then a camera is killed.

use super::{FASTEST_M_S, FIND};
use crate::stations::arm_record;
use crate::stations::cell::Cell;
use crate::stations::crew::{Others, operator, well};
use std::fmt::Write as _;
use std::time::Duration;

/// How long the operator is dead for, each time: once too short for a silence that ends an engagement.
const DEAD: [Duration; 2] = [Duration::from_millis(200), Duration::from_secs(2)];

/// By the slave's clock the stop begins within so long after the last fresh command came, ms, and what the
/// computer runs the cycle late that begins it is within that.
const STALE_MS: f64 = 100.0;

pub(super) fn run(cell: &Cell, _: Duration) -> Result<String, String> {
    let mut others = Others::start(cell)?;
    let mut report = String::new();
    for dead in DEAD {
        let mut operator = operator(cell, Duration::from_secs(60))?;
        operator.until_said("engaged", FIND)?;
        std::thread::sleep(Duration::from_secs(3));
        operator.kill()?;
        std::thread::sleep(dead);
        let _ = writeln!(report, "operator killed, started again {} ms later", dead.as_millis());
    }
    let mut operator = operator(cell, Duration::from_secs(16))?;
    operator.until_said("engaged", FIND)?;
    std::thread::sleep(Duration::from_secs(2));
    operator.silence(Duration::from_secs(1))?;
    let _ = writeln!(report, "operator silent for a second");
    std::thread::sleep(Duration::from_secs(2));
    let Others { left, right, slave } = others;
    left.kill()?;
    std::thread::sleep(Duration::from_secs(3));
    others = Others { left: cell.start("camera", "left", &[])?, right, slave };
    let operator = operator.wait(Duration::from_secs(40))?;
    well(&operator)?;
    let [.., slave] = others.end()?;
    let arm = arm_record::read(&cell.out("slave"))?;
    let stops = arm.stops();
    let (way_m, fastest_m_s) = (arm.way_m(), arm.fastest_m_s());
    let _ = writeln!(report, "--- operator, at last\n{}", operator.said.trim_end());
    let _ = writeln!(
        report,
        "--- arm\n{} stops, begun at most {:.1} ms after the last command that was fresh, by cycles that came up \
         to {:.1} ms late; the tool was sent {way_m:.2} m, at most {fastest_m_s:.3} m/s\n{}",
        stops.count,
        stops.latest_ms,
        stops.late_ms,
        slave.said.lines().find(|line| line.starts_with("cycles")).unwrap_or_default()
    );
    if slave.said.contains("two operator stations") {
        return Err(format!("one that was started again was taken for a second\n{}\n{report}", slave.said));
    }
    if stops.count < 3 {
        return Err(format!(
            "the arm followed {} times and was left, not three times\n{report}",
            stops.count
        ));
    }
    if stops.latest_ms > STALE_MS {
        return Err(format!(
            "the arm began its stop {:.1} ms after the last command that was fresh\n{report}",
            stops.latest_ms
        ));
    }
    if fastest_m_s > FASTEST_M_S {
        return Err(format!("the arm jumped: {fastest_m_s:.3} m/s\n{report}"));
    }
    Ok(report)
}
