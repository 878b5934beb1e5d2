//! Which interrupt is whose.

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;

unsafe extern "C" {
    fn UART0_RX();
    fn UART0_TX();
    fn TIMER0();
    fn TIMER1();
    fn DefaultHandler();
}

/// How many lines the boards have.
const LINES: usize = 32;

/// The handlers behind the core's own.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); LINES] = {
    let mut vectors = [DefaultHandler as unsafe extern "C" fn(); LINES];
    vectors[Line::Uart0Receive as usize] = UART0_RX;
    vectors[Line::Uart0Transmit as usize] = UART0_TX;
    vectors[Line::Timer0 as usize] = TIMER0;
    vectors[Line::Timer1 as usize] = TIMER1;
    vectors
};

#[derive(Clone, Copy)]
#[repr(u16)]
enum Line {
    Uart0Receive = 0,
    Uart0Transmit = 1,
    Timer0 = 8,
    Timer1 = 9,
}

// SAFETY: each number is that of a line of the boards, and stays so.
unsafe impl InterruptNumber for Line {
    fn number(self) -> u16 {
        self as u16
    }
}

/// Lets every line through that has a handler.
pub(super) fn enable() {
    for line in [Line::Uart0Receive, Line::Uart0Transmit, Line::Timer0, Line::Timer1] {
        // SAFETY: no code relies on a line being masked; what handlers share is behind critical sections.
        unsafe { NVIC::unmask(line) }
    }
}
