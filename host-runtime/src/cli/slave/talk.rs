//! What the operator reads while the arm is driven: a line when the state changes, one for everything
//! that begins to limit the arm, and one a second while it moves.

use crate::station::Cycle;
use std::time::{Duration, Instant};
use tetrad_core::arm::puma560::{ChangeKind, Configuration, Elbow, Shoulder, Wrist};
use tetrad_core::arm::teleop::State;

/// How often a line about a moving arm is written.
const LIVE: Duration = Duration::from_secs(1);

/// What has been away for so long is told anew when it comes again; what comes and goes faster is told
/// once.
const FORGOTTEN: Duration = Duration::from_secs(2);

/// What was said, and what it was that was said.
#[derive(Debug)]
pub(super) struct Talk {
    /// State and reason, as said last.
    standing: String,
    /// What limits, and when it was last met.
    limits: Vec<(String, Instant)>,
    live: Instant,
}

impl Talk {
    pub(super) fn new(now: Instant) -> Self {
        Self { standing: String::new(), limits: Vec::new(), live: now }
    }

    /// The lines to write after a cycle; `reason` is the port's own word on how it stands.
    pub(super) fn lines(&mut self, cycle: &Cycle, reason: Option<String>, now: Instant) -> Vec<String> {
        let mut lines = Vec::new();
        let standing = standing(cycle, reason);
        if standing != self.standing {
            self.standing.clone_from(&standing);
            match cycle.step.decision.status.state() {
                State::Stopped | State::Fault => tracing::warn!("arm {}", standing.replace("\n    ", "; ")),
                _ => tracing::info!("arm {}", standing.replace("\n    ", "; ")),
            }
            lines.push(standing);
        }
        lines.extend(change(cycle));
        self.limits.retain(|(_, met)| now.saturating_duration_since(*met) < FORGOTTEN);
        for limit in limits(cycle) {
            match self.limits.iter_mut().find(|(known, _)| *known == limit) {
                Some((_, met)) => *met = now,
                None => {
                    lines.push(format!("    {limit}"));
                    self.limits.push((limit, now));
                }
            }
        }
        let moving = cycle.step.decision.status.state() == State::Engaged;
        if moving && now.saturating_duration_since(self.live) >= LIVE {
            self.live = now;
            lines.extend(live(cycle));
        }
        lines
    }
}

/// State and reason, and the port's where the arm is stopped.
fn standing(cycle: &Cycle, reason: Option<String>) -> String {
    let step = &cycle.step;
    let mut parts = vec![step.decision.status.to_string()];
    if let Some(refusal) = step.refusal {
        parts.push(refusal.to_string());
    }
    if matches!(step.decision.status.state(), State::Stopped | State::Fault) {
        parts.push(reason.unwrap_or_else(|| cycle.reading.status.to_string()));
    }
    parts.join("\n    ")
}

/// Everything that keeps the arm from following as it was asked, while it follows; and what went wrong
/// at the port.
fn limits(cycle: &Cycle) -> Vec<String> {
    let step = &cycle.step;
    let mut limits: Vec<String> = step.decision.notes.iter().map(|note| note.to_string()).collect();
    let engaged = step.decision.status.state() == State::Engaged;
    if let Some(governed) = step.governed.filter(|_| engaged) {
        limits.extend(governed.limits.iter().map(|limit| limit.to_string()));
    }
    limits.extend(cycle.port_error.map(|error| error.to_string()));
    limits
}

/// The arm does not stand as it did: never without a word.
pub(in crate::cli) fn change(cycle: &Cycle) -> Option<String> {
    let change = cycle.step.governed?.change?;
    let (from, to) = (posture(change.from), posture(change.to));
    let how = match change.kind {
        ChangeKind::Passage => "went through a singularity",
        ChangeKind::Jump => "goes by its joints",
    };
    Some(format!("    the arm {how}: it stood {from}, now {to}"))
}

fn posture(stands: Configuration) -> String {
    let shoulder = match stands.shoulder {
        Shoulder::Right => "right",
        Shoulder::Left => "left",
    };
    let elbow = match stands.elbow {
        Elbow::Up => "up",
        Elbow::Down => "down",
    };
    let wrist = match stands.wrist {
        Wrist::NoFlip => "no-flip",
        Wrist::Flip => "flip",
    };
    format!("shoulder {shoulder}, elbow {elbow}, wrist {wrist}")
}

fn live(cycle: &Cycle) -> Option<String> {
    let governed = cycle.step.governed?;
    let x = governed.pose.translation * 1e3;
    let age_ms = cycle.step.decision.command_age_us.unwrap_or_default() / 1000;
    let share = governed.speed_share * 100.0;
    Some(format!(
        "tool x {:+7.1} y {:+7.1} z {:+7.1} mm  speed {share:3.0} %  command {age_ms} ms old",
        x.x, x.y, x.z
    ))
}
