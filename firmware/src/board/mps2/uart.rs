//! The serial line: UART 0, an interrupt a byte, a ring each way.

use super::Register;
use core::cell::RefCell;
use core::convert::Infallible;
use core::future::poll_fn;
use core::task::Poll;
use critical_section::Mutex;
use embassy_sync::waitqueue::AtomicWaker;
use heapless::Deque;

const BASE: usize = 0x4000_4000;
const DATA: Register = Register(BASE);
const STATE: Register = Register(BASE + 4);
const CONTROL: Register = Register(BASE + 8);
const INTERRUPT: Register = Register(BASE + 12);
const DIVIDER: Register = Register(BASE + 16);

/// State bits.
const TRANSMIT_FULL: u32 = 1;
const RECEIVE_FULL: u32 = 1 << 1;
const RECEIVE_OVERRUN: u32 = 1 << 3;

/// Control bits: transmit, receive, and interrupts of both.
const ALL_ON: u32 = 0b1111;

/// Interrupt bits.
const TRANSMITTED: u32 = 1;
const RECEIVED: u32 = 1 << 1;

/// The least divider: the fastest line. QEMU minds it no further.
const FASTEST: u32 = 16;

const RING: usize = 1024;

struct Rings {
    received: Deque<u8, RING>,
    to_send: Deque<u8, RING>,
    /// Bytes were lost since the line was last read.
    overrun: bool,
}

static RINGS: Mutex<RefCell<Rings>> =
    Mutex::new(RefCell::new(Rings { received: Deque::new(), to_send: Deque::new(), overrun: false }));
static READER: AtomicWaker = AtomicWaker::new();
static WRITER: AtomicWaker = AtomicWaker::new();

fn with<T>(work: impl FnOnce(&mut Rings) -> T) -> T {
    critical_section::with(|token| work(&mut RINGS.borrow_ref_mut(token)))
}

pub(super) fn start() {
    DIVIDER.write(FASTEST);
    CONTROL.write(ALL_ON);
}

impl Rings {
    /// Sends what the line takes at once.
    fn transmit(&mut self) {
        while STATE.read() & TRANSMIT_FULL == 0
            && let Some(byte) = self.to_send.pop_front()
        {
            DATA.write(u32::from(byte));
        }
    }
}

#[unsafe(no_mangle)]
extern "C" fn UART0_TX() {
    INTERRUPT.write(TRANSMITTED);
    with(Rings::transmit);
    WRITER.wake();
}

#[unsafe(no_mangle)]
extern "C" fn UART0_RX() {
    INTERRUPT.write(RECEIVED);
    with(|rings| {
        while STATE.read() & RECEIVE_FULL != 0 {
            let byte = DATA.read() as u8;
            rings.overrun |= rings.received.push_back(byte).is_err();
        }
        if STATE.read() & RECEIVE_OVERRUN != 0 {
            STATE.write(RECEIVE_OVERRUN);
            rings.overrun = true;
        }
    });
    READER.wake();
}

/// The line's receiving half.
pub struct Receiver;

/// The line's sending half.
pub struct Sender;

/// Bytes came faster than they were taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrun;

impl core::fmt::Display for Overrun {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("bytes came faster than they were taken")
    }
}

impl core::error::Error for Overrun {}

impl embedded_io_async::Error for Overrun {
    fn kind(&self) -> embedded_io_async::ErrorKind {
        embedded_io_async::ErrorKind::Other
    }
}

impl embedded_io_async::ErrorType for Receiver {
    type Error = Overrun;
}

impl embedded_io_async::Read for Receiver {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Overrun> {
        poll_fn(|context| {
            READER.register(context.waker());
            with(|rings| {
                if core::mem::take(&mut rings.overrun) {
                    return Poll::Ready(Err(Overrun));
                }
                let mut count = 0;
                for slot in bytes.iter_mut() {
                    let Some(byte) = rings.received.pop_front() else { break };
                    *slot = byte;
                    count += 1;
                }
                if count > 0 || bytes.is_empty() { Poll::Ready(Ok(count)) } else { Poll::Pending }
            })
        })
        .await
    }
}

impl embedded_io_async::ErrorType for Sender {
    type Error = Infallible;
}

impl embedded_io_async::Write for Sender {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        poll_fn(|context| {
            WRITER.register(context.waker());
            with(|rings| {
                let taken = bytes.iter().take_while(|byte| rings.to_send.push_back(**byte).is_ok()).count();
                rings.transmit();
                if taken > 0 || bytes.is_empty() { Poll::Ready(Ok(taken)) } else { Poll::Pending }
            })
        })
        .await
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        poll_fn(|context| {
            WRITER.register(context.waker());
            let sent = with(|rings| rings.to_send.is_empty() && STATE.read() & TRANSMIT_FULL == 0);
            if sent { Poll::Ready(Ok(())) } else { Poll::Pending }
        })
        .await
    }
}
