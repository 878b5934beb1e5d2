//! embassy's clock: CMSDK timer 0 runs freely, timer 1 is the alarm.

use super::{CLOCK_HZ, Register};
use core::cell::RefCell;
use core::task::Waker;
use critical_section::Mutex;
use embassy_time_driver::{Driver, time_driver_impl};
use embassy_time_queue_utils::Queue;

const TICKS_PER_US: u64 = CLOCK_HZ as u64 / 1_000_000;

/// Timers count down from the reload value, and tell when they reach zero.
struct Timer {
    control: Register,
    value: Register,
    reload: Register,
    interrupt: Register,
}

const fn timer(base: usize) -> Timer {
    Timer {
        control: Register(base),
        value: Register(base + 4),
        reload: Register(base + 8),
        interrupt: Register(base + 12),
    }
}

const CLOCK: Timer = timer(0x4000_0000);
const ALARM: Timer = timer(0x4000_1000);

/// Control bits: counts; tells.
const RUN_AND_TELL: u32 = 1 | 1 << 3;

/// The longest the alarm can be set for.
const LONGEST_TICKS: u64 = u32::MAX as u64;

/// The shortest: what setting it takes must not be longer.
const SHORTEST_TICKS: u64 = 50;

struct State {
    /// How often the clock has passed zero.
    wraps: u64,
    queue: Queue,
}

struct Clock {
    state: Mutex<RefCell<State>>,
}

time_driver_impl!(static DRIVER: Clock = Clock {
    state: Mutex::new(RefCell::new(State { wraps: 0, queue: Queue::new() }))
});

impl Driver for Clock {
    fn now(&self) -> u64 {
        critical_section::with(|token| self.state.borrow_ref_mut(token).ticks() / TICKS_PER_US)
    }

    fn schedule_wake(&self, at_us: u64, waker: &Waker) {
        critical_section::with(|token| {
            let mut state = self.state.borrow_ref_mut(token);
            if state.queue.schedule_wake(at_us, waker) {
                state.set_alarm();
            }
        });
    }
}

impl State {
    fn ticks(&mut self) -> u64 {
        let mut value = CLOCK.value.read();
        if CLOCK.interrupt.read() != 0 {
            // it has passed zero and nobody has counted that yet
            CLOCK.interrupt.write(1);
            self.wraps += 1;
            value = CLOCK.value.read();
        }
        (self.wraps << 32) + u64::from(u32::MAX - value)
    }

    /// Wakes what is due, and sets the alarm for what is due next.
    fn set_alarm(&mut self) {
        let ticks = self.ticks();
        let next_us = self.queue.next_expiration(ticks / TICKS_PER_US);
        let after = next_us.saturating_mul(TICKS_PER_US).saturating_sub(ticks);
        ALARM.control.write(0);
        ALARM.interrupt.write(1);
        if next_us != u64::MAX {
            let after = after.clamp(SHORTEST_TICKS, LONGEST_TICKS) as u32;
            ALARM.reload.write(after);
            ALARM.value.write(after);
            ALARM.control.write(RUN_AND_TELL);
        }
    }
}

pub(super) fn start() {
    CLOCK.reload.write(u32::MAX);
    CLOCK.value.write(u32::MAX);
    CLOCK.control.write(RUN_AND_TELL);
}

/// Ticks of the clock, modulo 2^32: what instructions are counted by, where one takes a known time.
#[must_use]
pub fn ticks() -> u32 {
    u32::MAX - CLOCK.value.read()
}

#[unsafe(no_mangle)]
extern "C" fn TIMER0() {
    critical_section::with(|token| {
        DRIVER.state.borrow_ref_mut(token).ticks();
    });
}

#[unsafe(no_mangle)]
extern "C" fn TIMER1() {
    critical_section::with(|token| DRIVER.state.borrow_ref_mut(token).set_alarm());
}
