//! The MPS2 boards of ARM as QEMU has them: AN386 with a Cortex-M4F, AN500 with a Cortex-M7. One program
//! runs on both. Facts from ARM's application notes DAI0386 and DAI0500 and QEMU 7.2, hw/arm/mps2.c.
//!
//! | job | file |
//! |---|---|
//! | which interrupt is whose | `interrupts` |
//! | tasks, and sleep between them | `executor` |
//! | embassy's clock on the two CMSDK timers | `time` |
//! | the serial line | `uart` |
//! | the log, with the feature `defmt` | `log` |
//! | recorded pictures and commands, read by semihosting | `tape` |
//! | what stands for the CAN bus | `bus` |
//! | what came to a slave, read by semihosting | `slave_tape` |
//! | what a piece of work costs | `cost` |
//! | the end of a run when no picture was looked at for too long | `watchdog` |
//! | what happens when something cannot be gone on with | `fault` |

pub mod bus;
pub mod cost;
pub mod executor;
mod fault;
mod interrupts;
#[cfg(feature = "defmt")]
mod log;
pub mod slave_tape;
pub mod tape;
pub mod time;
pub mod uart;
pub mod watchdog;

use core::ptr;

/// The clock of both boards and their timers, Hz.
pub const CLOCK_HZ: u32 = 25_000_000;

/// One 32-bit register of a peripheral.
#[derive(Clone, Copy)]
struct Register(usize);

impl Register {
    fn read(self) -> u32 {
        // SAFETY: only the constants of this board's files are made registers, and words of the stack: aligned
        // and always mapped; reading them changes nothing.
        unsafe { ptr::read_volatile(self.0 as *const u32) }
    }

    fn write(self, value: u32) {
        // SAFETY: as above; what is written of the stack is below all that is in use.
        unsafe { ptr::write_volatile(self.0 as *mut u32, value) }
    }
}

/// Starts the clock and the serial line and lets interrupts through. Once, before tasks are.
pub fn start() {
    time::start();
    uart::start();
    #[cfg(feature = "defmt")]
    log::start();
    interrupts::enable();
}

/// How many bytes of stack were ever used: those that were painted and are no longer so.
#[must_use]
pub fn stack_used() -> usize {
    let (end, start) = stack();
    used_above(end, start)
}

/// How many bytes of stack `work` needs beyond what is in use here.
pub fn stack_of(work: impl FnOnce()) -> usize {
    let here = cortex_m::register::msp::read() as usize;
    let (end, start) = stack();
    // what this function itself has below its stack pointer: nothing; a margin all the same
    let mut at = end.max(here.saturating_sub(PAINTED));
    while at < here - MARGIN {
        Register(at).write(cortex_m_rt::STACK_PAINT_VALUE);
        at += 4;
    }
    work();
    let lowest = start - used_above(here.saturating_sub(PAINTED).max(end), start);
    here.saturating_sub(lowest)
}

/// Bytes between the lowest word at or above `at` that lost its paint, and `start`.
fn used_above(mut at: usize, start: usize) -> usize {
    while at < start && Register(at).read() == cortex_m_rt::STACK_PAINT_VALUE {
        at += 4;
    }
    start - at
}

/// The most stack that is looked at for one piece of work, bytes.
const PAINTED: usize = 256 * 1024;

/// Bytes left alone just below the stack pointer.
const MARGIN: usize = 256;

/// Where the stack ends, and where it starts: it grows downwards.
fn stack() -> (usize, usize) {
    unsafe extern "C" {
        static _stack_start: u32;
        static _stack_end: u32;
    }
    (ptr::addr_of!(_stack_end) as usize, ptr::addr_of!(_stack_start) as usize)
}
