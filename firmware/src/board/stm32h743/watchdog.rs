//! A reset when no picture was looked at for too long: the chip's independent watchdog.

use core::sync::atomic::{AtomicU32, Ordering};
use embassy_stm32::Peri;
use embassy_stm32::peripherals::IWDG1;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::Instant;

/// How long may pass from one picture that was looked at to the next, microseconds: a picture that is
/// searched everywhere takes 0.4 s and more (154 million instructions), a sensor that is set up anew takes two.
const LIMIT_US: u32 = 4_000_000;

/// Pictures count as looked at for so long, for the light.
const WELL_MS: u32 = 500;

/// When it was fed, milliseconds since the start, modulo 2^32.
static FED_MS: AtomicU32 = AtomicU32::new(0);

fn now_ms() -> u32 {
    Instant::now().as_millis() as u32
}

/// The watchdog before it runs.
pub struct Asleep(pub(super) Peri<'static, IWDG1>);

impl Asleep {
    /// It runs from now on, and cannot be stopped.
    #[must_use]
    pub fn wake(self) -> Watchdog {
        let mut watchdog = IndependentWatchdog::new(self.0, LIMIT_US);
        watchdog.unleash();
        Watchdog(watchdog)
    }
}

/// The watchdog.
pub struct Watchdog(IndependentWatchdog<'static, IWDG1>);

impl Watchdog {
    /// A picture was looked at.
    pub fn feed(&mut self) {
        self.0.pet();
        FED_MS.store(now_ms(), Ordering::Relaxed);
    }
}

/// Whether it was fed lately.
#[must_use]
pub fn is_well() -> bool {
    now_ms().wrapping_sub(FED_MS.load(Ordering::Relaxed)) < WELL_MS
}
