//! What happens when something cannot be gone on with: it is said where on the serial line, no packet
//! follows, the light turns red, and the watchdog resets the board when its time is over.

use core::fmt::{self, Write as _};
use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use embassy_stm32::pac;

/// How often it is looked whether the line takes a byte: several times as long as one takes at its rate.
/// When the line was not started yet, it takes none.
const PATIENCE: u32 = 100_000;

/// Pins of the light on port C.
const RED: usize = 0;
const GREEN: usize = 1;
const BLUE: usize = 2;

/// The serial line, whatever its driver was doing.
struct Line;

impl fmt::Write for Line {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().try_for_each(send)
    }
}

fn send(byte: u8) -> fmt::Result {
    let has_room = (0..PATIENCE).any(|_| pac::USART3.isr().read().txe());
    if !has_room {
        return Err(fmt::Error);
    }
    pac::USART3.tdr().write(|data| data.set_dr(byte.into()));
    Ok(())
}

/// Ends here. The text stands between two zero bytes: to a host it is one frame that is none, and a packet
/// that was on its way is cut.
fn stop(what: fmt::Arguments<'_>) -> ! {
    cortex_m::interrupt::disable();
    pac::DCMI.cr().modify(|control| control.set_capture(false));
    pac::GPIOC.bsrr().write(|pins| {
        pins.set_br(RED, true);
        pins.set_bs(GREEN, true);
        pins.set_bs(BLUE, true);
    });
    // when the line takes nothing, nobody can be told
    let _ = send(0).and_then(|()| Line.write_fmt(what)).and_then(|()| send(0));
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    stop(format_args!("{info}"))
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    stop(format_args!("fault at {:#010x}, called from {:#010x}", frame.pc(), frame.lr()))
}
