//! A station of the right authority that is nobody's peer, and one of the operator's name from another
//! authority, while the true operator is not there.

use super::FIND;
use crate::stations::arm_record;
use crate::stations::cell::Cell;
use crate::stations::crew::Others;
use std::fmt::Write as _;
use std::time::Duration;

pub(super) fn run(cell: &Cell, _: Duration) -> Result<String, String> {
    let mut others = Others::start(cell)?;
    // one that is there already cannot be taken for refused
    others.slave.until_said("arm at", FIND)?;
    let (mut report, mut refused) = (String::new(), 0);
    for name in ["stranger", "impostor"] {
        let stranger = cell.start("operator", name, &["--hold-to-run", "always", "--seconds", "4"])?;
        let ended = stranger.wait(FIND)?;
        let _ = writeln!(report, "--- {name}\n{}", ended.said.trim_end());
        if ended.said.contains("is connected") {
            return Err(format!("{name} got in:\n{report}"));
        }
        let told = others.slave.said();
        let lines = told.lines().filter(|line| line.contains("is refused")).count();
        if lines < refused + 1 {
            return Err(format!("the slave does not tell of {name}:\n{told}\n{report}"));
        }
        refused = lines;
    }
    let [.., slave] = others.end()?;
    let arm = arm_record::read(&cell.out("slave"))?;
    let moved_m = arm.way_m();
    let _ = writeln!(report, "--- slave\n{}", slave.said.trim_end());
    if moved_m > 0.0 || arm.followed() {
        return Err(format!("a stranger moved the arm by {moved_m} m\n{report}"));
    }
    let _ = writeln!(report, "the arm did not move");
    Ok(report)
}
