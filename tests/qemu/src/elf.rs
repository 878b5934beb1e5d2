//! How much of a board's memory a program takes, read from its ELF file.

use std::io;
use std::path::Path;

/// Where both boards' data memory starts; what is below is kept in flash.
const RAM: u32 = 0x2000_0000;

/// Bytes of memory, without the stack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Code, constants, and what variables start as.
    pub flash: u32,
    /// Variables.
    pub ram: u32,
}

/// What is loaded as one, or made room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Where it is when the program runs.
    pub address: u32,
    /// Bytes that are kept in flash.
    pub in_file: u32,
    /// Bytes of memory.
    pub in_memory: u32,
}

/// The sizes of a 32-bit program, lowest byte first.
///
/// # Errors
/// The file cannot be read or is no such program.
pub fn sizes(program: &Path) -> io::Result<Sizes> {
    let mut sizes = Sizes::default();
    for segment in segments(program)? {
        sizes.flash += segment.in_file;
        sizes.ram += if segment.address >= RAM { segment.in_memory } else { 0 };
    }
    Ok(sizes)
}

/// What a 32-bit program consists of, lowest byte first.
///
/// # Errors
/// As [`sizes`].
pub fn segments(program: &Path) -> io::Result<Vec<Segment>> {
    let bytes = std::fs::read(program)?;
    let broken = || io::Error::other(format!("{}: no 32-bit ELF program", program.display()));
    let word = |at: usize| {
        let word = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    };
    let half = |at: usize| Some(u16::from_le_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]));
    if bytes.get(..6) != Some(b"\x7fELF\x01\x01") {
        return Err(broken());
    }
    let headers = || Some((word(28)? as usize, usize::from(half(42)?), usize::from(half(44)?)));
    let (first, size, count) = headers().ok_or_else(broken)?;
    let mut segments = Vec::new();
    for at in (0..count).map(|index| first + index * size) {
        let header = || Some((word(at)?, word(at + 8)?, word(at + 16)?, word(at + 20)?));
        let (kind, address, in_file, in_memory) = header().ok_or_else(broken)?;
        // 1: is loaded
        if kind == 1 {
            segments.push(Segment { address, in_file, in_memory });
        }
    }
    Ok(segments)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A program of one header a segment: address, bytes in the file, bytes in memory.
    fn program(segments: &[(u32, u32, u32)]) -> Vec<u8> {
        let mut bytes = b"\x7fELF\x01\x01".to_vec();
        bytes.resize(52, 0);
        bytes[28] = 52;
        (bytes[42], bytes[44]) = (32, segments.len() as u8);
        for (address, in_file, in_memory) in segments {
            for word in [1, 0, *address, *address, *in_file, *in_memory, 0, 0] {
                bytes.extend(word.to_le_bytes());
            }
        }
        bytes
    }

    #[test]
    fn what_variables_start_as_is_in_both() -> io::Result<()> {
        let file = tempfile::NamedTempFile::new()?;
        std::fs::write(file.path(), program(&[(0, 1000, 1000), (RAM, 20, 20), (RAM + 20, 0, 300)]))?;
        assert_eq!(sizes(file.path())?, Sizes { flash: 1020, ram: 320 });
        Ok(())
    }

    #[test]
    fn what_is_no_program_is_refused() -> io::Result<()> {
        let file = tempfile::NamedTempFile::new()?;
        for bytes in [&b"not one"[..], &program(&[(0, 1, 1)])[..60]] {
            std::fs::write(file.path(), bytes)?;
            assert!(sizes(file.path()).is_err());
        }
        Ok(())
    }
}
