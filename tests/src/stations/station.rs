//! One station's process.

use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// How often a station is looked at.
const POLL: Duration = Duration::from_millis(20);

/// How long a station may take to end when it is told to: an arm has to come to rest.
const LEAVE: Duration = Duration::from_secs(10);

/// Linux tells times of processes in hundredths of a second, whatever its own clock (USER_HZ).
const TICK_S: f64 = 0.01;

/// A station that runs. Dropped, it is killed: none outlives a run that failed.
#[derive(Debug)]
pub struct Station {
    name: String,
    child: Child,
    log: PathBuf,
    /// How long its log was when it was started.
    logged: usize,
}

/// A station that ended.
#[derive(Debug)]
pub struct Ended {
    /// What it is called.
    pub name: String,
    /// How it ended.
    pub status: ExitStatus,
    /// What it printed.
    pub said: String,
}

impl Station {
    pub(super) fn start(name: &str, mut command: Command, log: PathBuf) -> Result<Self, String> {
        let at = |error: std::io::Error| format!("{name}: {error}");
        let file = OpenOptions::new().create(true).append(true).open(&log).map_err(at)?;
        let logged = fs::read_to_string(&log).map_or(0, |text| text.len());
        let errors = file.try_clone().map_err(at)?;
        let child = command.stdin(Stdio::null()).stdout(file).stderr(errors).spawn().map_err(at)?;
        Ok(Self { name: name.to_owned(), child, log, logged })
    }

    /// What it printed so far.
    #[must_use]
    pub fn said(&self) -> String {
        let all = fs::read(&self.log).unwrap_or_default();
        String::from_utf8_lossy(all.get(self.logged..).unwrap_or_default()).into_owned()
    }

    /// Its memory, kB; `None` where that cannot be known or it has ended.
    #[must_use]
    pub fn memory_kb(&self) -> Option<u64> {
        let status = fs::read_to_string(format!("/proc/{}/status", self.child.id())).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
        line.split_whitespace().next()?.parse().ok()
    }

    /// What its threads have taken of the processors, seconds, summed by their names; empty where that cannot be
    /// known. Threads that have ended are left out.
    #[must_use]
    pub fn taken_s(&self) -> BTreeMap<String, f64> {
        let mut taken = BTreeMap::new();
        for thread in self.threads() {
            *taken.entry(thread.name).or_default() += thread.taken_s;
        }
        taken
    }

    /// Whether threads of this name have a real-time priority.
    #[must_use]
    pub fn goes_first(&self, name: &str) -> bool {
        let mut theirs = self.threads().into_iter().filter(|thread| thread.name == name).peekable();
        theirs.peek().is_some() && theirs.all(|thread| thread.priority > 0.0)
    }

    fn threads(&self) -> Vec<Thread> {
        let Ok(threads) = fs::read_dir(format!("/proc/{}/task", self.child.id())) else { return Vec::new() };
        let stats = threads.flatten().map(|thread| fs::read_to_string(thread.path().join("stat")));
        stats.filter_map(|stat| Thread::read(&stat.ok()?)).collect()
    }

    /// Whether it is still at work.
    pub fn runs(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// Waits until it said this.
    ///
    /// # Errors
    /// What it said instead, when it ended or the time was over.
    pub fn until_said(&mut self, what: &str, limit: Duration) -> Result<(), String> {
        let began = Instant::now();
        while !self.said().contains(what) {
            if began.elapsed() > limit || !self.runs() {
                return Err(format!("{} never said \"{what}\":\n{}", self.name, self.said()));
            }
            std::thread::sleep(POLL);
        }
        Ok(())
    }

    /// Waits until it ends by itself.
    ///
    /// # Errors
    /// What it printed, when it does not.
    pub fn wait(mut self, limit: Duration) -> Result<Ended, String> {
        let began = Instant::now();
        loop {
            let status = self.child.try_wait().map_err(|error| format!("{}: {error}", self.name))?;
            if let Some(status) = status {
                return Ok(Ended { name: self.name.clone(), status, said: self.said() });
            }
            if began.elapsed() > limit {
                return Err(format!("{} does not end:\n{}", self.name, self.said()));
            }
            std::thread::sleep(POLL);
        }
    }

    /// Tells it to end (SIGTERM) and waits for that.
    ///
    /// # Errors
    /// What it printed, when it does not end.
    pub fn end(self) -> Result<Ended, String> {
        self.signal("-TERM")?;
        self.wait(LEAVE)
    }

    /// Neither hears nor says anything for so long (SIGSTOP, SIGCONT), as when its cable is cut.
    ///
    /// # Errors
    /// Why that was not possible.
    pub fn silence(&self, length: Duration) -> Result<(), String> {
        self.signal("-STOP")?;
        std::thread::sleep(length);
        self.signal("-CONT")
    }

    fn signal(&self, signal: &str) -> Result<(), String> {
        let told = Command::new("kill").args([signal, &self.child.id().to_string()]).status();
        told.map(drop).map_err(|error| format!("kill: {error}"))
    }

    /// Kills it (SIGKILL), as a computer that loses its power.
    ///
    /// # Errors
    /// Why that was not possible.
    pub fn kill(mut self) -> Result<Ended, String> {
        self.child.kill().map_err(|error| format!("{}: {error}", self.name))?;
        self.wait(LEAVE)
    }
}

impl Drop for Station {
    fn drop(&mut self) {
        // one that ended is no longer there to be killed
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A thread, as its line in /proc has it (proc(5)).
#[derive(Debug, PartialEq)]
struct Thread {
    name: String,
    /// What it has taken of the processors, seconds (fields 14 and 15).
    taken_s: f64,
    /// Its real-time priority, 0 for none (field 40).
    priority: f64,
}

impl Thread {
    fn read(stat: &str) -> Option<Self> {
        // the name stands in brackets and may have any
        let (before, after) = stat.rsplit_once(')')?;
        let name = before.split_once('(')?.1.to_owned();
        let field = |number: usize| after.split_whitespace().nth(number - 3)?.parse::<f64>().ok();
        Some(Self { name, taken_s: (field(14)? + field(15)?) * TICK_S, priority: field(40)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_threads_name_and_time_are_read() {
        let stat = "71 (a (b) c) S 1 71 71 0 -1 4194304 100 0 0 0 150 25 0 0 -4 0 3 0 900 0 0 184 0 0 0 0 0 0 0 0 0 0 0 0 \
                    -1 1 3 1073741826 0 0 0";
        let thread = Thread { name: "a (b) c".to_owned(), taken_s: 1.75, priority: 3.0 };
        assert_eq!(Thread::read(stat), Some(thread));
        assert_eq!(Thread::read("71 (x) S 1"), None);
    }
}
