//! What the experiments' scenes share.

use crate::report::ink::{BLUE, ORANGE};
use crate::settings::Mode;
use tetrad_fixtures::{Light, Scene};

/// Told apart on white and on black, and by those who see no red or no green: blue for `refined`,
/// orange for `paper`. What is printed in the paper, and truth, is grey.
pub(super) const fn colour(mode: Mode) -> &'static str {
    match mode {
        Mode::Paper => ORANGE,
        Mode::Refined => BLUE,
    }
}

/// The lights of the tables: a name, and the light.
pub(super) fn lights() -> [(&'static str, Light); 3] {
    [("even", Light::even()), ("side 70 %", Light::side(0.7)), ("side 45 %", Light::side(0.45))]
}

/// A scene of `tetrad-fixtures`.
///
/// # Panics
/// When there is no such scene: every name here is written down, and a run of all experiments is a test.
pub(super) fn named(name: &str) -> Scene {
    Scene::named(name).unwrap_or_else(|| panic!("tetrad-fixtures has no scene {name}"))
}
