//! What came of a run, and whether that is as it has to be.

use super::rig::{END_US, MOVES_US, RESTS_US, hand_m};
use tetrad::link::Received;
use tetrad::station::Cycle;
use tetrad_core::arm::slave::PortOrder;
use tetrad_core::arm::teleop::{Note, Order, State};
use tetrad_core::config::{JOINTS, SlaveConfig};
use tetrad_core::wire::MotionPacket;

/// After the last fresh command, by the slave's clock, the arm has begun its stop within this.
const STOP_US: u64 = 100_000;

/// The tool is steered to half a metre a second, and in the worst drive goes two fifths beyond.
const FASTEST_M_S: f64 = 0.7;

/// How far the tool may be sent from where the hand led it, once both are at rest, metres, and how far it
/// may be measured from there.
const SENT_OFF_M: f64 = 1e-4;
const MEASURED_OFF_M: f64 = 1e-3;

/// Rounding, as a share.
const SLACK: f64 = 1e-6;

/// The hand and the tool, where they were latched together.
#[derive(Clone, Copy, Debug)]
struct Latch {
    hand_m: [f32; 3],
    tool_m: [f64; 3],
}

pub(super) struct Outcome {
    config: SlaveConfig,
    /// Where the tool was sent in each cycle, metres; `None` before the arm was switched on.
    pub(super) tool_m: Vec<Option<[f64; 3]>>,
    measured_m: Option<[f64; 3]>,
    /// The last four set-points.
    way: Vec<[f64; JOINTS]>,
    latch: Option<Latch>,
    before: Option<State>,
    state: Option<State>,
    /// When the newest command came that the arm was moved by or could have been.
    fresh_us: u64,
    /// The longest from there to the first cycle in which it is not followed any more.
    pub(super) stop_us: u64,
    /// The longest from there to a cycle in which it still is.
    followed_us: u64,
    /// When the arm last moved.
    moved_us: u64,
    /// From the last fresh command to that.
    pub(super) rest_us: u64,
    /// How often the arm stopped following while the hand moved.
    pub(super) stops: usize,
    /// Cycles in which the hand was followed while it moved.
    pub(super) followed: usize,
    fastest_m_s: f64,
    /// The largest speed, acceleration and jerk of a joint, as shares of what the limits allow.
    shares: [f64; 3],
    /// Packets of a second sender that came as far as the law.
    pub(super) second_senders: u32,
}

impl Outcome {
    pub(super) fn new(config: &SlaveConfig) -> Self {
        Self {
            config: *config,
            tool_m: Vec::new(),
            measured_m: None,
            way: Vec::new(),
            latch: None,
            before: None,
            state: None,
            fresh_us: 0,
            stop_us: 0,
            followed_us: 0,
            moved_us: 0,
            rest_us: 0,
            stops: 0,
            followed: 0,
            fastest_m_s: 0.0,
            shares: [0.0; 3],
            second_senders: 0,
        }
    }

    /// Notes a cycle; `newest` is the newest motion that the carrier let through.
    pub(super) fn cycle(&mut self, cycle: &Cycle, newest: Option<Received<MotionPacket>>, now_us: u64) {
        let decision = &cycle.step.decision;
        let last_m = self.tool_m.last().copied().flatten();
        if let (Some(newest), Some(tool_m)) = (newest, last_m)
            && (decision.notes.contains(Note::Latched) || decision.notes.contains(Note::HandJumped))
        {
            self.latch = Some(Latch { hand_m: newest.what.since_engage.translation, tool_m });
        }
        self.fresh_us = newest.map_or(self.fresh_us, |newest| newest.received_us);
        let silent_us = now_us.saturating_sub(self.fresh_us);
        let follows = matches!(decision.order, Order::Follow(_));
        let moves = (MOVES_US..RESTS_US).contains(&now_us);
        self.before = self.state.replace(decision.status.state());
        if follows {
            self.followed_us = self.followed_us.max(silent_us);
            self.followed += usize::from(moves);
        } else if self.before == Some(State::Engaged) {
            self.stop_us = self.stop_us.max(silent_us);
            self.stops += usize::from(moves);
        }
        if cycle.step.governed.is_some_and(|governed| !governed.at_rest) {
            (self.moved_us, self.rest_us) = (now_us, silent_us);
        }
        self.measured_m = cycle.step.measured.map(|pose| pose.translation.into());
        let tool_m = cycle.step.governed.map(|governed| governed.pose.translation.into());
        self.tool_m.push(tool_m);
        let cycle_s = f64::from(self.config.governor.cycle_us) * 1e-6;
        if let (Some(from), Some(to)) = (last_m, tool_m) {
            self.fastest_m_s = self.fastest_m_s.max(apart_m(from, to) / cycle_s);
        }
        if let PortOrder::Write(joints) = cycle.step.order {
            self.joints(joints, cycle_s);
        }
    }

    /// Speed, acceleration and jerk of each joint by differences.
    fn joints(&mut self, joints: [f64; JOINTS], cycle_s: f64) {
        if self.way.is_empty() {
            // it stood there before
            self.way = vec![joints; 3];
        }
        self.way.push(joints);
        let limits = &self.config.governor;
        for joint in 0..JOINTS {
            let mut rates: Vec<f64> = self.way.iter().map(|joints| joints[joint]).collect();
            let most = [
                self.config.puma.joints[joint].max_speed_rad_s,
                limits.max_acceleration_rad_s2[joint],
                limits.max_jerk_rad_s3[joint],
            ];
            for (share, most) in self.shares.iter_mut().zip(most) {
                rates = rates.windows(2).map(|pair| (pair[1] - pair[0]) / cycle_s).collect();
                *share = rates.iter().fold(*share, |share, rate| share.max(rate.abs() / most));
            }
        }
        self.way.remove(0);
    }

    /// Whatever the network does: the arm stops in time and never jumps.
    pub(super) fn check(&self, what: &str) {
        assert!(self.followed > 0, "{what}: nothing was followed");
        self.check_bounds(what);
    }

    /// The same of an arm that may never have been moved.
    pub(super) fn check_bounds(&self, what: &str) {
        assert!(self.stop_us <= STOP_US, "{what}: the stop began after {} us", self.stop_us);
        assert!(self.followed_us <= STOP_US, "{what}: followed after {} us", self.followed_us);
        assert!(self.fastest_m_s <= FASTEST_M_S, "{what}: the tool at {} m/s", self.fastest_m_s);
        let within = self.shares.iter().all(|share| *share <= 1.0 + SLACK);
        assert!(within, "{what}: speed, acceleration, jerk of the limits' {:?}", self.shares);
    }

    /// How far the tool is in the end from where the hand led it, metres: sent, and measured. `None`
    /// where it is not followed.
    pub(super) fn off_m(&self) -> Option<(f64, f64)> {
        let latch = self.latch.filter(|_| self.state == Some(State::Engaged))?;
        let hand_m = hand_m(END_US);
        let commanded_m =
            [0, 1, 2].map(|axis| latch.tool_m[axis] + f64::from(hand_m[axis] - latch.hand_m[axis]));
        let sent_m = self.tool_m.last().copied().flatten()?;
        Some((apart_m(sent_m, commanded_m), apart_m(self.measured_m?, commanded_m)))
    }

    /// Where the link came back the arm is followed and is where the hand led it; how far off, metres.
    pub(super) fn check_end(&self, what: &str) -> f64 {
        let Some((sent_m, measured_m)) = self.off_m() else { panic!("{what}: it ends {:?}", self.state) };
        assert!(sent_m <= SENT_OFF_M, "{what}: sent {sent_m} m off");
        assert!(measured_m <= MEASURED_OFF_M, "{what}: measured {measured_m} m off");
        sent_m
    }

    /// Where the operator died the arm came to rest and stays there.
    pub(super) fn check_rest(&self, what: &str) {
        assert!(self.moved_us < RESTS_US, "{what}: it does not rest: {:?}", self.state);
        assert!(matches!(self.state, Some(State::Armed | State::Stopped)), "{what}: {:?}", self.state);
    }

    /// The largest distance from another run's tool at the same time, metres.
    pub(super) fn error_m(&self, reference: &Self) -> f64 {
        let pairs = self.tool_m.iter().zip(&reference.tool_m).filter_map(|(a, b)| a.zip(*b));
        pairs.map(|(a, b)| apart_m(a, b)).fold(0.0, f64::max)
    }
}

pub(super) fn apart_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
