//! The runs: what is started, what is done to it, and what has to be true of it.

use super::arm_record::{self, fastest, way};
use super::cell::Cell;
use super::station::{Ended, Station};
use std::fmt::Write as _;
use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How long the four may take to find each other.
const FIND: Duration = Duration::from_secs(15);

/// The slave's commands are old after so long, ms, and it looks once a cycle.
const STALE_MS: f64 = 100.0;

/// A cycle may come late on a busy computer, ms: what is measured is by whose clock the arm stops, not
/// the computer's scheduler.
const LATE_MS: f64 = 20.0;

/// The tool is steered to half a metre a second, and in the worst drive goes two fifths beyond.
const FASTEST_M_S: f64 = 0.7;

/// Memory may grow by so much after it was warm, kB: allocators settle, leaks do not.
const GROWTH_KB: u64 = 4_096;

/// A run.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// What it is called.
    pub name: &'static str,
    /// What it shows.
    pub shows: &'static str,
    run: fn(&Cell, Duration) -> Result<String, String>,
}

/// Every run.
pub const RUNS: &[Run] = &[
    Run {
        name: "plain",
        shows: "the arm follows the hand through four processes; delays, losses, memory",
        run: plain,
    },
    Run {
        name: "strangers",
        shows: "who has no certificate of a named peer gets nothing, and a line in the log",
        run: strangers,
    },
    Run { name: "flood", shows: "garbage on the slave's port does not delay motion", run: flood },
    Run {
        name: "deaths",
        shows: "operator and camera are killed or silent and come back: the arm stops, then follows",
        run: deaths,
    },
];

impl Run {
    /// Runs it; what it prints.
    ///
    /// # Errors
    /// What was not as it has to be.
    pub fn run(&self, cell: &Cell, length: Duration) -> Result<String, String> {
        (self.run)(cell, length)
    }
}

/// The three that wait for the operator.
struct Others {
    left: Station,
    right: Station,
    slave: Station,
}

impl Others {
    fn start(cell: &Cell) -> Result<Self, String> {
        let out = cell.out("slave").display().to_string();
        Ok(Self {
            left: cell.start("camera", "left", &[])?,
            right: cell.start("camera", "right", &[])?,
            slave: cell.start("slave", "slave", &["--out", &out])?,
        })
    }

    fn each(&mut self) -> [&mut Station; 3] {
        [&mut self.left, &mut self.right, &mut self.slave]
    }

    /// Ends all three; each has to end well.
    fn end(self) -> Result<[Ended; 3], String> {
        let ended = [self.left.end()?, self.right.end()?, self.slave.end()?];
        ended.iter().try_for_each(well)?;
        Ok(ended)
    }
}

fn well(ended: &Ended) -> Result<(), String> {
    if ended.status.success() {
        return Ok(());
    }
    Err(format!("{} ended with {}:\n{}", ended.name, ended.status, ended.said))
}

fn operator(cell: &Cell, length: Duration) -> Result<Station, String> {
    let out = cell.out("operator").display().to_string();
    let seconds = length.as_secs_f64().to_string();
    let always = ["--hold-to-run", "always", "--seconds", &seconds, "--out", &out];
    cell.start("operator", "operator", &always)
}

/// Four stations and nothing else.
fn plain(cell: &Cell, length: Duration) -> Result<String, String> {
    let mut others = Others::start(cell)?;
    let mut operator = operator(cell, length)?;
    let mut warm = None;
    let began = Instant::now();
    let mut last = None;
    while operator.runs() {
        if began.elapsed() > length + FIND {
            return Err(format!("operator does not end:\n{}", operator.said()));
        }
        let [left, right, slave] = others.each().map(|station| station.memory_kb());
        let memory = [left, right, slave, operator.memory_kb()];
        // warm after a quarter: rings are filled, pictures have gone
        if began.elapsed() > length / 4 && warm.is_none() {
            warm = Some(memory);
        }
        if memory.iter().all(Option::is_some) {
            last = Some(memory);
        }
        std::thread::sleep(Duration::from_millis(200));
    }
    let ended = operator.wait(FIND)?;
    let others = others.end()?;
    well(&ended)?;
    let rows = arm_record::read(&cell.out("slave"))?;
    let mut report = ended.said;
    for station in &others {
        let _ = writeln!(report, "--- {}\n{}", station.name, station.said.trim_end());
    }
    let (way, fastest) = (way(&rows), fastest(&rows));
    let _ = writeln!(report, "--- all\nthe tool was sent {way:.2} m, at most {fastest:.3} m/s");
    if let (Some(warm), Some(last)) = (warm, last) {
        for (name, (warm, last)) in ["left", "right", "slave", "operator"].iter().zip(warm.iter().zip(last)) {
            let (Some(warm), Some(last)) = (warm, last) else { continue };
            let _ = writeln!(report, "memory of {name}: {warm} kB warm, {last} kB at the end");
            if last > warm + GROWTH_KB {
                return Err(format!("{name} grew from {warm} to {last} kB\n{report}"));
            }
        }
    }
    // the hand goes 0.25 m each second, and the arm finds, latches and slows at either end
    if way < 0.25 * length.as_secs_f64() * 0.5 {
        return Err(format!("the arm did not follow: it went {way:.2} m\n{report}"));
    }
    if fastest > FASTEST_M_S {
        return Err(format!("the arm jumped: {fastest:.3} m/s\n{report}"));
    }
    Ok(report)
}

/// A station of the right authority that is nobody's peer, and one of the operator's name from another
/// authority, while the true operator is not there.
fn strangers(cell: &Cell, _: Duration) -> Result<String, String> {
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
    let ended = others.end()?;
    let rows = arm_record::read(&cell.out("slave"))?;
    let moved = way(&rows);
    let _ = writeln!(report, "--- slave\n{}", ended[2].said.trim_end());
    if moved > 0.0 || rows.iter().any(|row| row.state == "engaged") {
        return Err(format!("a stranger moved the arm by {moved} m\n{report}"));
    }
    let _ = writeln!(report, "the arm did not move");
    Ok(report)
}

/// Datagrams in the flood.
const GARBAGE: u64 = 10_000_000;

/// What garbage may delay motion by, ms: the 99th percentile of the motions that came.
const FLOODED_MS: f64 = 10.0;

/// A stage's 99th percentile, from the operator's delays.csv.
fn p99_ms(cell: &Cell, stage: &str) -> Result<f64, String> {
    let file = cell.out("operator").join("delays.csv");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let row =
        text.lines().map(|line| line.split(',').collect::<Vec<_>>()).find(|row| row.first() == Some(&stage));
    let p99_us: Option<f64> = row.and_then(|row| row.get(3)?.parse().ok());
    p99_us.map(|us| us / 1e3).ok_or_else(|| format!("{}: there is no {stage}", file.display()))
}

/// Garbage as fast as it goes to the slave's port, while the arm follows.
fn flood(cell: &Cell, length: Duration) -> Result<String, String> {
    let others = Others::start(cell)?;
    let mut operator = operator(cell, length.max(Duration::from_secs(600)))?;
    operator.until_said("engaged", FIND)?;
    let ended = AtomicBool::new(false);
    let target = cell.slave_address();
    let began = Instant::now();
    let sent = std::thread::scope(|scope| {
        let garbage = scope.spawn(|| {
            let socket = UdpSocket::bind("127.0.0.1:0").map_err(|error| error.to_string())?;
            let mut state = 0x9E37_79B9_7F4A_7C15_u64;
            let mut datagram = [0_u8; 1_200];
            let mut sent = 0;
            while sent < GARBAGE && !ended.load(Ordering::Relaxed) {
                // xorshift; a fresh head each time, for a datagram is judged by that
                for chunk in datagram[..64].chunks_mut(8) {
                    state ^= state << 13;
                    state ^= state >> 7;
                    state ^= state << 17;
                    chunk.copy_from_slice(&state.to_le_bytes());
                }
                let length = 1 + (state % 1_200) as usize;
                // a full buffer is the receiver's matter
                sent += u64::from(socket.send_to(&datagram[..length], target).is_ok());
            }
            Ok::<_, String>(sent)
        });
        while !garbage.is_finished() {
            if !operator.runs() {
                ended.store(true, Ordering::Relaxed);
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        garbage.join().unwrap_or_else(|_| Err("the thread that floods ended".to_owned()))
    })?;
    let took = began.elapsed().as_secs_f64();
    let operator = operator.end()?;
    others.end()?;
    well(&operator)?;
    let rows = arm_record::read(&cell.out("slave"))?;
    let ages: Vec<f64> =
        rows.iter().filter(|row| row.state == "engaged").filter_map(|row| row.age_ms).collect();
    let mut report = operator.said;
    let _ = writeln!(
        report,
        "--- flood\n{sent} datagrams of garbage in {took:.1} s; the tool was sent {:.2} m",
        way(&rows)
    );
    if sent < GARBAGE {
        return Err(format!("the operator ended after {sent} datagrams\n{report}"));
    }
    if ages.is_empty() {
        return Err(format!("the arm did not follow\n{report}"));
    }
    for stage in ["sent to slave", "total sent to port written"] {
        let p99_ms = p99_ms(cell, stage)?;
        let _ = writeln!(report, "{stage}: p99 {p99_ms:.1} ms under garbage");
        if p99_ms > FLOODED_MS {
            return Err(format!("motion was delayed: {stage} p99 {p99_ms:.1} ms\n{report}"));
        }
    }
    let left: usize =
        rows.windows(2).filter(|pair| pair[0].state == "engaged" && pair[1].state == "hold").count();
    let _ = writeln!(report, "the arm held {left} times for want of fresh commands");
    Ok(report)
}

/// The operator is killed in the middle of a movement, twice, then silent for a second, as behind a cable
/// that is cut; then a camera is killed.
fn deaths(cell: &Cell, _: Duration) -> Result<String, String> {
    let mut others = Others::start(cell)?;
    let mut report = String::new();
    for life in 1..=2 {
        let mut operator = operator(cell, Duration::from_secs(60))?;
        operator.until_said("engaged", FIND)?;
        std::thread::sleep(Duration::from_secs(3));
        operator.kill()?;
        std::thread::sleep(Duration::from_secs(2));
        let _ = writeln!(report, "operator killed, for the {life}. time");
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
    others.end()?;
    let rows = arm_record::read(&cell.out("slave"))?;
    let mut stops = 0;
    let mut worst_ms: f64 = 0.0;
    for pair in rows.windows(2) {
        let left_off = pair[0].state == "engaged" && pair[1].state != "engaged";
        if let Some(age) = pair[1].age_ms.filter(|_| left_off) {
            stops += 1;
            worst_ms = worst_ms.max(age);
        }
    }
    let fastest = fastest(&rows);
    let _ = writeln!(report, "--- operator, at last\n{}", operator.said.trim_end());
    let _ = writeln!(
        report,
        "--- arm\n{stops} stops, begun at most {worst_ms:.1} ms after the last command that was fresh; \
         the tool was sent {:.2} m, at most {fastest:.3} m/s",
        way(&rows)
    );
    if stops < 3 {
        return Err(format!("the arm followed {stops} times and was left, not three times\n{report}"));
    }
    if worst_ms > STALE_MS + LATE_MS {
        return Err(format!("the arm began its stop {worst_ms:.1} ms after the last command\n{report}"));
    }
    if fastest > FASTEST_M_S {
        return Err(format!("the arm jumped: {fastest:.3} m/s\n{report}"));
    }
    Ok(report)
}
