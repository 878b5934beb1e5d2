//! Promise: the programs for the OpenMV Cam H7 lie in the memories that they are meant for, and the camera's sizes
//! are as they were. Nothing is said of how they run: no emulator has the board.
//!
//! `cargo verify --only firmware-stm32h743` builds them and prints the sizes; `TETRAD_BLESS=1` with it rewrites
//! tests/snapshots/stm32h743.txt.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::{env, fs, io};
use tetrad_fixtures::golden::blessing;
use tetrad_qemu::elf::{Program, Segment};
use tetrad_qemu::log::messages;

/// Names the folder of the programs; `cargo verify` sets it.
const PROGRAMS: &str = "TETRAD_STM32H743";

/// The camera, and the one that is shown its pictures over the line.
const CAMERA: &str = "stm32h743-camera";
const STREAMED: &str = "stm32h743-streamed";

/// The camera with a log.
const LOGGING: &str = "stm32h743-camera-logging";

/// Names the file for what was measured, which `cargo verify` prints.
const SHOWN: &str = "TETRAD_FIGURES";

/// How far a figure may be from the snapshot's: another compiler.
const SLACK: f64 = 0.1;

/// Memories of the chip, as its reference manual RM0433 has them.
const FLASH: Range<u32> = 0x0800_0000..0x0820_0000;
/// DTCM without the stack at its bottom; DMA does not reach it.
const VARIABLES: Range<u32> = 0x2000_8000..0x2002_0000;
/// The SRAM on the AXI bus, which DMA reaches.
const AXI: Range<u32> = 0x2400_0000..0x2408_0000;

/// Two pictures of QVGA, two bytes a pixel.
const PICTURES: u32 = 2 * 320 * 240 * 2;

fn file(name: &str) -> io::Result<PathBuf> {
    let folder = env::var_os(PROGRAMS).map(PathBuf::from).ok_or_else(|| {
        io::Error::other(format!("{PROGRAMS} is not set: run `cargo verify --only firmware-stm32h743`"))
    })?;
    Ok(folder.join(name))
}

fn program(name: &str) -> io::Result<Vec<Segment>> {
    Program::new(&fs::read(file(name)?)?)?.segments()
}

/// The segments of a memory.
fn within(segments: &[Segment], memory: &Range<u32>) -> Vec<Segment> {
    segments.iter().copied().filter(|segment| memory.contains(&segment.address)).collect()
}

#[test]
fn pictures_alone_are_where_dma_reaches() -> io::Result<()> {
    for name in [CAMERA, STREAMED, LOGGING] {
        let segments: Vec<_> = program(name)?.into_iter().filter(|segment| segment.in_memory > 0).collect();
        let pictures = within(&segments, &AXI);
        let [Segment { address, in_file: 0, in_memory: PICTURES }] = pictures[..] else {
            panic!("{name}: no two pictures, or something beside them: {pictures:x?}")
        };
        assert_eq!(address % 32, 0, "{name}: they begin with a line of the cache");
        let elsewhere: Vec<_> = segments
            .iter()
            .filter(|segment| ![FLASH, VARIABLES, AXI].iter().any(|memory| memory.contains(&segment.address)))
            .collect();
        assert!(elsewhere.is_empty(), "{name}: in no memory, or in the stack's: {elsewhere:x?}");
    }
    Ok(())
}

#[test]
fn the_log_is_where_a_probe_finds_it_and_words_can_be_made_of_it() -> io::Result<()> {
    let logging = file(LOGGING)?;
    let bytes = fs::read(&logging)?;
    let buffers = Program::new(&bytes)?.address_of("_SEGGER_RTT")?;
    assert!(VARIABLES.contains(&buffers), "{buffers:x}: not in the memory that no cache holds");
    assert!(messages(&logging, &[])?.is_empty());
    // nothing of it is left in the camera without
    let silent = file(CAMERA)?;
    assert!(Program::new(&fs::read(&silent)?)?.address_of("_SEGGER_RTT").is_err());
    assert!(messages(&silent, &[]).is_err());
    Ok(())
}

#[test]
fn its_sizes_are_as_they_were() -> io::Result<()> {
    let segments = program(CAMERA)?;
    let sum = |memory| within(&segments, memory).iter().map(|segment| segment.in_memory).sum::<u32>();
    let figures: BTreeMap<&str, u32> = [
        ("camera-flash", segments.iter().map(|segment| segment.in_file).sum()),
        ("camera-variables", sum(&VARIABLES)),
        ("camera-pictures", sum(&AXI)),
    ]
    .into();
    let shown: String = figures.iter().map(|(name, value)| format!("{name:<24}{value:>8} bytes\n")).collect();
    if let Some(place) = env::var_os(SHOWN) {
        fs::write(place, &shown)?;
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../snapshots/stm32h743.txt");
    if blessing() {
        fs::write(&file, &shown)?;
    }
    let kept = fs::read_to_string(file)?;
    let was: BTreeMap<&str, u32> = kept
        .lines()
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            Some((words.next()?, words.next()?.parse().ok()?))
        })
        .collect();
    assert!(was.keys().eq(figures.keys()), "TETRAD_BLESS=1: {was:?}, {figures:?}");
    for (name, value) in &figures {
        let was = f64::from(was[name]);
        let is_near = (f64::from(*value) - was).abs() <= SLACK * was.max(1.0);
        assert!(is_near, "{name}: {value}, was {was}; if that is meant, TETRAD_BLESS=1");
    }
    Ok(())
}
