//! What the operator reads while the arm is driven: a line whenever something changes, and one a
//! second while it moves.

use crate::station::Cycle;
use std::time::{Duration, Instant};
use tetrad_core::arm::teleop::State;

/// How often a line about a moving arm is written.
const LIVE: Duration = Duration::from_secs(1);

/// The least time between two lines that tell the same things in turn.
const SETTLED: Duration = Duration::from_millis(300);

/// What was said last.
#[derive(Debug)]
pub(super) struct Talk {
    said: String,
    state: Option<State>,
    /// What is to be said once it has stood for a moment.
    pending: Option<(String, Instant)>,
    live: Instant,
}

impl Talk {
    pub(super) fn new(now: Instant) -> Self {
        Self { said: String::new(), state: None, pending: None, live: now }
    }

    /// The lines to write after a cycle; `reason` is the port's own word on how it stands.
    pub(super) fn lines(&mut self, cycle: &Cycle, reason: Option<String>, now: Instant) -> Vec<String> {
        let mut lines = Vec::new();
        let line = standing(cycle, reason);
        if line == self.said {
            self.pending = None;
        } else if self.pending.as_ref().is_none_or(|(pending, _)| *pending != line) {
            self.pending = Some((line, now));
        }
        // another state is told at once, what comes and goes in it once it stays
        let state = cycle.step.decision.status.state();
        let urgent = self.state.replace(state) != Some(state);
        if let Some((line, _)) = self.pending.take_if(|(_, since)| urgent || now - *since >= SETTLED) {
            self.said.clone_from(&line);
            lines.push(line);
        }
        let moving = state == State::Engaged;
        if moving && now - self.live >= LIVE {
            self.live = now;
            lines.extend(live(cycle));
        }
        lines
    }
}

/// State and reason, then everything that limits the following.
fn standing(cycle: &Cycle, reason: Option<String>) -> String {
    let step = &cycle.step;
    let mut parts = vec![step.decision.status.to_string()];
    parts.extend(step.decision.notes.iter().map(|note| note.to_string()));
    let state = step.decision.status.state();
    if let Some(governed) = step.governed.filter(|_| state == State::Engaged) {
        parts.extend(governed.limits.iter().map(|limit| limit.to_string()));
    }
    if let Some(refusal) = step.refusal {
        parts.push(refusal.to_string());
    }
    if matches!(state, State::Stopped | State::Fault) {
        parts.push(reason.unwrap_or_else(|| cycle.reading.status.to_string()));
    }
    if let Some(error) = cycle.port_error {
        parts.push(error.to_string());
    }
    parts.join("\n    ")
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
