//! `tetrad` as a process with its console, and what its arm did.

use super::browser::LONG;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// The arm begins its stop so long after the button is not held any more, microseconds.
pub(crate) const STOP_US: u64 = 100_000;

/// And stands still so long after that, microseconds: it brakes within the accelerations of its joints.
const BRAKE_US: u64 = 500_000;

/// So many tries have to count.
const LEAST_TRIES: usize = 2;

/// How often something is looked at that is waited for.
const POLL: Duration = Duration::from_millis(20);

/// One operator with both cameras of the scene and the arm at the same computer, as `tetrad demo` has it. The
/// watchdog of the simulated controller is not what is tried: a busy computer is not to set it off.
const STATION: &str = "\
[operator]
arm_mm = 80
slave = \"here\"
[[operator.camera]]
source = \"sim:demo\"
view = \"left\"
[[operator.camera]]
source = \"sim:demo\"
view = \"right\"
[slave]
port = \"sim:?watchdog_ms=5000\"
[[slave.camera]]
source = \"sim:arm\"
fps = 15
[[slave.camera]]
source = \"sim:arm\"
view = \"right\"
fps = 15
[console]
listen = \"127.0.0.1:0\"
";

/// A program with a console. Dropped, it is killed.
pub(crate) struct Program {
    process: Child,
    scheme: &'static str,
    address: SocketAddr,
    dir: tempfile::TempDir,
}

impl Program {
    /// `tetrad demo`.
    pub(crate) fn demo() -> Self {
        Self::start(tempfile::tempdir().expect("a directory"), &["demo"])
    }

    /// `tetrad operator`, its buttons in the console.
    pub(crate) fn operator() -> Self {
        Self::operator_with("", &[])
    }

    /// The same with more lines in `[console]`, and files beside the station's.
    pub(crate) fn operator_with(console: &str, files: &[(&str, &str)]) -> Self {
        let dir = tempfile::tempdir().expect("a directory");
        for (name, text) in [("tetrad.toml", format!("{STATION}{console}").as_str())].iter().chain(files) {
            std::fs::write(dir.path().join(name), text).expect("a file");
        }
        Self::start(dir, &["operator", "--config", "tetrad.toml", "--hold-to-run", "console"])
    }

    /// `tetrad operator` with one camera at the arm.
    pub(crate) fn with_one_eye() -> Self {
        let dir = tempfile::tempdir().expect("a directory");
        let (station, console) = STATION.split_once("[console]").expect("a console");
        let (station, _) = station.rsplit_once("[[slave.camera]]").expect("a camera");
        std::fs::write(dir.path().join("tetrad.toml"), format!("{station}[console]{console}"))
            .expect("a file");
        Self::start(dir, &["operator", "--config", "tetrad.toml", "--hold-to-run", "console"])
    }

    /// The same with two, recorded as a session; `sessions` is where it lies.
    pub(crate) fn recorded(sessions: &Path) -> Self {
        let dir = tempfile::tempdir().expect("a directory");
        std::fs::write(dir.path().join("tetrad.toml"), STATION).expect("a file");
        let file = sessions.join("driven.mcap");
        let file = file.to_str().expect("a path in plain letters");
        let station = ["operator", "--config", "tetrad.toml", "--hold-to-run", "console"];
        Self::start(dir, &[&station[..], &["--record", file]].concat())
    }

    fn start(dir: tempfile::TempDir, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tetrad"));
        command.args(arguments).args(["--out", "out"]).current_dir(dir.path()).stdin(Stdio::null());
        let log = std::fs::File::create(dir.path().join("said.txt")).expect("a file");
        let errors = log.try_clone().expect("the same file");
        let process = command.stdout(log).stderr(errors).spawn().expect("the program starts");
        let nowhere = SocketAddr::from(([127, 0, 0, 1], 0));
        let mut program = Self { process, scheme: "http", address: nowhere, dir };
        let began = Instant::now();
        (program.scheme, program.address) = loop {
            if let Some(console) = console_in(&program.said()) {
                break console;
            }
            assert!(began.elapsed() < LONG, "no console: {}", program.said());
            std::thread::sleep(POLL);
        };
        program
    }

    fn said(&self) -> String {
        std::fs::read_to_string(self.dir.path().join("said.txt")).unwrap_or_default()
    }

    /// Where its console is.
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// The address of a page.
    pub(crate) fn url(&self, path: &str) -> String {
        format!("{}://{}{path}", self.scheme, self.address)
    }

    /// Ends it as Ctrl-C does, and gives what the arm did.
    pub(crate) fn end(mut self) -> Record {
        let told = Command::new("kill").args(["-INT", &self.process.id().to_string()]).status();
        assert!(told.is_ok_and(|status| status.success()), "it runs");
        let status = self.ended();
        assert!(status.success(), "{status}: {}", self.said());
        Record::read(&self.out())
    }

    /// What the arm did until now.
    pub(crate) fn so_far(&self) -> Record {
        Record::read(&self.out())
    }

    /// The folder of its results.
    pub(crate) fn out(&self) -> PathBuf {
        self.dir.path().join("out")
    }

    fn ended(&mut self) -> ExitStatus {
        let began = Instant::now();
        loop {
            if let Some(status) = self.process.try_wait().expect("a child") {
                return status;
            }
            assert!(began.elapsed() < LONG, "it does not end");
            std::thread::sleep(POLL);
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // one that ended is no longer there to be killed
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The scheme and the address in what it printed, once its line is whole.
fn console_in(said: &str) -> Option<(&'static str, SocketAddr)> {
    ["http", "https"].into_iter().find_map(|scheme| {
        let (_, rest) = said.split_once(&format!("{scheme}://"))?;
        Some((scheme, rest.split_once(['/', '\n'])?.0.parse().ok()?))
    })
}

/// The whole rows of a table so far: the last may still be written.
fn rows<T>(file: &Path, read: impl Fn(&[&str]) -> T) -> Vec<T> {
    let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let rows = text.split_inclusive('\n').filter(|line| line.ends_with('\n')).skip(1);
    rows.map(|row| read(&row.trim_end().split(',').collect::<Vec<_>>())).collect()
}

/// What the slave told of the arm, by its own clock, which is the operator's where both are one program.
pub(crate) struct Record {
    told: Vec<Told>,
    /// Each motion: when its last picture was in memory and when it was handed to the link, by the operator's clock.
    sent_us: Vec<(u64, u64)>,
}

/// One packet of it.
struct Told {
    slave_us: u64,
    engaged: bool,
    /// Where the joints were sent, radians.
    set_point: [f64; 6],
}

impl Record {
    fn read(out: &Path) -> Self {
        let us = |field: &str| (field.parse::<f64>().expect("a number") * 1e6).round() as u64;
        let told = rows(&out.join("arm_state.csv"), |fields| {
            let set_point = std::array::from_fn(|joint| fields[8 + joint].parse().expect("a number"));
            Told { slave_us: us(fields[1]), engaged: fields[3] == "engaged", set_point }
        });
        let sent_us = rows(&out.join("sent.csv"), |fields| (us(fields[2]), us(fields[6])));
        Self { told, sent_us }
    }

    /// From picture to datagram, of what was sent within these times: so long that 99 of 100 took no longer.
    pub(crate) fn delay_p99_ms(&self, spans_us: &[(u64, u64)]) -> f64 {
        let within =
            |sent_us: u64| spans_us.iter().any(|(from_us, to_us)| (*from_us..*to_us).contains(&sent_us));
        let sent = self.sent_us.iter().filter(|(_, sent_us)| within(*sent_us));
        let mut delays_us: Vec<u64> =
            sent.map(|(ready_us, sent_us)| sent_us.saturating_sub(*ready_us)).collect();
        delays_us.sort_unstable();
        assert!(!delays_us.is_empty(), "no motion was sent");
        delays_us[(delays_us.len() * 99).div_ceil(100) - 1] as f64 / 1e3
    }

    /// Whether the arm ever followed.
    pub(crate) fn moved(&self) -> bool {
        self.told.iter().any(|told| told.engaged)
    }

    /// Whether the arm was moving at a time.
    pub(crate) fn was_moving(&self, at_us: u64) -> bool {
        let before = self.told.get(..self.told.partition_point(|told| told.slave_us < at_us));
        before.and_then(<[_]>::last).is_some_and(|told| told.engaged)
    }

    /// How long after a time the arm began to stop, microseconds.
    fn stop_after(&self, at_us: u64) -> u64 {
        let mut stood = self.told.iter().filter(|told| told.slave_us >= at_us && !told.engaged);
        stood.next().expect("it stopped").slave_us - at_us
    }

    /// How long after a time the arm stood still: the joints were sent nowhere else until the next press, microseconds.
    fn rest_after(&self, at_us: u64) -> u64 {
        let stopped_us = at_us + self.stop_after(at_us);
        let stop = self.told.iter().skip_while(|told| told.slave_us < stopped_us);
        let stop: Vec<&Told> = stop.take_while(|told| !told.engaged).collect();
        let moves = |pair: &[&Told]| {
            pair[0].set_point.iter().zip(pair[1].set_point).any(|(from, to)| (from - to).abs() > 1e-6)
        };
        let last = stop.windows(2).rfind(|pair| moves(pair));
        last.map_or(stopped_us, |pair| pair[1].slave_us) - at_us
    }

    /// How long after a time the arm followed the hand for the last time before it stopped, microseconds.
    fn moved_until(&self, at_us: u64) -> u64 {
        let since = self.told.iter().filter(|told| told.slave_us >= at_us);
        since.take_while(|told| told.engaged).last().map_or(0, |told| told.slave_us - at_us)
    }

    /// Whether the arm moved from one time to another without a break.
    pub(crate) fn moved_throughout(&self, from_us: u64, to_us: u64) -> bool {
        let mut within =
            self.told.iter().filter(|told| (from_us..=to_us).contains(&told.slave_us)).peekable();
        within.peek().is_some() && within.all(|told| told.engaged)
    }

    /// The arm, which was moving, stopped in time, by the slave's own clock, in which the operator tells of the button
    /// too (they are one program):
    ///
    /// - each time, it did not follow the hand any more [`STOP_US`] after the last message that held the button came;
    /// - as a rule (the median), it began its stop within [`STOP_US`] after what ended the press, as the browser saw it;
    /// - each time, it stood still [`BRAKE_US`] after the stop began: what braking within the joints' limits takes.
    ///
    /// What a busy computer does to messages on their way from the browser is in the second alone: one that was held up
    /// there holds the button for that much longer. That the page sends none after what ended the press is looked at in
    /// the page, each time.
    #[track_caller]
    pub(crate) fn stopped_in_time(&self, what: &str, tries: &[Ended]) {
        let ms = |all: &[u64]| {
            all.iter().map(|us| format!("{:.1}", *us as f64 / 1e3)).collect::<Vec<_>>().join(", ")
        };
        let moved_us: Vec<u64> = tries.iter().map(|one| self.moved_until(one.held_us)).collect();
        let mut stops_us: Vec<u64> = tries.iter().map(|one| self.stop_after(one.at_us)).collect();
        let rests_us: Vec<u64> = tries.iter().map(|one| self.rest_after(one.at_us)).collect();
        println!(
            "measured: {what}: the arm began its stop {} ms later and stood still after {} ms; it had followed for {} ms \
             after the button was last told",
            ms(&stops_us),
            ms(&rests_us),
            ms(&moved_us)
        );
        assert!(
            tries.len() >= LEAST_TRIES,
            "{what}: the computer was too busy all but {} times",
            tries.len()
        );
        let brakes_us: Vec<u64> = rests_us.iter().zip(&stops_us).map(|(rest, stop)| rest - stop).collect();
        assert!(brakes_us.iter().all(|us| *us <= BRAKE_US), "{what}: it braked for {brakes_us:?} us");
        assert!(moved_us.iter().all(|us| *us <= STOP_US), "{what}: it moved for {moved_us:?} us");
        stops_us.sort_unstable();
        assert!(stops_us[stops_us.len() / 2] <= STOP_US, "{what}: it stopped after {stops_us:?} us");
    }
}

/// A press that has ended, by the operator's clock, microseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ended {
    /// What ended it happened in the browser, or on the line.
    pub(crate) at_us: u64,
    /// The last message came that held the button, and counted.
    pub(crate) held_us: u64,
}
