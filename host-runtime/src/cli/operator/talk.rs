//! What the operator reads: a line a second, and one for whatever changes or begins to limit the arm.

use crate::station::arm_words;
use crate::station::operator::OperatorStep;
use tetrad_core::wire::{ArmState, ArmStatePacket};

/// How often the live line is written, microseconds.
const LIVE_US: u64 = 1_000_000;

/// What has been away for so long is told anew when it comes again, microseconds.
const FORGOTTEN_US: u64 = 2_000_000;

/// A link that is silent for so long is told of, microseconds.
pub(super) const SILENT_US: u64 = 1_000_000;

/// What the slave is called in the live line.
pub(super) const SLAVE: &str = "slave";

/// What was said.
#[derive(Default)]
pub(super) struct Talk {
    standing: String,
    limits: Vec<(String, u64)>,
    live_us: u64,
    hand: String,
    arm: String,
}

impl Talk {
    /// The hand at an instant.
    pub(super) fn hand(&mut self, step: &OperatorStep) {
        let report = &step.hand.report;
        let pose = step.hand.filtered.or(report.pose);
        let place = pose.map_or_else(String::new, |pose| {
            let x = pose.translation * 1e3;
            format!(" {:+.1} {:+.1} {:+.1} mm", x.x, x.y, x.z)
        });
        self.hand = format!("hand {}{place}", report.state.name());
    }

    /// The lines that an arm's state is worth.
    pub(super) fn arm(&mut self, packet: &ArmStatePacket, now_us: u64) -> Vec<String> {
        let share = packet.speed_share * 100.0;
        let age =
            packet.command_age_us().map_or_else(String::new, |us| format!(", motion {} ms old", us / 1_000));
        self.arm = format!("arm {} {share:.0} %{age}", arm_words::state_name(packet.state));
        let mut lines = Vec::new();
        let standing = arm_words::standing(packet);
        if standing != self.standing {
            lines.push(format!("arm {standing}"));
            self.standing = standing;
        }
        self.limits.retain(|(_, met_us)| now_us.saturating_sub(*met_us) < FORGOTTEN_US);
        for limit in arm_words::limits(packet) {
            match self.limits.iter_mut().find(|(known, _)| *known == limit) {
                Some((_, met_us)) => *met_us = now_us,
                None => {
                    lines.push(format!("    {limit}"));
                    self.limits.push((limit, now_us));
                }
            }
        }
        lines
    }

    /// The live line, where its time has come; `links` are the stations with the times they were last
    /// heard, `rest` what else there is to tell.
    pub(super) fn live(
        &mut self,
        links: &[(&str, Option<u64>)],
        rest: Option<String>,
        now_us: u64,
    ) -> Option<String> {
        if now_us.saturating_sub(self.live_us) < LIVE_US {
            return None;
        }
        self.live_us = now_us;
        let mut parts =
            vec![if self.hand.is_empty() { "hand not seen yet".to_owned() } else { self.hand.clone() }];
        let slave = links.iter().rev().find_map(|(name, heard_us)| (*name == SLAVE).then_some(*heard_us));
        let silent = slave.flatten().is_some_and(|us| now_us.saturating_sub(us) > SILENT_US);
        parts.push(match (self.arm.is_empty(), silent) {
            (true, _) => "arm not heard yet".to_owned(),
            // what it said last is not how it stands
            (false, true) => "arm: NOBODY KNOWS, its slave is silent".to_owned(),
            (false, false) => self.arm.clone(),
        });
        let ages = links.iter().map(|(name, heard_us)| match heard_us.map(|us| now_us.saturating_sub(us)) {
            None => format!("{name} never"),
            Some(us) if us > SILENT_US => format!("{name} SILENT for {:.1} s", us as f64 * 1e-6),
            Some(us) => format!("{name} {} ms", us / 1_000),
        });
        parts.push(format!("heard {}", ages.collect::<Vec<_>>().join(", ")));
        parts.extend(rest);
        Some(parts.join(" | "))
    }
}

/// Logs what became of the arm, where that is another state or another reason.
pub(super) fn log_arm(before: Option<&ArmStatePacket>, now: &ArmStatePacket) {
    if before.is_some_and(|before| (before.state, before.reason) == (now.state, now.reason)) {
        return;
    }
    let (standing, slave_time_us) = (arm_words::standing(now), now.time_us);
    match now.state {
        ArmState::Stopped | ArmState::Fault => tracing::warn!(slave_time_us, "arm {standing}"),
        ArmState::Armed | ArmState::Engaged | ArmState::Hold => {
            tracing::info!(slave_time_us, "arm {standing}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::wire::ArmReason;
    use tetrad_fixtures::packets;

    #[test]
    fn a_silent_slave_is_not_said_to_stand_as_it_did() {
        let mut talk = Talk::default();
        talk.arm(&packets::arm_state(ArmState::Engaged, ArmReason::None), 1_000_000);
        let live = |talk: &mut Talk, now_us| talk.live(&[(SLAVE, Some(1_000_000))], None, now_us).unwrap();
        assert!(live(&mut talk, 1_500_000).contains("arm engaged 100 %"));
        let later = live(&mut talk, 2_500_000);
        assert!(!later.contains("engaged") && later.contains("slave SILENT for 1.5 s"), "{later}");
    }
}
