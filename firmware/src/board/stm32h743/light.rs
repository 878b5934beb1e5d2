//! The light: three colours, each lit by a low pin.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::{PC0, PC1, PC2};
use embassy_time::Instant;
use tetrad_core::observation::Ball;

/// While all is well it flashes once a second for so long, milliseconds.
const FLASH_MS: u64 = 40;

/// The light.
pub struct Light {
    red: Output<'static>,
    green: Output<'static>,
    blue: Output<'static>,
}

impl Light {
    pub(super) fn new(red: Peri<'static, PC0>, green: Peri<'static, PC1>, blue: Peri<'static, PC2>) -> Self {
        let dark = Level::High;
        Self {
            red: Output::new(red, dark, Speed::Low),
            green: Output::new(green, dark, Speed::Low),
            blue: Output::new(blue, dark, Speed::Low),
        }
    }

    /// The colour of a ball that is chosen; else a green flash a second while pictures are looked at, and
    /// magenta while none are.
    pub fn show(&mut self, ball: Option<Ball>, is_well: bool) {
        let flashes = Instant::now().as_millis() % 1000 < FLASH_MS;
        let (red, green, blue) = match (ball, is_well) {
            (Some(Ball::Red), _) => (true, false, false),
            (Some(Ball::Green), _) => (false, true, false),
            (Some(Ball::Blue), _) => (false, false, true),
            (Some(Ball::Yellow), _) => (true, true, false),
            (None, true) => (false, flashes, false),
            (None, false) => (true, false, true),
        };
        for (pin, is_lit) in [(&mut self.red, red), (&mut self.green, green), (&mut self.blue, blue)] {
            pin.set_level(if is_lit { Level::Low } else { Level::High });
        }
    }
}
