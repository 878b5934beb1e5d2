//! Promise: what the firmware costs stays under its ceilings, and a change of it shows.
//!
//! `cargo verify --only firmware-qemu` prints the table; `TETRAD_BLESS=1` with it rewrites
//! tests/snapshots/firmware.txt. Counts are of instructions, exact and the same on every computer for one
//! compiler; with another compiler they are others, which is what the slack is for.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs, io};
use tetrad_fixtures::golden::blessing;
use tetrad_qemu::board::{self, Board};
use tetrad_qemu::clip::Sequence;
use tetrad_qemu::elf;
use tetrad_qemu::tape::Tape;

/// Names the file for what was measured, which `cargo verify` prints.
const SHOWN: &str = "TETRAD_FIGURES";

/// How far a figure may be from the snapshot's: another compiler.
const SLACK: f64 = 0.1;

/// One instruction counts as 1024 ns.
const COUNTING: &str = "shift=10,sleep=off";

/// What must not be passed. Those of the pose and the inverse are meant for a build for the Cortex-M7, which
/// computes in double precision where this one, for both boards, has it done by a library.
const CEILINGS: [(&str, u64); 10] = [
    ("track-paper instructions", 400_000),
    ("track-refined instructions", 1_000_000),
    ("pose-paper instructions", 60_000),
    ("pose-refined instructions", 60_000),
    ("puma-inverse instructions", 40_000),
    ("track-paper stack", 6 * 1024),
    ("track-refined stack", 6 * 1024),
    ("pose-refined stack", 6 * 1024),
    ("trackers-of-two-cameras bytes", 8 * 1024),
    ("camera-flash bytes", 96 * 1024),
];

/// Ceilings that are passed today: the snapshot holds these where they are.
const MISSED: [&str; 5] = [
    "camera-flash bytes",
    "pose-refined instructions",
    "puma-inverse instructions",
    "track-paper stack",
    "track-refined stack",
];

type Figures = BTreeMap<String, u64>;

fn measured() -> io::Result<[Figures; 2]> {
    // a ball of 30 px is 15 px wide at half the size
    let tape = Tape::of(&Sequence { scene: "static-30px", frames: (1..16).collect() });
    let folder = tempfile::tempdir()?;
    fs::write(folder.path().join("tetrad.tape"), tape.bytes())?;
    let sizes = elf::sizes(&board::programs()?.join("mps2-camera"))?;
    let mut boards = Vec::new();
    for board in Board::ALL {
        let said = board.run("mps2-figures", folder.path(), COUNTING)?;
        let mut figures: Figures = said.lines().filter_map(figure).collect();
        let (_, camera) = board.play(&tape)?;
        figures.extend(camera.lines().filter_map(figure));
        figures.insert("camera-flash bytes".into(), sizes.flash.into());
        figures.insert("camera-ram bytes".into(), sizes.ram.into());
        boards.push(figures);
    }
    boards.try_into().map_err(|_| io::Error::other("two boards"))
}

/// `name value unit` as name and unit, and the value.
fn figure(line: &str) -> Option<(String, u64)> {
    let [name, value, unit] = line.split_whitespace().collect::<Vec<_>>()[..] else { return None };
    Some((format!("{name} {unit}"), value.parse().ok()?))
}

fn table(figures: &Figures) -> String {
    let mut table = String::new();
    for (name, value) in figures {
        let _ = write!(table, "{name:<34}{value:>10}");
        if name.ends_with("instructions") {
            let _ = write!(table, "{:>9.3} ms at 480 MHz, an instruction a cycle", *value as f64 / 480e3);
        }
        if let Some((_, ceiling)) = CEILINGS.iter().find(|(of, _)| of == name) {
            let missed = if MISSED.contains(&name.as_str()) { ": not reached" } else { "" };
            let _ = write!(table, "  at most {ceiling}{missed}");
        }
        table.push('\n');
    }
    table
}

#[test]
fn the_figures_are_under_their_ceilings_and_as_they_were() -> io::Result<()> {
    let [first, second] = measured()?;
    let shown = table(&first);
    if let Some(place) = env::var_os(SHOWN) {
        fs::write(place, &shown)?;
    }
    assert_eq!(first, second, "one program takes as many instructions on both boards");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../snapshots/firmware.txt");
    if blessing() {
        fs::write(&file, &shown)?;
    }
    for (name, ceiling) in CEILINGS {
        let value = first.get(name).copied().ok_or_else(|| io::Error::other(format!("no figure: {name}")))?;
        let missed = MISSED.contains(&name);
        assert!(missed || value <= ceiling, "{name}: {value} is above {ceiling}\n{shown}");
        assert!(!missed || value > ceiling, "{name}: {value} is under {ceiling} now: strike it from MISSED");
    }
    let kept = fs::read_to_string(file)?;
    let mut kept: Figures = kept.lines().filter_map(snapshot).collect();
    for (name, value) in &first {
        let was =
            kept.remove(name).ok_or_else(|| io::Error::other(format!("new: {name}; TETRAD_BLESS=1")))?;
        let change = (*value as f64 - was as f64).abs() / (was as f64).max(1.0);
        assert!(change <= SLACK, "{name}: {value}, was {was}; if that is meant, TETRAD_BLESS=1\n{shown}");
    }
    assert!(kept.is_empty(), "no longer measured: {kept:?}");
    Ok(())
}

/// A line of the snapshot: name, unit, value, and remarks.
fn snapshot(line: &str) -> Option<(String, u64)> {
    let mut words = line.split_whitespace();
    let (name, unit, value) = (words.next()?, words.next()?, words.next()?);
    Some((format!("{name} {unit}"), value.parse().ok()?))
}
