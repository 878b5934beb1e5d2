//! Promise: what the firmware costs stays under its ceilings, and a change of it shows.
//!
//! `cargo verify --only firmware-qemu` prints the table; `TETRAD_BLESS=1` with it rewrites
//! tests/snapshots/firmware.txt. Counts are of instructions, exact and the same on every computer for one
//! compiler; with another compiler they are others, which is what the slack is for.
//!
//! Two builds are measured, one for the M4F and one for the M7; poses and the arm of the second alone, built
//! to be fast, as its slave is. firmware/Cargo.toml says what is built how, and why.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs, io};
use tetrad_fixtures::golden::blessing;
use tetrad_qemu::board::{Build, Target};
use tetrad_qemu::clip::Sequence;
use tetrad_qemu::elf::{Program, Sizes};
use tetrad_qemu::slave::SlaveTape;
use tetrad_qemu::tape::Tape;

/// Names the file for what was measured, which `cargo verify` prints.
const SHOWN: &str = "TETRAD_FIGURES";

/// How far a figure may be from the snapshot's: another compiler.
const SLACK: f64 = 0.1;

/// One instruction counts as 1024 ns.
const COUNTING: &str = "shift=10,sleep=off";

/// What no build may pass.
const CEILINGS: [(&str, u64); 13] = [
    ("track-paper instructions", 400_000),
    ("track-paper-most instructions", 400_000),
    ("track-refined instructions", 1_000_000),
    ("track-refined-most instructions", 1_000_000),
    ("track-paper stack", 6 * 1024),
    ("track-refined stack", 6 * 1024),
    ("global-search stack", 6 * 1024),
    ("lost-ball stack", 6 * 1024),
    ("learn stack", 6 * 1024),
    ("self-test stack", 6 * 1024),
    ("slave stack", 6 * 1024),
    ("trackers-of-two-cameras bytes", 8 * 1024),
    ("core-flash bytes", 96 * 1024),
];

/// What the build for the M7 may not pass besides: of a pose and of the arm there is only that one.
const CEILINGS_OF_THE_HAND: [(&str, u64); 4] = [
    ("pose-paper instructions", 60_000),
    ("pose-refined instructions", 60_000),
    ("puma-inverse instructions", 40_000),
    ("pose-refined stack", 6 * 1024),
];

/// What was measured of each build, in the order of [`Build::ALL`].
type Figures = BTreeMap<String, [Option<u64>; 2]>;

fn measured() -> io::Result<Figures> {
    // a ball of 30 px is 15 px wide at half the size
    let tape = Tape::of(&Sequence { scene: "static-30px", frames: (1..16).collect() });
    let folder = tempfile::tempdir()?;
    fs::write(folder.path().join("tetrad.tape"), tape.bytes())?;
    let arm = tempfile::tempdir()?;
    fs::write(arm.path().join("tetrad.tape"), SlaveTape::recorded().bytes())?;
    let mut figures = Figures::new();
    for (column, target) in Target::OWN.into_iter().enumerate() {
        let mut said = target.run("mps2-figures", folder.path(), COUNTING)?;
        if target.build == Build::CortexM4F {
            let foreign = Target::FOREIGN.run("mps2-figures", folder.path(), COUNTING)?;
            assert_eq!(said, foreign, "one program takes as many instructions on both boards");
        } else {
            said += &target.run("mps2-hand", folder.path(), COUNTING)?;
        }
        said += &target.run("mps2-slave", arm.path(), COUNTING)?;
        said += &target.play(&tape)?.1;
        let [camera, slave, core] =
            ["mps2-camera", "mps2-slave", "core-alone"].map(|name| sizes(target.build, name));
        let (camera, slave, core) = (camera?, slave?, core?);
        let _ = write!(said, "core-flash {} bytes\ncamera-flash {} bytes\n", core.flash, camera.flash);
        let _ = writeln!(said, "camera-ram {} bytes", camera.ram);
        let _ = write!(said, "slave-flash {} bytes\nslave-ram {} bytes\n", slave.flash, slave.ram);
        for (name, value) in said.lines().filter_map(figure) {
            figures.entry(name).or_default()[column] = Some(value);
        }
    }
    Ok(figures)
}

fn sizes(build: Build, name: &str) -> io::Result<Sizes> {
    Program::new(&fs::read(build.program(name)?)?)?.sizes()
}

/// `name value unit` as name and unit, and the value.
fn figure(line: &str) -> Option<(String, u64)> {
    let [name, value, unit] = line.split_whitespace().collect::<Vec<_>>()[..] else { return None };
    Some((format!("{name} {unit}"), value.parse().ok()?))
}

/// Every figure a line: name, unit, the builds' values, and what is said of them.
fn table(figures: &Figures) -> String {
    let mut table = String::from("# instructions as ms: of the M7, at 480 MHz, an instruction a cycle\n");
    let _ = writeln!(table, "#{:>44}{:>12}", "Cortex-M4F", "Cortex-M7");
    for (name, values) in figures {
        let [m4f, m7] = values.map(|value| value.map_or_else(|| "-".into(), |value| value.to_string()));
        let _ = write!(table, "{name:<33}{m4f:>12}{m7:>12}");
        if let (true, [_, Some(m7)]) = (name.ends_with("instructions"), values) {
            let _ = write!(table, "{:>10.3} ms", *m7 as f64 / 480e3);
        }
        if let Some((_, ceiling)) = ceilings().find(|(of, _)| of == name) {
            let _ = write!(table, "  at most {ceiling}");
        }
        table.push('\n');
    }
    table
}

fn ceilings() -> impl Iterator<Item = (&'static str, u64)> {
    CEILINGS.into_iter().chain(CEILINGS_OF_THE_HAND)
}

#[test]
fn the_figures_are_under_their_ceilings_and_as_they_were() -> io::Result<()> {
    let figures = measured()?;
    let shown = table(&figures);
    if let Some(place) = env::var_os(SHOWN) {
        fs::write(place, &shown)?;
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../snapshots/firmware.txt");
    if blessing() {
        fs::write(&file, &shown)?;
    }
    for (name, ceiling) in CEILINGS {
        let values = figures.get(name).copied().unwrap_or_default();
        assert!(values.iter().all(Option::is_some), "no figure: {name}\n{shown}");
        assert!(is_kept(values, ceiling), "{name}: {values:?}, at most {ceiling}\n{shown}");
    }
    for (name, ceiling) in CEILINGS_OF_THE_HAND {
        let values = figures.get(name).copied().unwrap_or_default();
        assert!(values[1].is_some(), "no figure: {name}\n{shown}");
        assert!(is_kept(values, ceiling), "{name}: {values:?}, at most {ceiling}\n{shown}");
    }
    let kept: Figures = fs::read_to_string(file)?.lines().filter_map(snapshot).collect();
    for (name, values) in &figures {
        let was = kept.get(name).ok_or_else(|| io::Error::other(format!("new: {name}; TETRAD_BLESS=1")))?;
        let is_near = values.iter().zip(was).all(|pair| match pair {
            (Some(value), Some(was)) => (*value as f64 - *was as f64).abs() <= SLACK * (*was as f64).max(1.0),
            (value, was) => value == was,
        });
        assert!(is_near, "{name}: {values:?}, was {was:?}; if that is meant, TETRAD_BLESS=1\n{shown}");
    }
    let gone: Vec<_> = kept.keys().filter(|name| !figures.contains_key(*name)).collect();
    assert!(gone.is_empty(), "no longer measured: {gone:?}");
    Ok(())
}

/// Whether no build passes a ceiling.
fn is_kept(values: [Option<u64>; 2], ceiling: u64) -> bool {
    values.into_iter().flatten().all(|value| value <= ceiling)
}

/// A line of the snapshot: name, unit, the builds' values, and remarks.
fn snapshot(line: &str) -> Option<(String, [Option<u64>; 2])> {
    let mut words = line.split_whitespace();
    let (name, unit) = (words.next().filter(|name| *name != "#")?, words.next()?);
    let values = [words.next()?.parse().ok(), words.next()?.parse().ok()];
    Some((format!("{name} {unit}"), values))
}
