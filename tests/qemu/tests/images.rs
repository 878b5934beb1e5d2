//! Promise: no program of the firmware multiplies and adds with one rounding, and a check for that sees one that
//! does.

use std::fs;
use std::io;
use tetrad_qemu::board::Build;
use tetrad_qemu::elf::Program;
use tetrad_qemu::fused;

/// `vfma.f32 s0, s1, s2`
const FUSED: [u8; 4] = [0xA0, 0xEE, 0x81, 0x0A];

/// Less than the smallest of them has: core without texts and tasks.
const LEAST_INSTRUCTIONS: usize = 10_000;

#[test]
fn no_program_rounds_a_product_and_a_sum_at_once() -> io::Result<()> {
    for build in Build::ALL {
        let programs = build.programs()?;
        assert!(programs.len() >= 4, "{build:?}: {programs:?}");
        for program in programs {
            let found = fused::look(&fs::read(&program)?)?;
            assert!(found.instructions > LEAST_INSTRUCTIONS, "{}: {found:?}", program.display());
            assert_eq!(found.fused, [0; 0], "{}: at these bytes of the file", program.display());
        }
    }
    Ok(())
}

#[test]
fn one_that_is_planted_is_seen() -> io::Result<()> {
    let mut bytes = fs::read(Build::CortexM7.program("mps2-camera")?)?;
    let code = Program::new(&bytes)?.code()?;
    // an instruction begins where code does
    let place = code.get(code.len() / 2).map(|code| code.start).ok_or(io::ErrorKind::NotFound)?;
    bytes[place..place + FUSED.len()].copy_from_slice(&FUSED);
    assert_eq!(fused::look(&bytes)?.fused, [place]);
    Ok(())
}
