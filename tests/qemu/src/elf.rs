//! A 32-bit program's ELF file: how much of a board's memory it takes, and where its code lies.

use std::io;
use std::ops::Range;

/// Where both boards' data memory starts; what is below is kept in flash.
const RAM: u32 = 0x2000_0000;

/// Kinds of segments, sections and their flags: is loaded, the table of symbols, holds code.
const LOADED: u32 = 1;
const SYMBOLS: u32 = 2;
const EXECUTABLE: u32 = 4;

/// Bytes of a symbol.
const SYMBOL: usize = 16;

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

/// The file's bytes, lowest byte of a number first.
#[derive(Clone, Copy, Debug)]
pub struct Program<'a>(&'a [u8]);

/// What is read of a section's header.
#[derive(Clone, Copy, Debug)]
struct Section {
    kind: u32,
    flags: u32,
    address: u32,
    at: usize,
    size: usize,
    link: usize,
}

impl<'a> Program<'a> {
    /// A program in a file's bytes.
    ///
    /// # Errors
    /// They are no such program.
    pub fn new(bytes: &'a [u8]) -> io::Result<Self> {
        if bytes.get(..6) != Some(b"\x7fELF\x01\x01") {
            return Err(io::Error::other("no 32-bit ELF program"));
        }
        Ok(Self(bytes))
    }

    /// How much memory it takes.
    ///
    /// # Errors
    /// The file ends too early.
    pub fn sizes(self) -> io::Result<Sizes> {
        let mut sizes = Sizes::default();
        for segment in self.segments()? {
            sizes.flash += segment.in_file;
            sizes.ram += if segment.address >= RAM { segment.in_memory } else { 0 };
        }
        Ok(sizes)
    }

    /// What is loaded of it, and where to.
    ///
    /// # Errors
    /// The file ends too early.
    pub fn segments(self) -> io::Result<Vec<Segment>> {
        let mut segments = Vec::new();
        for at in self.headers(28, 42)? {
            let (address, in_file, in_memory) =
                (self.word(at + 8)?, self.word(at + 16)?, self.word(at + 20)?);
            if self.word(at)? == LOADED {
                segments.push(Segment { address, in_file, in_memory });
            }
        }
        Ok(segments)
    }

    /// Where in the file there is Thumb code, told apart from the constants between by the symbols that the
    /// compiler sets for that: `$t` where code begins, `$d` where data do.
    ///
    /// # Errors
    /// The file ends too early, or it has code without such symbols.
    pub fn code(self) -> io::Result<Vec<Range<usize>>> {
        let sections = self.sections()?;
        let mut code = Vec::new();
        for (index, section) in sections.iter().enumerate() {
            if section.flags & EXECUTABLE == 0 || section.size == 0 {
                continue;
            }
            let mut marks = self.marks(&sections, index)?;
            marks.sort_unstable();
            let offset = |address: u32| section.at + address.saturating_sub(section.address) as usize;
            let ends = marks.iter().skip(1).map(|(address, _)| offset(*address));
            let ends = ends.chain([section.at + section.size]);
            let mut found = marks.iter().zip(ends).peekable();
            // what is before the first mark would be looked at by nobody
            if found.peek().is_none_or(|((first, _), _)| *first != section.address) {
                return Err(io::Error::other("a section of code does not begin with a mapping symbol"));
            }
            code.extend(found.filter(|((_, is_code), _)| *is_code).map(|((at, _), end)| offset(*at)..end));
        }
        Ok(code)
    }

    /// Where a variable or function of a name is.
    ///
    /// # Errors
    /// There is none, or the file ends too early.
    pub fn address_of(self, name: &str) -> io::Result<u32> {
        for (at, names) in self.symbols(&self.sections()?)? {
            let found = self.0.get(names + self.word(at)? as usize..).ok_or_else(broken)?;
            if found.strip_prefix(name.as_bytes()).is_some_and(|rest| rest.first() == Some(&0)) {
                return self.word(at + 4);
            }
        }
        Err(io::Error::other(format!("it has no {name}")))
    }

    /// The addresses in a section where code (true) or data begin.
    fn marks(self, sections: &[Section], index: usize) -> io::Result<Vec<(u32, bool)>> {
        let mut marks = Vec::new();
        for (at, names) in self.symbols(sections)? {
            let name = names + self.word(at)? as usize;
            let is_code = match self.0.get(name..name + 2).ok_or_else(broken)? {
                b"$t" => true,
                b"$d" => false,
                _ => continue,
            };
            if usize::from(self.half(at + 14)?) == index {
                marks.push((self.word(at + 4)?, is_code));
            }
        }
        Ok(marks)
    }

    /// Where each symbol is, and where the names are that it has one of.
    fn symbols(self, sections: &[Section]) -> io::Result<Vec<(usize, usize)>> {
        let mut symbols = Vec::new();
        for table in sections.iter().filter(|section| section.kind == SYMBOLS) {
            let names = sections.get(table.link).ok_or_else(broken)?.at;
            let places = (table.at..table.at + table.size).step_by(SYMBOL);
            symbols.extend(places.map(|at| (at, names)));
        }
        Ok(symbols)
    }

    fn sections(self) -> io::Result<Vec<Section>> {
        let section = |at| {
            let number = |offset| self.word(at + offset).map(|number| number as usize);
            let (kind, flags, address) = (self.word(at + 4)?, self.word(at + 8)?, self.word(at + 12)?);
            Ok(Section { kind, flags, address, at: number(16)?, size: number(20)?, link: number(24)? })
        };
        self.headers(32, 46)?.map(section).collect()
    }

    /// Where headers are, of segments or sections: where the first is stands at one place; the size of each and
    /// how many there are at another.
    fn headers(self, first: usize, sizes: usize) -> io::Result<impl Iterator<Item = usize>> {
        let first = self.word(first)? as usize;
        let (size, count) = (usize::from(self.half(sizes)?), usize::from(self.half(sizes + 2)?));
        Ok((0..count).map(move |index| first + index * size))
    }

    fn word(self, at: usize) -> io::Result<u32> {
        let word = self.0.get(at..).and_then(|bytes| bytes.first_chunk());
        word.map(|word| u32::from_le_bytes(*word)).ok_or_else(broken)
    }

    fn half(self, at: usize) -> io::Result<u16> {
        let half = self.0.get(at..).and_then(|bytes| bytes.first_chunk());
        half.map(|half| u16::from_le_bytes(*half)).ok_or_else(broken)
    }
}

fn broken() -> io::Error {
    io::Error::other("the ELF file ends too early")
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

    /// A program of one section of 20 bytes of code at 0x100, with these symbols in it.
    fn with_symbols(symbols: &[(&str, u32)]) -> Vec<u8> {
        let mut bytes = program(&[]);
        bytes.resize(52 + 20, 0);
        let table = bytes.len() as u32;
        let mut names = vec![0];
        for (name, address) in symbols {
            let at = names.len() as u32;
            names.extend(name.bytes().chain([0]));
            // of the first section
            let words = [at, *address, 0, 1 << 16];
            words.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
        }
        let text = bytes.len() as u32;
        bytes.extend(&names);
        let headers = bytes.len() as u32;
        bytes[32..36].copy_from_slice(&headers.to_le_bytes());
        (bytes[46], bytes[48]) = (40, 4);
        let size = SYMBOL as u32 * symbols.len() as u32;
        for [kind, flags, address, at, size, link] in [
            [0; 6],
            [1, EXECUTABLE, 0x100, 52, 20, 0],
            [SYMBOLS, 0, 0, table, size, 3],
            [3, 0, 0, text, names.len() as u32, 0],
        ] {
            let header = [0, kind, flags, address, at, size, link, 0, 0, 0];
            header.iter().for_each(|word: &u32| bytes.extend(word.to_le_bytes()));
        }
        bytes
    }

    #[test]
    fn what_variables_start_as_is_in_both() -> io::Result<()> {
        let bytes = program(&[(0, 1000, 1000), (RAM, 20, 20), (RAM + 20, 0, 300)]);
        assert_eq!(Program::new(&bytes)?.sizes()?, Sizes { flash: 1020, ram: 320 });
        Ok(())
    }

    #[test]
    fn what_is_no_program_is_refused() {
        assert!(Program::new(b"not one").is_err());
        let cut = &program(&[(0, 1, 1)])[..60];
        assert!(Program::new(cut).is_ok_and(|program| program.sizes().is_err()));
    }

    #[test]
    fn code_ends_where_data_begin() -> io::Result<()> {
        let bytes = with_symbols(&[("$d.1", 0x10C), ("$t", 0x100), ("main", 0x104), ("$t.2", 0x110)]);
        assert_eq!(Program::new(&bytes)?.code()?, [52..52 + 12, 52 + 16..52 + 20]);
        Ok(())
    }

    #[test]
    fn code_that_nobody_would_look_at_is_refused() -> io::Result<()> {
        for symbols in [&[("main", 0x100)][..], &[("$t", 0x102)], &[]] {
            let bytes = with_symbols(symbols);
            assert!(Program::new(&bytes)?.code().is_err(), "{symbols:?}");
        }
        Ok(())
    }
}
