//! The drive page closed, read and open on two cameras, in turn.
//!
//! One operator with two simulated cameras of 640x480 at 30 pictures a second and a simulated arm without eyes. What
//! it takes of the processors is read from /proc; how long a picture takes to become a motion that is sent, from
//! sent.csv. Both are compared with the turns without the page.
//!
//! What is judged of the delay is what the program does to it: where the page is read, its two sockets are, as
//! a browser reads them that runs elsewhere. A browser that draws it without a graphics card at the same
//! two processors delays everything there for itself; that figure is told beside.

use super::FIND;
use crate::stations::browser::{Browser, get};
use crate::stations::cell::Cell;
use crate::stations::crew::well;
use crate::stations::page_reader::PageReader;
use crate::stations::station::Station;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

const FILE: &str = "\
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
[console]
listen = \"127.0.0.1:0\"
";

/// A turn; what is left of it after a browser has started or ended is measured.
const TURN: Duration = Duration::from_secs(10);
const SETTLE: Duration = Duration::from_secs(4);

/// So long a browser may take to open it on a busy computer.
const OPENS: Duration = Duration::from_secs(60);

/// What counts the pictures that were made to be looked at.
const PICTURES: &str = "tetrad_console_pictures_total";

/// The page may take so much of one processor.
const MOST_SHARE: f64 = 0.25;

/// And make the 99th percentile from picture to datagram so many times as long.
const MOST_RATIO: f64 = 1.2;

/// The reader has to get so much of what the browser gets.
const LEAST_READ: f64 = 0.8;

/// The cameras.
const VIEWS: usize = 2;

/// What was measured of one kind of turns.
#[derive(Default)]
struct Turns {
    /// Of the wall, seconds.
    length_s: f64,
    /// By the operator's clock, seconds.
    spans_s: Vec<(f64, f64)>,
    /// Of the processors, by the thread's name, seconds.
    taken_s: BTreeMap<String, f64>,
}

impl Turns {
    /// The share of one processor that is taken.
    fn share(&self) -> f64 {
        self.taken_s.values().sum::<f64>() / self.length_s
    }

    fn share_of(&self, thread: &str) -> f64 {
        self.taken_s.get(thread).copied().unwrap_or_default() / self.length_s
    }
}

pub(super) fn run(cell: &Cell, length: Duration) -> Result<String, String> {
    cell.write("page", FILE)?;
    let out = cell.out("page").display().to_string();
    let mut operator = cell.start("operator", "page", &["--hold-to-run", "always", "--out", &out])?;
    operator.until_said("http://", FIND)?;
    let said = operator.said();
    let console = said.split_once("http://").and_then(|(_, rest)| rest.split(['/', '\n']).next());
    let console = console.ok_or_else(|| format!("no console:\n{said}"))?.to_owned();
    operator.until_said("engaged", FIND)?;

    let [mut closed, mut read, mut open] = [Turns::default(), Turns::default(), Turns::default()];
    let [mut read_pictures, mut shown] = [0.0, 0.0];
    let began = Instant::now();
    while began.elapsed() < length {
        measure(&operator, &console, &mut closed)?;
        let reader = PageReader::open(&console, VIEWS).map_err(|error| format!("{console}: {error}"))?;
        let pictures = number(&console, PICTURES)?;
        measure(&operator, &console, &mut read)?;
        read_pictures += number(&console, PICTURES)? - pictures;
        drop(reader);
        let browser = Browser::show(&format!("http://{console}/drive"), &cell.out("browser"))?;
        until_looked_at(&console)?;
        let pictures = number(&console, PICTURES)?;
        measure(&operator, &console, &mut open)?;
        shown += number(&console, PICTURES)? - pictures;
        drop(browser);
    }
    well(&operator.end()?)?;
    let p99_ms = |turns: &Turns| p99_ms(&cell.out("page"), &turns.spans_s);
    let delays = Delays { closed_ms: p99_ms(&closed)?, read_ms: p99_ms(&read)?, open_ms: p99_ms(&open)? };
    // counted over the whole turns, of which a part is measured
    let rate = |pictures: f64, turns: &Turns| {
        pictures / (turns.length_s * (SETTLE + TURN).as_secs_f64() / TURN.as_secs_f64())
    };
    let (read_rate, rate) = (rate(read_pictures, &read), rate(shown, &open));
    let rates = format!(
        "{rate:.1} pictures a second were made for the page in a browser, {read_rate:.1} where it was read\n"
    );
    if read_rate < LEAST_READ * rate {
        return Err(format!("{rates}what was read is not what a browser reads"));
    }
    let judged = judge(&closed, &open, delays);
    judged.map(|report| rates.clone() + &report).map_err(|report| rates + &report)
}

/// Waits until a page has its two sockets, /live and /pictures.
fn until_looked_at(console: &str) -> Result<(), String> {
    let began = Instant::now();
    while number(console, "tetrad_console_web_sockets")? < 2.0 {
        if began.elapsed() > OPENS {
            return Err("the browser does not open the page".to_owned());
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(())
}

/// A number of /metrics.
fn number(console: &str, name: &str) -> Result<f64, String> {
    let metrics = get(console, "/metrics").map_err(|error| format!("{console}: {error}"))?;
    let value = metrics.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' ')?.parse().ok());
    value.ok_or_else(|| format!("{console}: there is no {name} in its /metrics"))
}

/// Lets it settle, and looks at what it takes.
fn measure(operator: &Station, console: &str, turns: &mut Turns) -> Result<(), String> {
    std::thread::sleep(SETTLE);
    let (began, from_s, before) = (Instant::now(), clock_s(console)?, operator.taken_s());
    std::thread::sleep(TURN);
    let (to_s, after) = (clock_s(console)?, operator.taken_s());
    turns.length_s += began.elapsed().as_secs_f64();
    turns.spans_s.push((from_s, to_s));
    for (thread, seconds) in after {
        let before_s = before.get(&thread).copied().unwrap_or_default();
        *turns.taken_s.entry(thread).or_default() += seconds - before_s;
    }
    Ok(())
}

/// The operator's clock, seconds.
fn clock_s(console: &str) -> Result<f64, String> {
    let snapshot = get(console, "/api/snapshot").map_err(|error| format!("{console}: {error}"))?;
    let time = snapshot.split_once("\"time_us\":").and_then(|(_, rest)| rest.split(',').next()?.parse().ok());
    time.map(|us: f64| us * 1e-6).ok_or_else(|| format!("{console}: there is no time in {snapshot}"))
}

/// From the later camera's picture in memory to the motion handed to the link, within these spans: the 99th
/// percentile, ms.
fn p99_ms(out: &Path, spans_s: &[(f64, f64)]) -> Result<f64, String> {
    let file = out.join("sent.csv");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let mut delays_ms: Vec<f64> = text.lines().skip(1).filter_map(|row| delay_ms(row, spans_s)).collect();
    delays_ms.sort_by(f64::total_cmp);
    // the smallest that 99 of 100 do not exceed
    let at = (delays_ms.len() * 99).div_ceil(100).checked_sub(1);
    let p99 = at.and_then(|at| delays_ms.get(at)).copied();
    p99.ok_or_else(|| format!("{}: no motion was sent in the turns", file.display()))
}

/// `sequence,capture,ready,first,joined,posed,sent`
fn delay_ms(row: &str, spans_s: &[(f64, f64)]) -> Option<f64> {
    let mut fields = row.split(',').map(|field| field.parse::<f64>().ok());
    let (ready_s, sent_s) = (fields.nth(2)??, fields.nth(3)??);
    let within = spans_s.iter().any(|(from_s, to_s)| (*from_s..*to_s).contains(&sent_s));
    within.then_some((sent_s - ready_s) * 1e3)
}

/// From picture to datagram, the 99th percentile of each kind of turns, ms.
#[derive(Clone, Copy)]
struct Delays {
    closed_ms: f64,
    read_ms: f64,
    open_ms: f64,
}

fn judge(closed: &Turns, open: &Turns, delays: Delays) -> Result<String, String> {
    let Delays { closed_ms, read_ms, open_ms } = delays;
    let (cost, ratio) = (open.share() - closed.share(), read_ms / closed_ms);
    let mut report = String::new();
    // writing to a string does not fail
    let _ = writeln!(
        report,
        "share of one processor: {:.1} % without the page, {:.1} % with it",
        closed.share() * 100.0,
        open.share() * 100.0
    );
    for thread in open.taken_s.keys() {
        let (without, with) = (closed.share_of(thread) * 100.0, open.share_of(thread) * 100.0);
        if (with - without).abs() >= 0.5 {
            let _ = writeln!(report, "    {thread:<16} {without:6.1} % {with:6.1} %");
        }
    }
    let _ = writeln!(report, "the page costs {:.1} % (at most {:.0} %)", cost * 100.0, MOST_SHARE * 100.0);
    let _ = writeln!(
        report,
        "picture to datagram, p99: {closed_ms:.3} ms without the page, {read_ms:.3} ms where it is read: {ratio:.2} times (at most {MOST_RATIO})\n\
         and {open_ms:.3} ms with a browser at the same processors: {:.2} times",
        open_ms / closed_ms
    );
    if cost > MOST_SHARE || ratio > MOST_RATIO {
        return Err(format!("{report}the page takes more than it may"));
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_counts_within_its_turns() {
        let row = "9,4.900000,4.950000,4.951000,4.952000,4.953000,5.000000";
        let delay = delay_ms(row, &[(1.0, 2.0), (4.0, 6.0)]).unwrap();
        assert!((delay - 50.0).abs() < 1e-6);
        assert_eq!(delay_ms(row, &[(1.0, 2.0), (5.5, 6.0)]), None);
        assert_eq!(delay_ms("sequence,capture", &[(1.0, 2.0)]), None);
    }

    #[test]
    fn what_the_page_takes_is_judged() {
        let turns = |thread: &str, taken_s: f64| Turns {
            length_s: 10.0,
            taken_s: BTreeMap::from([("camera".to_owned(), 5.0), (thread.to_owned(), taken_s)]),
            ..Turns::default()
        };
        let (closed, open, dear) = (turns("console", 0.0), turns("console", 2.0), turns("console", 3.0));
        let delays = |read_ms| Delays { closed_ms: 10.0, read_ms, open_ms: 21.0 };
        let report = judge(&closed, &open, delays(11.0)).unwrap();
        assert!(report.contains("costs 20.0 %") && report.contains("1.10 times"), "{report}");
        assert!(report.contains("2.10 times"), "{report}");
        assert!(judge(&closed, &dear, delays(11.0)).is_err());
        assert!(judge(&closed, &open, delays(12.5)).is_err());
    }
}
