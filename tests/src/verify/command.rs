//! Running a program for a check: its log, its time limit, and what is shown when it fails.

use super::Outcome;
use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How often a running program is looked at.
const POLL: Duration = Duration::from_millis(50);

/// Lines of a failed program's output that are shown.
const TAIL_LINES: usize = 40;

/// Where things are, and which check is running.
#[derive(Clone, Debug)]
pub struct Context {
    /// The top of the checkout.
    pub repository: PathBuf,
    /// Cargo's target directory.
    pub target: PathBuf,
    /// The check that runs: what its log is named after.
    pub check: String,
}

/// What a program did.
#[derive(Debug)]
pub struct Run {
    /// Whether it ended with exit code 0 within its time.
    pub ok: bool,
    /// Everything it printed on both streams.
    pub output: String,
    /// What went wrong, in a line; empty when nothing did.
    pub failure: String,
}

impl Context {
    /// For the checkout at `repository`.
    #[must_use]
    pub fn new(repository: &Path) -> Self {
        let target =
            std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| repository.join("target"), PathBuf::from);
        Self { repository: repository.to_owned(), target: repository.join(target), check: String::new() }
    }

    /// The same for the check `name`, with an empty log.
    #[must_use]
    pub fn named(&self, name: &str) -> Self {
        // Without a log a check still runs; writing it reports what is wrong with the folder.
        let _ = fs::remove_file(self.log_path(name));
        Self { check: name.to_owned(), ..self.clone() }
    }

    /// The log of the check `name`.
    #[must_use]
    pub fn log_path(&self, name: &str) -> PathBuf {
        self.target.join("verify").join(format!("{name}.log"))
    }

    /// The cargo that runs this program, with `arguments`, in the checkout.
    pub fn cargo<I: IntoIterator<Item = S>, S: AsRef<OsStr>>(&self, arguments: I) -> Command {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.args(arguments).current_dir(&self.repository);
        cargo
    }

    /// Runs `command` to its end, at most `limit`; what it prints is appended to the check's log.
    pub fn run(&self, command: &mut Command, limit: Duration) -> Run {
        self.try_run(command, limit).unwrap_or_else(|error| Run {
            ok: false,
            output: String::new(),
            failure: format!("{}: {error}", command.get_program().display()),
        })
    }

    fn try_run(&self, command: &mut Command, limit: Duration) -> io::Result<Run> {
        let path = self.log_path(&self.check);
        let mut log = open(&path)?;
        writeln!(log, "$ {}", shown(command))?;
        let start = fs::metadata(&path)?.len();
        // Both streams into one file: no pipe can fill up, and the log is there when this is killed.
        let mut child = command.stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log).spawn()?;
        let started = Instant::now();
        let failure = loop {
            match child.try_wait()? {
                Some(status) if status.success() => break String::new(),
                Some(status) => break format!("{} ended with {status}", shown(command)),
                None if started.elapsed() > limit => {
                    child.kill()?;
                    child.wait()?;
                    break format!("{} did not end within {} s", shown(command), limit.as_secs());
                }
                None => std::thread::sleep(POLL),
            }
        };
        let text = String::from_utf8_lossy(&fs::read(&path)?).into_owned();
        let output = text.get(usize::try_from(start).unwrap_or(0)..).unwrap_or(&text).to_owned();
        Ok(Run { ok: failure.is_empty(), output, failure })
    }
}

impl Run {
    /// Passed when the program ended with 0; else failed, showing the end of its output.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        if self.ok { Outcome::pass() } else { Outcome::fail(self.tail()) }
    }

    /// The failure and the last lines of the output.
    #[must_use]
    pub fn tail(&self) -> String {
        let lines: Vec<&str> = self.output.lines().collect();
        let last = lines[lines.len().saturating_sub(TAIL_LINES)..].join("\n");
        format!("{last}\n{}", self.failure)
    }
}

fn open(path: &Path) -> io::Result<File> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    OpenOptions::new().create(true).append(true).open(path)
}

/// A command as one would type it.
fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name().unwrap_or_default();
    let words = command.get_args().map(|word| word.to_string_lossy().into_owned());
    std::iter::once(program.to_string_lossy().into_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn context(name: &str) -> Context {
        let folder = std::env::temp_dir().join(format!("tetrad-verify-{}-{name}", std::process::id()));
        Context { repository: folder.clone(), target: folder, check: name.into() }
    }

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn both_streams_are_kept_and_the_exit_code_decides() {
        let context = context("streams");
        let run = context.run(&mut shell("echo out; echo err >&2"), Duration::from_secs(60));
        assert!(run.ok && run.output.contains("out") && run.output.contains("err"), "{run:?}");
        let run = context.run(&mut shell("echo second; exit 3"), Duration::from_secs(60));
        assert!(!run.ok && run.failure.contains('3'), "{run:?}");
        assert!(!run.output.contains("err"), "only its own output: {run:?}");
        assert!(run.tail().contains("second"));
        fs::remove_dir_all(&context.target).unwrap();
    }

    #[test]
    fn a_program_that_does_not_end_is_stopped() {
        let context = context("limit");
        let mut sleep = Command::new("sleep");
        let run = context.run(sleep.arg("600"), Duration::ZERO);
        assert!(!run.ok && run.failure.contains("did not end"), "{run:?}");
        fs::remove_dir_all(&context.target).unwrap();
    }

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let context = context("absent");
        let run = context.run(&mut Command::new("/no/such-program"), Duration::from_secs(1));
        assert!(!run.ok && run.failure.contains("such-program"), "{run:?}");
        fs::remove_dir_all(&context.target).unwrap();
    }
}
