//! Eq. 1 with any colours and any threshold.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::vision::colour::{Matcher, Primary, Reference};
use tetrad_core::vision::frame::Rgb;

tetrad_no_panic::program!({
    let colour = || black_box(Rgb::new(1, 2, 3));
    let reference = Reference {
        primary: black_box(Primary::Yellow),
        reference: colour(),
        typical: colour(),
        background: colour(),
    };
    if let Ok(matcher) = Matcher::new(&reference, black_box(128)) {
        black_box((matcher.accepts(colour()), matcher.matching(colour())));
    }
    black_box(Matcher::with_threshold(black_box(Primary::Red), colour(), black_box(-7)).accepts(colour()));
});
