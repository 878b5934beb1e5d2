//! What a station has in memory, so that a leak shows at its end.

use super::say;
use std::fs;
use std::time::{Duration, Instant};

/// By then everything is open, and the first of each kind has been through.
const SETTLED: Duration = Duration::from_secs(10);

/// Looks at the beginning and at the end.
pub(super) struct Memory {
    began: Instant,
    settled_kb: Option<u64>,
}

impl Memory {
    pub(super) fn begin() -> Self {
        Self { began: Instant::now(), settled_kb: None }
    }

    /// Now and then; only the first look after the station has settled costs anything.
    pub(super) fn look(&mut self) {
        if self.settled_kb.is_none() && self.began.elapsed() >= SETTLED {
            self.settled_kb = resident_kb();
        }
    }

    /// Says it, where the system tells.
    pub(super) fn report(&self) {
        let Some(end_kb) = resident_kb() else { return };
        let before = self.settled_kb.map_or_else(String::new, |kb| {
            let minutes = self.began.elapsed().saturating_sub(SETTLED).as_secs_f64() / 60.0;
            format!("; {:.1} MB {minutes:.1} minutes before", kb as f64 * 1e-3)
        });
        say(format_args!("memory          {:.1} MB{before}", end_kb as f64 * 1e-3));
    }
}

/// The memory that is this program's own at the moment, kB.
pub(super) fn resident_kb() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    resident_of(&status)
}

fn resident_of(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernels_line_is_read() {
        let status = "Name:\ttetrad\nVmHWM:\t  210680 kB\nVmRSS:\t  210672 kB\nThreads:\t3\n";
        assert_eq!(resident_of(status), Some(210_672));
        assert_eq!(resident_of("Name:\ttetrad\n"), None);
    }
}
