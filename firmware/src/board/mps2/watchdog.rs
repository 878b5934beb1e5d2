//! The run ends when no picture was looked at for too long: the CMSDK watchdog, from ARM DDI 0479. Its first
//! message is the interrupt that cannot be masked, so that a task that hangs cannot hold it up.

use super::{CLOCK_HZ, Register};
use cortex_m_rt::exception;
use semihosting::{eprintln, process};

/// How long may pass from one picture that was looked at to the next, seconds. Where an instruction counts
/// as 64 ns a search everywhere takes ten, and a picture of the tests more than twenty.
const LIMIT_S: u32 = 120;

/// QEMU's exit code when more has passed.
const NOT_FED: i32 = 103;

const LOAD: Register = Register(0x4000_8000);
const CONTROL: Register = Register(0x4000_8008);
const CLEAR: Register = Register(0x4000_800c);

/// Control bit: counts, and tells when it reaches zero.
const RUN_AND_TELL: u32 = 1;

/// The watchdog.
pub struct Watchdog(());

impl Watchdog {
    /// It runs from now on.
    #[must_use]
    pub fn start() -> Self {
        LOAD.write(LIMIT_S * CLOCK_HZ);
        CONTROL.write(RUN_AND_TELL);
        Self(())
    }

    /// It does not run.
    #[must_use]
    pub const fn idle() -> Self {
        Self(())
    }

    /// A picture was looked at: it begins to count anew.
    pub fn feed(&mut self) {
        CLEAR.write(1);
    }
}

#[exception]
unsafe fn NonMaskableInt() -> ! {
    eprintln!("watchdog: no picture was looked at for {LIMIT_S} s");
    process::exit(NOT_FED)
}
