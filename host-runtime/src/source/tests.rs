//! Folders, films and SRC itself, good and bad. Every file is written by the test that reads it.

mod film;
mod folder;
mod scene;
mod spec;

use super::{Frame, Options, Source, SourceError, open};
use crate::exit::Exit;
use std::path::Path;
use tetrad_core::vision::frame::Rgb;

/// What a frame was, without its pixels.
#[derive(Debug, PartialEq)]
struct Seen {
    number: u64,
    t_s: f64,
    /// The colour of the pixel in the top left corner.
    corner: Rgb,
}

impl Seen {
    fn of(frame: &Frame<'_>) -> Self {
        Self { number: frame.number, t_s: frame.t_s, corner: frame.view.pixel(0, 0).unwrap() }
    }
}

fn open_path(path: &Path) -> Result<Box<dyn Source>, SourceError> {
    open(path.to_str().unwrap(), &Options::default())
}

/// Everything up to the end or the first error.
fn read_all(source: &mut dyn Source) -> (Vec<Seen>, Option<SourceError>) {
    let mut seen = Vec::new();
    loop {
        match source.next() {
            Ok(Some(frame)) => {
                assert_eq!(frame.index, seen.len() as u64);
                seen.push(Seen::of(&frame));
            }
            Ok(None) => return (seen, None),
            Err(error) => {
                assert!(matches!(source.next(), Ok(None)), "a recording ends with its first error");
                return (seen, Some(error));
            }
        }
    }
}

/// The error of a source that must not open.
fn refusal(opened: Result<Box<dyn Source>, SourceError>) -> SourceError {
    match opened {
        Ok(source) => panic!("{} was opened", source.info().name),
        Err(error) => error,
    }
}

/// Asserts the exit code of an error and that its message has each of these words.
#[track_caller]
fn assert_says(error: &SourceError, exit: Exit, words: &[&str]) {
    let message = error.to_string();
    assert_eq!(error.exit(), exit, "{message}");
    for word in words {
        assert!(message.contains(word), "'{word}' is not in: {message}");
    }
}
