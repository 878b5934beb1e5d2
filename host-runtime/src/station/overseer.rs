//! What goes on beside a slave's cycles, at the end of a link as in the operator's own process: its record,
//! the cameras of its scene, what there is to tell, and the end where the arm is lost.
//!
//! The cycles are [`serve`]'s. Here is what both kinds of slave do alike; what they do not (keys, the
//! link's events, who reads the lines) is the matter of whoever starts it.

use super::linked_slave::LinkedSlave;
use super::scene_camera::SceneCameras;
use super::serve::serve;
use super::slave::Cycle;
use crate::exit::{Exit, Failure};
use crate::link::Carrier;
use crate::output::ArmRecord;
use crate::robot::clock::Clock;
use std::sync::atomic::{AtomicBool, Ordering};
use tetrad_core::arm::port::{PortError, PortStatus};

/// How often what can wait is looked at, microseconds: cycles may be ten times as many.
const LOOK_US: u64 = 10_000;

/// How long an arm may not answer before the slave ends, so that whatever started it can start it anew;
/// the operator has then been told. Microseconds.
const LOST_US: u64 = 2_000_000;

/// What goes on beside a slave's cycles: its record, the cameras of its scene, what there is to tell, and
/// the end where its arm is lost.
pub struct Overseer {
    scene: SceneCameras,
    record: Option<ArmRecord>,
    clock: Clock,
    began_us: u64,
    looked_us: Option<u64>,
    lost_since_us: Option<u64>,
    lost: Option<String>,
}

/// Why a slave ended though nobody asked it to, or did not end as it should.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SlaveTrouble {
    /// Its controller did not answer for too long.
    #[error("the arm is lost ({0})")]
    Lost(String),
    /// Its port does not take the stop at the end.
    #[error("the arm could not be stopped at its port: {0}")]
    Unstopped(PortError),
}

/// What a slave's run came to.
#[derive(Debug)]
pub struct Overseen {
    /// What there is to tell of it, each line with what it is about.
    pub lines: Vec<(&'static str, String)>,
    /// What went wrong at the arm.
    pub trouble: Option<SlaveTrouble>,
}

impl Overseer {
    /// Of a slave that begins now; `record` gets every cycle.
    #[must_use]
    pub fn new(scene: SceneCameras, record: Option<ArmRecord>, clock: &Clock) -> Self {
        let began_us = clock.now_us();
        let clock = clock.clone();
        Self { scene, record, clock, began_us, looked_us: None, lost_since_us: None, lost: None }
    }

    /// Runs the slave until `end` is set, or its arm is lost. `each` sees every cycle and the lines that
    /// it is worth, and may stop the arm.
    pub fn serve<C: Carrier>(
        mut self,
        slave: &mut LinkedSlave<C>,
        cycle_us: u32,
        end: &AtomicBool,
        mut each: impl FnMut(&mut LinkedSlave<C>, &Cycle, Vec<String>),
    ) -> Overseen {
        let clock = self.clock.clone();
        let served = serve(slave, cycle_us, &clock, end, |slave, cycle| {
            let lines = self.look(slave, cycle);
            if self.lost.is_some() {
                end.store(true, Ordering::Relaxed);
            }
            each(slave, cycle, lines);
        });
        let mut lines: Vec<_> = slave.trail().line().map(|line| ("arm", line)).into_iter().collect();
        lines.push(("cycles", format!("of {cycle_us} us, {}", served.lateness)));
        if let Some((p50, p99)) = served.written.quantile_us(0.5).zip(served.written.quantile_us(0.99)) {
            lines.push(("motion", format!("at the port {p50} us (p50), {p99} us (p99) after it came")));
        }
        lines.extend(self.record.as_mut().and_then(ArmRecord::end).map(|line| ("record", line)));
        lines.extend(self.scene.end().map(|line| ("pictures", line)));
        // a controller that does not answer takes no stop either
        let trouble = self.lost.map(SlaveTrouble::Lost);
        Overseen { lines, trouble: trouble.or(served.unstopped.map(SlaveTrouble::Unstopped)) }
    }

    /// What is to be done after a cycle, and what there is to tell.
    fn look<C: Carrier>(&mut self, slave: &mut LinkedSlave<C>, cycle: &Cycle) -> Vec<String> {
        let now_us = self.clock.now_us();
        if let Some(reading) = &cycle.reading.joints {
            self.scene.arm_is_at(&reading.joints, now_us.saturating_sub(u64::from(reading.age_us)));
        }
        let mut lines = Vec::new();
        let t_s = now_us.saturating_sub(self.began_us) as f64 * 1e-6;
        if let Some(Err(error)) = self.record.as_mut().map(|record| record.write(t_s, cycle)) {
            // an arm that moves unrecorded is better than one that stops by surprise
            self.record = None;
            lines.push(format!("{:#}; the run goes on without", anyhow::Error::new(error)));
        }
        if self.looked_us.is_some_and(|looked_us| now_us.saturating_sub(looked_us) < LOOK_US) {
            return lines;
        }
        self.looked_us = Some(now_us);
        lines.extend(slave.take_refusal().map(|refusal| {
            let reason = slave.station().port().reason();
            let reason = reason.map_or_else(String::new, |reason| format!(" ({reason})"));
            format!("no reset: {refusal}{reason}")
        }));
        lines.extend(self.scene.take_notices());
        lines.extend(self.look_for_loss(slave, cycle.reading.status, now_us));
        lines
    }

    fn look_for_loss<C>(&mut self, slave: &LinkedSlave<C>, status: PortStatus, now_us: u64) -> Option<String>
    where
        C: Carrier,
    {
        if status != PortStatus::Lost {
            let was_lost = self.lost_since_us.take().is_some() && self.lost.is_none();
            return was_lost.then(|| "the arm answers again".to_owned());
        }
        let Some(since_us) = self.lost_since_us else {
            self.lost_since_us = Some(now_us);
            let seconds = LOST_US / 1_000_000;
            return Some(format!(
                "the arm does not answer: unless it does within {seconds} s, its slave ends"
            ));
        };
        if now_us.saturating_sub(since_us) >= LOST_US && self.lost.is_none() {
            let reason = slave.station().port().reason();
            self.lost = Some(reason.unwrap_or_else(|| status.to_string()));
        }
        None
    }
}

impl From<SlaveTrouble> for Failure {
    fn from(trouble: SlaveTrouble) -> Self {
        Self::new(Exit::DeviceLost, trouble)
            .help("look at the controller, its emergency stop and its cable; [slave] port says where it is")
    }
}

#[cfg(test)]
mod tests;
