//! How long each stage takes from a picture to the arm and back: figure 9 of the paper, measured on every
//! packet.
//!
//! ```text
//! capture -> ready -> observed -> operator -> all cameras -> pose -> sent -> slave -> inverse -> port
//!    camera's clock               operator's clock                   slave's clock            -> settled
//! ```
//!
//! Within a station each stage is told by that station's clock. From one station to another it takes
//! both clocks and the measured offset between them, so it is as good as the offset; a delay that comes
//! out below zero counts as none. `sent -> heard of` and the way from a picture to the motion's
//! departure at a local camera need no offset.
//!
//! The operator remembers what it sent; the arm's state says which motion the slave used, and how long
//! after its arrival each stage was over.

mod lately;

use crate::link::Received;
use hdrhistogram::Histogram;
use lately::Lately;
use std::collections::VecDeque;
use std::fmt::Write as _;
use tetrad_core::wire::{ArmStatePacket, ObservationPacket};

#[cfg(test)]
mod tests;

/// The longest delay that is told apart from longer ones, microseconds: a minute.
const LONGEST_US: u64 = 60_000_000;

/// Delays are told to so many digits.
const DIGITS: u8 = 2;

/// Motions that are remembered until the arm's state tells of them: four seconds at 120 a second, far
/// longer than a link may be silent before the slave lets go.
const REMEMBERED: usize = 512;

/// A stage, from the end of the one before to its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Stage {
    /// From the capture until the whole picture is in the camera station's memory.
    Ready,
    /// Until the balls are found in it.
    Observed,
    /// Until the operator has the observations.
    Received,
    /// From there, for the picture that the instant is of, until all cameras' observations are there.
    Joined,
    /// Until the hand's pose is known.
    Posed,
    /// Until the motion is handed to the link.
    Sent,
    /// Until the slave has it.
    Arrived,
    /// Until the slave knows the joints to go to.
    Solved,
    /// Until they are written to the arm's port.
    Written,
    /// From its arrival at the slave until the measured joints are there.
    Settled,
    /// From when an arm's state was so until the operator has it.
    Back,
    /// From the later camera's picture in memory to the motion handed to the link.
    ReadyToSent,
    /// From there to the arm's port.
    SentToWritten,
    /// From the capture to the arm's port.
    CaptureToWritten,
    /// From the motion handed to the link until the operator has heard that it was used.
    HeardOf,
}

impl Stage {
    /// Every stage: first one after the other, then the totals.
    pub const ALL: [Self; 15] = [
        Self::Ready,
        Self::Observed,
        Self::Received,
        Self::Joined,
        Self::Posed,
        Self::Sent,
        Self::Arrived,
        Self::Solved,
        Self::Written,
        Self::Settled,
        Self::Back,
        Self::ReadyToSent,
        Self::SentToWritten,
        Self::CaptureToWritten,
        Self::HeardOf,
    ];

    /// From what to what, as it stands in tables and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ready => "capture to picture ready",
            Self::Observed => "ready to balls found",
            Self::Received => "found to operator",
            Self::Joined => "first camera to all",
            Self::Posed => "all to pose",
            Self::Sent => "pose to sent",
            Self::Arrived => "sent to slave",
            Self::Solved => "slave to inverse known",
            Self::Written => "inverse to port written",
            Self::Settled => "slave to arm settled",
            Self::Back => "arm state to operator",
            Self::ReadyToSent => "total ready to sent",
            Self::SentToWritten => "total sent to port written",
            Self::CaptureToWritten => "total capture to port written",
            Self::HeardOf => "total sent to heard of",
        }
    }
}

/// When a motion passed the operator's stages, its clock, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SentMotion {
    /// Its number.
    pub sequence: u32,
    /// The instant it is of.
    pub capture_us: u64,
    /// When the last picture that it took was whole in its camera's memory.
    pub ready_us: u64,
    /// When the observations of the instant's own picture were here.
    pub first_us: u64,
    /// When those of all cameras were.
    pub joined_us: u64,
    /// When the pose was known.
    pub posed_us: u64,
    /// When it was handed to the link.
    pub sent_us: u64,
}

/// What is known of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spread {
    /// How often it was measured.
    pub count: u64,
    /// The median, microseconds.
    pub p50_us: u64,
    /// All but one in a hundred are at most so long.
    pub p99_us: u64,
    /// The longest.
    pub max_us: u64,
}

impl Spread {
    fn of(histogram: &Histogram<u32>) -> Option<Self> {
        (!histogram.is_empty()).then(|| Self {
            count: histogram.len(),
            p50_us: histogram.value_at_quantile(0.5),
            p99_us: histogram.value_at_quantile(0.99),
            max_us: histogram.max(),
        })
    }
}

/// A histogram for each stage.
fn empty() -> Vec<Histogram<u32>> {
    // the bounds are constants, and a test makes them
    let one = Histogram::new_with_bounds(1, LONGEST_US, DIGITS).expect("bounds that there can be");
    vec![one; Stage::ALL.len()]
}

/// All stages, in memory that does not grow.
#[derive(Clone, Debug)]
pub struct Delays {
    session: u32,
    histograms: Vec<Histogram<u32>>,
    lately: Lately,
    sent: VecDeque<SentMotion>,
    /// The newest motion of which the slave has told.
    told: Option<u32>,
    settled: Option<u32>,
}

impl Delays {
    /// Of a sender of that session.
    #[must_use]
    pub fn new(session: u32) -> Self {
        let sent = VecDeque::with_capacity(REMEMBERED);
        Self { session, histograms: empty(), lately: Lately::new(), sent, told: None, settled: None }
    }

    /// Observations have come.
    pub fn observed(&mut self, observation: &Received<ObservationPacket>) {
        let ObservationPacket { ready_us, observed_us, .. } = observation.what;
        let now_us = observation.received_us;
        self.add(Stage::Ready, u64::from(ready_us), now_us);
        self.add(Stage::Observed, u64::from(observed_us.saturating_sub(ready_us)), now_us);
        if let Some(captured_us) = observation.captured_us {
            let found_us = captured_us.saturating_add(u64::from(observed_us));
            self.add(Stage::Received, now_us.saturating_sub(found_us), now_us);
        }
    }

    /// A motion has gone.
    pub fn sent(&mut self, motion: &SentMotion) {
        let SentMotion { ready_us, first_us, joined_us, posed_us, sent_us, .. } = *motion;
        for (stage, from_us, to_us) in [
            (Stage::Joined, first_us, joined_us),
            (Stage::Posed, joined_us, posed_us),
            (Stage::Sent, posed_us, sent_us),
            (Stage::ReadyToSent, ready_us, sent_us),
        ] {
            self.add(stage, to_us.saturating_sub(from_us), sent_us);
        }
        if self.sent.len() >= REMEMBERED {
            self.sent.pop_front();
        }
        self.sent.push_back(*motion);
    }

    /// The arm's state has come.
    pub fn arm_state(&mut self, state: &Received<ArmStatePacket>) {
        let (packet, now_us) = (&state.what, state.received_us);
        if let Some(captured_us) = state.captured_us {
            self.add(Stage::Back, now_us.saturating_sub(captured_us), now_us);
        }
        let Some(command) = packet.command.filter(|command| command.session == self.session) else { return };
        if self.told.replace(command.sequence) != Some(command.sequence) {
            let (solved_us, written_us) =
                (u64::from(command.solved_after_us), u64::from(command.written_after_us));
            self.add(Stage::Solved, solved_us, now_us);
            self.add(Stage::Written, written_us.saturating_sub(solved_us), now_us);
            if let Some(motion) = self.find(command.sequence) {
                self.add(Stage::HeardOf, now_us.saturating_sub(motion.sent_us), now_us);
                // how long ago it arrived is told by the slave's clock alone
                let ago_us = packet.time_us.saturating_sub(command.received_us);
                if let Some(arrived_us) = state.captured_us.and_then(|so_us| so_us.checked_sub(ago_us)) {
                    self.add(Stage::Arrived, arrived_us.saturating_sub(motion.sent_us), now_us);
                    let port_us = arrived_us + written_us;
                    self.add(Stage::SentToWritten, port_us.saturating_sub(motion.sent_us), now_us);
                    self.add(Stage::CaptureToWritten, port_us.saturating_sub(motion.capture_us), now_us);
                }
            }
        }
        if let Some(settled) = packet.settled
            && self.settled.replace(settled.sequence) != Some(settled.sequence)
        {
            self.add(Stage::Settled, u64::from(settled.after_us), now_us);
        }
    }

    /// What is known of a stage; `None` where it was never measured.
    #[must_use]
    pub fn of(&self, stage: Stage) -> Option<Spread> {
        Spread::of(self.histograms.get(stage as usize)?)
    }

    /// The same of about the last 10 s before `now_us`, the operator's clock.
    #[must_use]
    pub fn lately(&self, stage: Stage, now_us: u64) -> Option<Spread> {
        self.lately.of(stage, now_us)
    }

    /// A line for each stage that was measured, under a heading.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = format!("{:<32} {:>8} {:>9} {:>9} {:>9}", "delays, ms", "count", "p50", "p99", "max");
        for stage in Stage::ALL {
            let Some(Spread { count, p50_us, p99_us, max_us }) = self.of(stage) else { continue };
            let [p50, p99, max] = [p50_us, p99_us, max_us].map(|us| us as f64 / 1e3);
            // writing to a string does not fail
            let _ = write!(table, "\n{:<32} {count:>8} {p50:>9.3} {p99:>9.3} {max:>9.3}", stage.name());
        }
        table
    }

    fn find(&self, sequence: u32) -> Option<SentMotion> {
        let first = self.sent.front()?.sequence;
        let place = usize::try_from(sequence.wrapping_sub(first)).ok()?;
        // numbers without gaps; where there is one, nothing is found
        self.sent.get(place).copied().filter(|motion| motion.sequence == sequence)
    }

    fn add(&mut self, stage: Stage, us: u64, now_us: u64) {
        self.lately.add(stage, us, now_us);
        if let Some(histogram) = self.histograms.get_mut(stage as usize) {
            histogram.saturating_record(us);
        }
    }
}
