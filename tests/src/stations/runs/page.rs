//! The drive page closed, read and open on two cameras, in turn.
//!
//! One operator with two simulated cameras of 640x480 at 30 pictures a second and a simulated arm with two eyes. What
//! it takes of the processors is read from /proc; how long a picture takes to become a motion that is sent, from
//! sent.csv; how many pictures of each view were drawn, from what the page has thanked for. All of it is compared
//! with the turns without the page: a page that shows nothing costs nothing, and is none.
//!
//! The delay is judged both ways: where the page is read, as by a browser that runs elsewhere, and where
//! a browser draws it without a graphics card at the same processors. What moves the arm goes before that where the
//! system allows it; where it does not, such a browser delays everything there for itself, and its figure
//! is told only.

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
[[slave.camera]]
source = \"sim:arm\"
fps = 10
[[slave.camera]]
source = \"sim:arm\"
fps = 10
[console]
listen = \"127.0.0.1:0\"
";

/// A turn; what is left of it after a browser has started or ended is measured.
const TURN: Duration = Duration::from_secs(10);
const SETTLE: Duration = Duration::from_secs(4);

/// So long a browser may take to open it on a busy computer.
const OPENS: Duration = Duration::from_secs(60);

/// What counts the pictures of a view that pages have drawn.
const SHOWN: &str = "tetrad_console_shown_total{view=\"";

/// The page may take so much of one processor.
const MOST_SHARE: f64 = 0.25;

/// And make the 99th percentile from picture to datagram so many times as long.
const MOST_RATIO: f64 = 1.2;

/// The views of the drive page, each with the pictures a second that there are of it: of the cameras 15 of 30
/// (console/onlooker.rs), of the eyes what [`FILE`] says.
const VIEWS: [(&str, f64); 4] =
    [("sim:demo left", 15.0), ("sim:demo right", 15.0), ("left eye", 10.0), ("right eye", 10.0)];

/// So much of them the browser has to draw, on a computer that draws without a graphics card...
const LEAST_DRAWN: f64 = 0.5;

/// ...and so much of them the reader has to read.
const LEAST_READ: f64 = 0.8;

/// Motions a second there are where the hand is tracked in each picture, and so much of them there has to be.
const MOTIONS: f64 = 30.0;
const LEAST_MOTIONS: f64 = 0.8;

/// What was measured of one kind of turns.
#[derive(Default)]
struct Turns {
    /// Of the wall, seconds.
    length_s: f64,
    /// By the operator's clock, seconds.
    spans_s: Vec<(f64, f64)>,
    /// Of the processors, by the thread's name, seconds.
    taken_s: BTreeMap<String, f64>,
    /// Pictures that were drawn, by the view's name.
    drawn: BTreeMap<String, f64>,
}

impl Turns {
    /// The share of one processor that is taken.
    fn share(&self) -> f64 {
        self.taken_s.values().sum::<f64>() / self.length_s
    }

    fn share_of(&self, thread: &str) -> f64 {
        self.taken_s.get(thread).copied().unwrap_or_default() / self.length_s
    }

    /// Pictures of a view that were drawn a second.
    fn rate_of(&self, view: &str) -> f64 {
        self.drawn.get(view).copied().unwrap_or_default() / self.length_s
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

    let goes_first = operator.goes_first("slave");
    let [mut closed, mut read, mut open] = [Turns::default(), Turns::default(), Turns::default()];
    let began = Instant::now();
    while began.elapsed() < length {
        until_looked_at(&console, 0.0)?;
        measure(&operator, &console, &mut closed)?;
        let reader =
            PageReader::open(&console, VIEWS.len()).map_err(|error| format!("{console}: {error}"))?;
        measure(&operator, &console, &mut read)?;
        drop(reader);
        until_looked_at(&console, 0.0)?;
        let browser = Browser::show(&format!("http://{console}/drive"), &cell.out("browser"))?;
        until_looked_at(&console, 2.0)?;
        measure(&operator, &console, &mut open)?;
        drop(browser);
    }
    well(&operator.end()?)?;
    let delays_ms = |turns: &Turns| delays_ms(&cell.out("page"), &turns.spans_s);
    let delays = [delays_ms(&closed)?, delays_ms(&read)?, delays_ms(&open)?];
    judge([&closed, &read, &open], delays, goes_first)
}

/// Waits until there are so many of a page's sockets: /live and /pictures, or none.
fn until_looked_at(console: &str, sockets: f64) -> Result<(), String> {
    let began = Instant::now();
    loop {
        let there = number(console, "tetrad_console_web_sockets")?;
        if (there - sockets).abs() < 0.5 {
            return Ok(());
        }
        if began.elapsed() > OPENS {
            return Err(format!("{there} sockets of a page are open, and not {sockets}"));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// A number of /metrics.
fn number(console: &str, name: &str) -> Result<f64, String> {
    let metrics = get(console, "/metrics").map_err(|error| format!("{console}: {error}"))?;
    let value = metrics.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' ')?.parse().ok());
    value.ok_or_else(|| format!("{console}: there is no {name} in its /metrics"))
}

/// Pictures that were drawn since the start, by the view's name.
fn drawn(metrics: &str) -> BTreeMap<String, f64> {
    let views = metrics.lines().filter_map(|line| line.strip_prefix(SHOWN)?.split_once("\"} "));
    views.filter_map(|(view, count)| Some((view.to_owned(), count.parse().ok()?))).collect()
}

/// Lets it settle, and looks at what it takes.
fn measure(operator: &Station, console: &str, turns: &mut Turns) -> Result<(), String> {
    let shown = || get(console, "/metrics").map(|text| drawn(&text)).map_err(|e| format!("{console}: {e}"));
    std::thread::sleep(SETTLE);
    let (began, from_s, before, drawn_before) =
        (Instant::now(), clock_s(console)?, operator.taken_s(), shown()?);
    std::thread::sleep(TURN);
    let (to_s, after, drawn_after) = (clock_s(console)?, operator.taken_s(), shown()?);
    turns.length_s += began.elapsed().as_secs_f64();
    turns.spans_s.push((from_s, to_s));
    add(&mut turns.drawn, &drawn_before, &drawn_after)?;
    add(&mut turns.taken_s, &before, &after)
}

/// Adds how much each has grown.
fn add(
    sums: &mut BTreeMap<String, f64>,
    before: &BTreeMap<String, f64>,
    after: &BTreeMap<String, f64>,
) -> Result<(), String> {
    for (name, was) in before {
        // what a thread took that has ended is not known any more
        if after.get(name).is_none_or(|is| is < was) {
            return Err(format!("of what {name} counts some is gone: did it end in between?"));
        }
    }
    for (name, is) in after {
        *sums.entry(name.clone()).or_default() += is - before.get(name).copied().unwrap_or_default();
    }
    Ok(())
}

/// The operator's clock, seconds.
fn clock_s(console: &str) -> Result<f64, String> {
    let snapshot = get(console, "/api/snapshot").map_err(|error| format!("{console}: {error}"))?;
    let time = snapshot.split_once("\"time_us\":").and_then(|(_, rest)| rest.split(',').next()?.parse().ok());
    time.map(|us: f64| us * 1e-6).ok_or_else(|| format!("{console}: there is no time in {snapshot}"))
}

/// From the later camera's picture in memory to the motion handed to the link, within these spans, ms.
fn delays_ms(out: &Path, spans_s: &[(f64, f64)]) -> Result<Vec<f64>, String> {
    let file = out.join("sent.csv");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(text.lines().skip(1).filter_map(|row| delay_ms(row, spans_s)).collect())
}

/// The smallest that 99 of 100 do not exceed.
fn p99(mut delays_ms: Vec<f64>) -> Option<f64> {
    delays_ms.sort_by(f64::total_cmp);
    let at = (delays_ms.len() * 99).div_ceil(100).checked_sub(1)?;
    delays_ms.get(at).copied()
}

/// `sequence,capture,ready,first,joined,posed,sent`
fn delay_ms(row: &str, spans_s: &[(f64, f64)]) -> Option<f64> {
    let mut fields = row.split(',').map(|field| field.parse::<f64>().ok());
    let (ready_s, sent_s) = (fields.nth(2)??, fields.nth(3)??);
    let within = spans_s.iter().any(|(from_s, to_s)| (*from_s..*to_s).contains(&sent_s));
    within.then_some((sent_s - ready_s) * 1e3)
}

/// What was measured with the page closed, read and drawn, and how long each motion took then, ms.
fn judge(turns: [&Turns; 3], delays_ms: [Vec<f64>; 3], goes_first: bool) -> Result<String, String> {
    let [closed, read, open] = turns;
    let mut wrong = Vec::new();
    for (kind, turns, delays_ms) in
        [("closed", closed, &delays_ms[0]), ("read", read, &delays_ms[1]), ("drawn", open, &delays_ms[2])]
    {
        let rate = delays_ms.len() as f64 / turns.length_s;
        if !rate.is_finite() || rate < LEAST_MOTIONS * MOTIONS {
            wrong.push(format!("{rate:.1} motions a second with the page {kind}, of {MOTIONS}"));
        }
        if turns.taken_s.values().sum::<f64>() <= 0.0 {
            wrong.push(format!("nobody knows what was taken of the processors with the page {kind}"));
        }
    }
    let mut report = String::new();
    for (view, most) in VIEWS {
        let [without, read, drawn] = turns.map(|turns| turns.rate_of(view));
        // writing to a string does not fail
        let _ =
            writeln!(report, "{view:<16} {drawn:5.1} pictures a second drawn, {read:5.1} read, of {most}");
        for (rate, least, what) in [(drawn, LEAST_DRAWN, "drawn"), (read, LEAST_READ, "read")] {
            if rate < least * most {
                let least = least * most;
                wrong.push(format!(
                    "{view}: {rate:.1} pictures a second {what}, at least {least:.1} are wanted"
                ));
            }
        }
        if without > 0.0 {
            wrong.push(format!("{view}: {without:.1} pictures a second drawn with the page closed"));
        }
    }
    let [Some(closed_ms), Some(read_ms), Some(open_ms)] = delays_ms.map(p99) else {
        return Err(format!("{report}{}", wrong.join("\n")));
    };
    let (cost, ratio, drawn) = (open.share() - closed.share(), read_ms / closed_ms, open_ms / closed_ms);
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
         and {open_ms:.3} ms with a browser at the same processors: {drawn:.2} times ({})",
        if goes_first {
            format!("at most {MOST_RATIO}")
        } else {
            "not judged: the system lets nothing go first".to_owned()
        }
    );
    // what is no number is within no bound
    let within = cost <= MOST_SHARE && ratio <= MOST_RATIO && (!goes_first || drawn <= MOST_RATIO);
    if !within {
        wrong.push("the page takes more than it may".to_owned());
    }
    if wrong.is_empty() { Ok(report) } else { Err(format!("{report}{}", wrong.join("\n"))) }
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
    fn pictures_are_counted_by_their_view() {
        let metrics = "# TYPE tetrad_console_shown_total counter\n\
                       tetrad_console_shown_total{view=\"sim:demo left\"} 7\n\
                       tetrad_console_shown_total{view=\"left eye\"} 0\n\
                       tetrad_console_sockets 3\n";
        let counts = drawn(metrics);
        assert_eq!(counts, BTreeMap::from([("sim:demo left".to_owned(), 7.0), ("left eye".to_owned(), 0.0)]));
        let mut sums = BTreeMap::new();
        let later = BTreeMap::from([("sim:demo left".to_owned(), 9.0), ("left eye".to_owned(), 1.0)]);
        add(&mut sums, &counts, &later).unwrap();
        assert_eq!((sums["sim:demo left"], sums["left eye"]), (2.0, 1.0));
        assert!(add(&mut sums, &later, &counts).is_err(), "what was counted is gone");
        assert!(add(&mut sums, &later, &BTreeMap::new()).is_err());
    }

    /// Ten seconds in which `thread` took so much and each view was drawn so often of what there is.
    fn turns(thread_s: f64, drawn: f64) -> Turns {
        Turns {
            length_s: 10.0,
            taken_s: BTreeMap::from([("camera".to_owned(), 5.0), ("console".to_owned(), thread_s)]),
            drawn: VIEWS.map(|(view, most)| (view.to_owned(), most * drawn * 10.0)).into(),
            ..Turns::default()
        }
    }

    fn judged(open: &Turns, read_ms: f64) -> Result<String, String> {
        let motions = |ms: f64| vec![ms; 300];
        let delays_ms = [motions(10.0), motions(read_ms), motions(21.0)];
        judge([&turns(0.0, 0.0), &turns(1.0, 1.0), open], delays_ms, false)
    }

    #[test]
    fn what_the_page_takes_is_judged() {
        let report = judged(&turns(2.0, 1.0), 11.0).unwrap();
        assert!(report.contains("costs 20.0 %") && report.contains("1.10 times"), "{report}");
        assert!(report.contains("2.10 times"), "{report}");
        assert!(judged(&turns(3.0, 1.0), 11.0).is_err());
        assert!(judged(&turns(2.0, 1.0), 12.5).is_err());
        assert!(judged(&turns(2.0, 1.0), f64::NAN).is_err());
        let drawn = |ms: f64| {
            let (closed, open, motions) = (turns(0.0, 0.0), turns(1.0, 1.0), |ms: f64| vec![ms; 300]);
            judge([&closed, &open, &open], [motions(10.0), motions(10.0), motions(ms)], true)
        };
        assert!(drawn(11.0).is_ok() && drawn(12.5).is_err(), "where it may go first");
    }

    #[test]
    fn a_page_that_shows_nothing_is_not_cheap() {
        let none = judged(&turns(0.1, 0.0), 10.0).unwrap_err();
        assert!(none.contains("left eye: 0.0 pictures a second drawn, at least 5.0"), "{none}");
        let mut one_missing = turns(0.1, 1.0);
        one_missing.drawn.remove("sim:demo right");
        assert!(judged(&one_missing, 10.0).unwrap_err().contains("sim:demo right: 0.0"));
        assert!(judged(&turns(0.1, 0.4), 10.0).is_err(), "a fair share of them is wanted");
        assert!(judged(&turns(0.1, 0.6), 10.0).is_ok());
    }

    #[test]
    fn what_was_not_measured_is_not_judged_well() {
        let (closed, open) = (turns(0.0, 0.0), turns(0.1, 1.0));
        let motions = |count: usize| vec![10.0; count];
        let all = [motions(300), motions(300), motions(300)];
        let judge = |turns: [&Turns; 3], delays_ms| super::judge(turns, delays_ms, false);
        judge([&closed, &open, &open], all.clone()).unwrap();
        // no hand is tracked, nobody reads, somebody looks all the time, and no thread is known
        assert!(judge([&closed, &open, &open], [motions(300), motions(200), motions(300)]).is_err());
        assert!(judge([&closed, &open, &open], [motions(300), motions(300), Vec::new()]).is_err());
        assert!(judge([&closed, &turns(0.1, 0.7), &open], all.clone()).is_err());
        assert!(judge([&open, &open, &open], all.clone()).is_err());
        let unknown = Turns { taken_s: BTreeMap::new(), ..turns(0.0, 0.0) };
        assert!(judge([&unknown, &open, &open], all).is_err());
    }
}
