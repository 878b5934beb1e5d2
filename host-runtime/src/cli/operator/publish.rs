//! What the console is told of the run, some thirty times a second.

use super::cameras::Cameras;
use super::losses::Losses;
use super::pictures::Pictures;
use super::slave::SlaveLine;
use crate::console::Desk;
use crate::console::snapshot::{
    ArmView, DelayView, GoalView, HandView, Line, LinkView, RecordingView, SlaveView, Snapshot, is_engaged,
};
use crate::link::{Link, Peer, Received};
use crate::session::StationTape;
use crate::station::delays::Stage;
use crate::station::operator::OperatorStep;
use crate::station::{Asked, Operator, SlaveAnnouncement};
use std::collections::VecDeque;
use tetrad_core::wire::ArmStatePacket;

/// From one snapshot to the next at least, microseconds. They follow motions: of those at 45 a second and less each has
/// one, of faster ones every second or so.
const EVERY_US: u64 = 22_000;

/// What takes longer to look up (the link's counts) is looked up so often, microseconds. Percentiles take longest; of
/// them each snapshot has one stage looked up anew.
const SLOW_US: u64 = 500_000;

/// Lines that a page which is opened later still sees.
const LINES: usize = 50;

/// The arm's states further apart than this are a pause, microseconds.
const PAUSE_US: u64 = 1_000_000;

/// What a snapshot is made of.
pub(super) struct Scene<'a> {
    pub(super) station: &'a Operator,
    pub(super) cameras: &'a Cameras,
    pub(super) slave: &'a SlaveLine,
    pub(super) link: Option<&'a Link>,
    pub(super) pictures: &'a Pictures,
    pub(super) tape: Option<&'a StationTape>,
}

/// See the [module's text](self).
pub(super) struct Publisher {
    desk: Desk,
    told_us: Option<u64>,
    /// The arm stands otherwise than it was told: that waits for nothing.
    news: bool,
    slow_us: Option<u64>,
    sequence: u64,
    hand: Option<(HandView, u64)>,
    arm: Option<Received<ArmStatePacket>>,
    followed: Followed,
    slave: Option<SlaveView>,
    asked: Asked,
    delays: [Option<DelayView>; Stage::ALL.len()],
    /// The stage that is looked up next.
    next_stage: usize,
    links: Vec<LinkView>,
    losses: Losses,
    recording: Option<RecordingView>,
    lines: VecDeque<Line>,
    line: u64,
}

/// How long the arm followed the hand, of the time it was heard.
#[derive(Default)]
struct Followed {
    last: Option<(u64, bool)>,
    engaged_us: u64,
    all_us: u64,
}

impl Followed {
    fn hear(&mut self, packet: &ArmStatePacket) {
        let before = self.last.replace((packet.time_us, is_engaged(packet)));
        let Some((before_us, engaged)) = before else { return };
        let us = packet.time_us.saturating_sub(before_us);
        if us <= PAUSE_US {
            self.all_us += us;
            self.engaged_us += if engaged { us } else { 0 };
        }
    }

    fn share(&self) -> f64 {
        if self.all_us == 0 { 0.0 } else { self.engaged_us as f64 / self.all_us as f64 }
    }
}

impl Publisher {
    pub(super) fn new(desk: Desk) -> Self {
        Self {
            desk,
            told_us: None,
            news: false,
            slow_us: None,
            sequence: 0,
            hand: None,
            arm: None,
            followed: Followed::default(),
            slave: None,
            asked: Asked::default(),
            delays: [None; Stage::ALL.len()],
            next_stage: 0,
            links: Vec::new(),
            losses: Losses::default(),
            recording: None,
            lines: VecDeque::new(),
            line: 0,
        }
    }

    pub(super) fn hand(&mut self, step: &OperatorStep) {
        self.asked.sent(&step.motion);
        self.hand = Some((HandView::of(step, step.joined.t_us), step.joined.t_us));
    }

    pub(super) fn arm(&mut self, state: &Received<ArmStatePacket>) {
        self.followed.hear(&state.what);
        self.asked.heard(&state.what);
        let before = self.arm.replace(*state).map(|before| (before.what.state, before.what.reason));
        self.news |= before != Some((state.what.state, state.what.reason));
    }

    /// Whether there is something that a page should know at once.
    pub(super) const fn has_news(&self) -> bool {
        self.news
    }

    /// What the slave says of itself.
    pub(super) fn announced(&mut self, slave: &SlaveAnnouncement) {
        self.asked.announced(slave);
        self.slave = Some(SlaveView::of(slave));
    }

    /// Something the operator reads.
    pub(super) fn line(&mut self, text: &str) {
        self.line += 1;
        self.lines.push_back(Line { number: self.line, text: text.trim().to_owned() });
        if self.lines.len() > LINES {
            self.lines.pop_front();
        }
    }

    /// Tells the console, where it is time.
    pub(super) fn publish(&mut self, scene: &Scene<'_>, now_us: u64) {
        let due =
            |at_us: Option<u64>, every_us| at_us.is_none_or(|at_us| now_us.saturating_sub(at_us) >= every_us);
        if !std::mem::take(&mut self.news) && !due(self.told_us, EVERY_US) {
            return;
        }
        self.told_us = Some(now_us);
        if due(self.slow_us, SLOW_US) {
            self.slow_us = Some(now_us);
            self.links = links(scene, self.arm.as_ref(), now_us);
            self.losses.look(&mut self.links, now_us);
            self.recording = scene.tape.map(recording);
        }
        if let Some((stage, delay)) =
            Stage::ALL.get(self.next_stage).zip(self.delays.get_mut(self.next_stage))
        {
            *delay = DelayView::of(*stage, scene.station.delays(), now_us);
        }
        self.next_stage = (self.next_stage + 1) % Stage::ALL.len();
        let connected = scene.slave.is_connected();
        let arm =
            self.arm.as_ref().map(|state| ArmView::of(&state.what, state.received_us, connected, now_us));
        // what it followed last, nobody knows whether it still does
        let goal = self.asked.goal().filter(|_| arm.as_ref().is_some_and(|arm| !arm.silent));
        self.sequence += 1;
        self.desk.publish(Snapshot {
            sequence: self.sequence,
            time_us: now_us,
            hand: self
                .hand
                .as_ref()
                .map(|(hand, t_us)| HandView { age_us: now_us.saturating_sub(*t_us), ..hand.clone() }),
            cameras: scene.cameras.views(scene.station.pairing(), &self.desk, now_us),
            arm,
            engaged_share: self.followed.share(),
            slave: self.slave.clone(),
            goal: goal.as_ref().map(GoalView::of),
            links: self.links.clone(),
            delays: self.delays.iter().flatten().copied().collect(),
            pictures: scene.pictures.views(now_us),
            recording: self.recording.clone(),
            lines: self.lines.iter().cloned().collect(),
        });
    }
}

/// What is recorded, and how it stands.
fn recording(tape: &StationTape) -> RecordingView {
    RecordingView {
        file: tape.path().display().to_string(),
        left_out: tape.left_out(),
        failed: tape.has_failed(),
    }
}

/// The stations of the link, or the slave of this process.
fn links(scene: &Scene<'_>, arm: Option<&Received<ArmStatePacket>>, now_us: u64) -> Vec<LinkView> {
    let of_peer = |peer: Peer| LinkView::of(peer.name().as_str(), peer.is_connected(), &peer.stats(), now_us);
    let mut links: Vec<LinkView> = scene.link.into_iter().flat_map(Link::peers).map(of_peer).collect();
    if scene.slave.as_peer().is_none() {
        links.push(LinkView {
            name: "slave".to_owned(),
            connected: scene.slave.is_connected(),
            age_us: arm.map(|state| now_us.saturating_sub(state.received_us)),
            ..LinkView::default()
        });
    }
    links
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::wire::{ArmReason, ArmState};
    use tetrad_fixtures::packets;

    fn state(time_us: u64, state: ArmState) -> ArmStatePacket {
        ArmStatePacket { time_us, ..packets::arm_state(state, ArmReason::None) }
    }

    #[test]
    fn the_share_is_of_the_time_that_is_known() {
        let mut followed = Followed::default();
        assert_eq!(followed.share(), 0.0);
        followed.hear(&state(0, ArmState::Armed));
        followed.hear(&state(300_000, ArmState::Engaged));
        followed.hear(&state(400_000, ArmState::Hold));
        assert_eq!(followed.share(), 0.25);
        followed.hear(&state(9_000_000, ArmState::Hold));
        assert_eq!(followed.share(), 0.25, "what was not heard is neither");
    }
}
