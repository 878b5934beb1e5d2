//! The log: defmt's frames to UART 2, which `defmt-print` makes words of again.

use super::Register;
use core::cell::UnsafeCell;
use critical_section::RestoreState;
use defmt::Encoder;
use embassy_time::Instant;

const BASE: usize = 0x4000_6000;
const DATA: Register = Register(BASE);
const STATE: Register = Register(BASE + 4);
const CONTROL: Register = Register(BASE + 8);
const DIVIDER: Register = Register(BASE + 16);

/// State bit.
const TRANSMIT_FULL: u32 = 1;

/// Control bit.
const TRANSMIT: u32 = 1;

/// The least divider: the fastest line. QEMU minds it no further.
const FASTEST: u32 = 16;

defmt::timestamp!("{=u64:us}", Instant::now().as_micros());

#[defmt::global_logger]
struct Log;

/// The message that is being written, and how interrupts were before.
struct Message(UnsafeCell<(Encoder, RestoreState)>);

// SAFETY: only between `acquire` and `release` is it looked at, where no interrupt comes.
unsafe impl Sync for Message {}

static MESSAGE: Message = Message(UnsafeCell::new((Encoder::new(), RestoreState::invalid())));

pub(super) fn start() {
    DIVIDER.write(FASTEST);
    CONTROL.write(TRANSMIT);
}

/// Waits for the line: a log that leaves out would have to say so.
fn send(bytes: &[u8]) {
    for byte in bytes {
        while STATE.read() & TRANSMIT_FULL != 0 {}
        DATA.write(u32::from(*byte));
    }
}

// SAFETY: from `acquire` to `release` there are no interrupts, and the boards have one processor: nothing else
// logs. No message is made while another one is: what is logged are core's packets, whose words log nothing.
unsafe impl defmt::Logger for Log {
    fn acquire() {
        // SAFETY: `release` undoes it.
        let before = unsafe { critical_section::acquire() };
        // SAFETY: see above.
        let (encoder, restore) = unsafe { &mut *MESSAGE.0.get() };
        *restore = before;
        encoder.start_frame(send);
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: see above.
        let (encoder, restore) = unsafe { &mut *MESSAGE.0.get() };
        encoder.end_frame(send);
        // SAFETY: it is what `acquire` got.
        unsafe { critical_section::release(*restore) }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: see above.
        let (encoder, _) = unsafe { &mut *MESSAGE.0.get() };
        encoder.write(bytes, send);
    }
}
