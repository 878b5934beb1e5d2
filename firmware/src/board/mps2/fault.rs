//! What happens when something cannot be gone on with: it is said where, and QEMU ends.

use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use semihosting::{eprintln, process};

/// QEMU's exit code after a panic.
const PANICKED: i32 = 101;

/// After a fault of the processor.
const FAULTED: i32 = 102;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    eprintln!("{info}");
    process::exit(PANICKED)
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    eprintln!("fault at {:#010x}, called from {:#010x}", frame.pc(), frame.lr());
    process::exit(FAULTED)
}
