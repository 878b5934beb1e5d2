//! Whether a program multiplies and adds with one rounding instead of two.
//!
//! Cortex-M4F and M7 can (VFMA, VFMS, VFNMA, VFNMS), x86-64 as it is built for here cannot: where a compiler
//! takes one of them for `a * b + c`, the bits are others. What does both with two roundings (VMLA and its
//! kin) is as good as two instructions. Encodings: ARMv7-M Architecture Reference Manual, A7.7.234 and 235.

use crate::elf::Program;
use std::io;
use std::ops::Range;

/// What was found in a program's code.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// How many instructions were looked at.
    pub instructions: usize,
    /// Where in the file those are that round once.
    pub fused: Vec<usize>,
}

/// Looks through all code of a program.
///
/// # Errors
/// The bytes are no program, or it cannot be told what of it is code.
pub fn look(bytes: &[u8]) -> io::Result<Found> {
    let mut found = Found::default();
    for code in Program::new(bytes)?.code()? {
        look_at(bytes, code, &mut found)?;
    }
    Ok(found)
}

fn look_at(bytes: &[u8], code: Range<usize>, found: &mut Found) -> io::Result<()> {
    let start = code.start;
    let code = bytes.get(code).ok_or_else(|| io::Error::other("code outside the file"))?;
    let mut halves = (start..).step_by(2).zip(code.as_chunks().0.iter().copied().map(u16::from_le_bytes));
    while let Some((at, first)) = halves.next() {
        found.instructions += 1;
        // one of these begins an instruction of two halves
        if matches!(first >> 11, 0b11101..=0b11111)
            && let Some((_, second)) = halves.next()
            && is_fused(first, second)
        {
            found.fused.push(at);
        }
    }
    Ok(())
}

/// `11101110 1D10nnnn dddd101s NoM0mmmm` is VFMA and VFMS, with `01` for `10` VFNMA and VFNMS.
const fn is_fused(first: u16, second: u16) -> bool {
    matches!(first & 0xFFB0, 0xEEA0 | 0xEE90) && second & 0x0E10 == 0x0A00
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As an assembler writes them.
    #[test]
    fn those_that_round_once_are_told_from_those_that_round_twice() {
        for (first, second, is, name) in [
            (0xEEA0, 0x0A81, true, "vfma.f32 s0, s1, s2"),
            (0xEEA0, 0x0AC1, true, "vfms.f32 s0, s1, s2"),
            (0xEE90, 0x0A81, true, "vfnms.f32 s0, s1, s2"),
            (0xEE90, 0x0AC1, true, "vfnma.f32 s0, s1, s2"),
            (0xEEEF, 0xFAAF, true, "vfma.f32 s31, s31, s31"),
            (0xEEA1, 0x0B02, true, "vfma.f64 d0, d1, d2"),
            (0xEE00, 0x0A81, false, "vmla.f32 s0, s1, s2"),
            (0xEE00, 0x0AC1, false, "vmls.f32 s0, s1, s2"),
            (0xEE10, 0x0A81, false, "vnmls.f32 s0, s1, s2"),
            (0xEE20, 0x0A81, false, "vmul.f32 s0, s1, s2"),
            (0xEE30, 0x0A81, false, "vadd.f32 s0, s1, s2"),
            (0xEE80, 0x0A81, false, "vdiv.f32 s0, s1, s2"),
            (0xEEB1, 0x0AC0, false, "vsqrt.f32 s0, s0"),
            (0xEEB0, 0x0A40, false, "vmov.f32 s0, s0"),
            (0xEEF7, 0x0A00, false, "vmov.f32 s1, #1"),
            (0xEEE1, 0x0A10, false, "vmsr fpscr, r0"),
        ] {
            assert_eq!(is_fused(first, second), is, "{name}");
        }
    }

    #[test]
    fn the_second_half_of_an_instruction_is_none_itself() -> io::Result<()> {
        // nop; ldr.w r0, [r0, #0xEA0]; adds r0, r0, r2 | vfma; nop
        let halves: [u16; 8] = [0xBF00, 0xF8D0, 0x0EA0, 0x1880, 0xEEA0, 0x0A81, 0xBF00, 0xBF00];
        let bytes: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
        let mut found = Found::default();
        look_at(&bytes, 0..16, &mut found)?;
        assert_eq!(found, Found { instructions: 6, fused: vec![8] });
        let mut shifted = Found::default();
        look_at(&bytes, 10..16, &mut shifted)?;
        assert_eq!(shifted.fused, [0; 0]);
        Ok(())
    }
}
