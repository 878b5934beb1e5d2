//! Whether stations grow.

use super::station::Station;
use std::fmt::Write as _;

/// Memory may grow by so much after it was warm, kB: allocators settle, leaks do not.
const GROWTH_KB: u64 = 4_096;

const NAMES: [&str; 4] = ["left", "right", "slave", "operator"];

/// What the four had when they were warm, and what they had at last, kB.
#[derive(Debug, Default)]
pub(super) struct Memory {
    warm: Option<[u64; 4]>,
    last: Option<[u64; 4]>,
}

impl Memory {
    pub(super) fn look(&mut self, stations: [&Station; 4], warm: bool) {
        let now = stations.map(Station::memory_kb);
        // one that has ended has none
        if now.iter().any(Option::is_none) {
            return;
        }
        self.last = Some(now.map(Option::unwrap_or_default));
        if warm {
            self.warm = self.warm.or(self.last);
        }
    }

    /// A line a station.
    ///
    /// # Errors
    /// One has grown.
    pub(super) fn judge(&self, report: &mut String) -> Result<(), String> {
        let Some((warm, last)) = self.warm.zip(self.last) else { return Ok(()) };
        for (name, (warm, last)) in NAMES.iter().zip(warm.into_iter().zip(last)) {
            let _ = writeln!(report, "memory of {name}: {warm} kB warm, {last} kB at the end");
            if last > warm + GROWTH_KB {
                return Err(format!("{name} grew from {warm} to {last} kB\n{report}"));
            }
        }
        Ok(())
    }
}
