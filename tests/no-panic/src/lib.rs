//! What the programs of this package share: a panic handler that cannot be linked.
//!
//! Each program calls one part of core with values the compiler knows nothing about. When the whole
//! program is optimised in one piece and not one panic survives, the handler is dropped and the
//! program links. When one does, the linker wants [`a_panic_path_is_left`], which does not exist.
//! There is no allocator either: a program that could allocate does not link.
//!
//! They are built for the microcontroller and never run; `canary` shows that the check sees.
#![no_std]

use core::fmt::{self, Write};
use core::hint::black_box;
use core::panic::PanicInfo;

unsafe extern "C" {
    fn a_panic_path_is_left() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never linked, so never called.
    unsafe { a_panic_path_is_left() }
}

/// Where texts go: the panic of a formatter would be found too.
pub struct Nowhere;

impl Write for Nowhere {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        black_box(text);
        Ok(())
    }
}

/// The entry of a program that calls `$body`.
#[macro_export]
macro_rules! program {
    ($body:expr) => {
        /// The linker's entry point.
        #[unsafe(no_mangle)]
        pub extern "C" fn _start() -> ! {
            $body;
            loop {}
        }
    };
}
