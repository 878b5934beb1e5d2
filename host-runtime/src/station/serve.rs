//! The loop of a slave at the end of a link, for a thread of its own.

use super::linked_slave::LinkedSlave;
use super::slave::Cycle;
use crate::link::Carrier;
use crate::precedence::{Duty, step_forward};
use crate::robot::clock::Clock;
use crate::robot::lateness::Lateness;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tetrad_core::arm::port::PortError;

/// How long the end waits for the arm to be at rest.
const REST: Duration = Duration::from_secs(3);

/// What the loop kept count of.
#[derive(Debug, Default)]
pub struct Served {
    /// How late each cycle began.
    pub lateness: Lateness,
    /// From a motion's coming to its set-point's writing.
    pub written: Lateness,
    /// Why the port could not be stopped in the end, if so.
    pub unstopped: Option<PortError>,
}

/// Runs a slave until `end` is set: every cycle by the port's own pace or the computer's clock. Then the
/// arm is brought to rest within its limits and its port is stopped.
///
/// `each` sees every cycle and may stop the arm; it runs after the port was told, and what it takes is
/// taken from the time to the next cycle.
pub fn serve<C: Carrier>(
    slave: &mut LinkedSlave<C>,
    cycle_us: u32,
    clock: &Clock,
    end: &AtomicBool,
    mut each: impl FnMut(&mut LinkedSlave<C>, &Cycle),
) -> Served {
    step_forward(Duty::Drive);
    let period = Duration::from_micros(u64::from(cycle_us));
    let mut served = Served::default();
    let mut due = Instant::now();
    let mut ends: Option<Instant> = None;
    loop {
        let began = Instant::now();
        if ends.is_none() && end.load(Ordering::Relaxed) {
            ends = Some(began + REST);
        }
        if ends.is_some() {
            // again and again: the operator's reset does not end this stop
            slave.end();
        }
        let before = slave.command();
        let cycle = slave.cycle(clock);
        if let Some(command) = slave.command().filter(|command| before != Some(*command)) {
            served.written.record(u64::from(command.written_after_us));
        }
        each(slave, &cycle);
        let at_rest = cycle.step.governed.is_none_or(|governed| governed.at_rest);
        if ends.is_some_and(|until| at_rest || Instant::now() >= until) {
            break;
        }
        let planned = due + period;
        // what was missed is not made up for
        due = planned.max(Instant::now());
        slave.pace(due);
        let now = Instant::now();
        served.lateness.record(micros(now.saturating_duration_since(planned)));
        // a port's own beat may be ahead of this clock
        due = due.min(now);
    }
    served.unstopped = slave.shut_down().err();
    served
}

fn micros(duration: Duration) -> u64 {
    u64::try_from(duration.as_micros()).unwrap_or(u64::MAX)
}
