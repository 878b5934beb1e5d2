//! What a camera has seen, and how long it took.

use hdrhistogram::Histogram;
use tetrad_core::observation::{BALLS, Ball, ObservationState};
use tetrad_core::wire::ObservationPacket;

/// The longest time that is told apart, microseconds.
const LONGEST_US: u64 = 60_000_000;

/// Figures that are kept of a time.
const FIGURES: u8 = 3;

/// Since the camera was opened first.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraCounts {
    /// Pictures that were tracked.
    pub frames: u64,
    /// Pictures that were taken and not tracked, as far as their numbers tell.
    pub missed: u64,
    /// How often the camera was lost.
    pub lost: u64,
    /// How often each ball was visible, occluded, predicted and lost.
    pub balls: [[u64; 4]; BALLS],
    /// From the exposure until the picture was in memory, microseconds.
    pub ready_us: Histogram<u64>,
    /// From there until the balls were observed, microseconds.
    pub tracking_us: Histogram<u64>,
}

impl CameraCounts {
    pub(super) fn new() -> Self {
        Self {
            frames: 0,
            missed: 0,
            lost: 0,
            balls: [[0; 4]; BALLS],
            ready_us: histogram(),
            tracking_us: histogram(),
        }
    }

    pub(super) fn add(&mut self, packet: &ObservationPacket, missed: u64) {
        self.frames += 1;
        self.missed += missed;
        for (counts, ball) in self.balls.iter_mut().zip(&packet.balls) {
            if let Some(count) = counts.get_mut(ball.state as usize) {
                *count += 1;
            }
        }
        self.ready_us.saturating_record(packet.ready_us.into());
        self.tracking_us.saturating_record(packet.observed_us.saturating_sub(packet.ready_us).into());
    }

    /// A table for people, a line each.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let Self { frames, missed, lost, .. } = self;
        let mut lines =
            vec![format!("pictures        {frames} tracked, {missed} missed, camera lost {lost} times")];
        for (ball, counts) in Ball::ALL.into_iter().zip(&self.balls) {
            use ObservationState::{Lost, Occluded, Predicted, Visible};
            let states = [Visible, Occluded, Predicted, Lost].into_iter().zip(counts);
            let counts: Vec<_> = states.map(|(state, count)| format!("{} {count}", state.name())).collect();
            lines.push(format!("{:<15} {}", ball.name(), counts.join(", ")));
        }
        for (stage, times) in [("exposure->ready", &self.ready_us), ("tracking", &self.tracking_us)] {
            if !times.is_empty() {
                let at = |quantile| times.value_at_quantile(quantile);
                let (p50, p99, max) = (at(0.5), at(0.99), times.max());
                lines.push(format!("{stage:<15} p50 {p50} us, p99 {p99} us, max {max} us"));
            }
        }
        lines
    }
}

fn histogram() -> Histogram<u64> {
    // the bounds are constants that the crate takes
    Histogram::new_with_bounds(1, LONGEST_US, FIGURES)
        .unwrap_or_else(|_| unreachable!("1 to {LONGEST_US} with {FIGURES} figures"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::observation::Observation;
    use tetrad_fixtures::packets;

    #[test]
    fn states_and_times_are_counted() {
        let mut counts = CameraCounts::new();
        assert_eq!(counts.lines().len(), 1 + BALLS, "no times yet");
        let mut balls = [Observation::default(); BALLS];
        balls[1].state = ObservationState::Visible;
        for (ready_us, observed_us) in [(900, 1_000), (1_000, 1_300)] {
            let packet = ObservationPacket { ready_us, observed_us, balls, ..packets::observation(1, 2) };
            counts.add(&packet, 5);
        }
        let lines = counts.lines();
        let expected = [
            "pictures        2 tracked, 10 missed, camera lost 0 times",
            "red             visible 0, occluded 0, predicted 0, lost 2",
            "green           visible 2, occluded 0, predicted 0, lost 0",
        ];
        assert_eq!(lines[..3], expected);
        assert_eq!(lines[5], "exposure->ready p50 900 us, p99 1000 us, max 1000 us");
        assert_eq!(lines[6], "tracking        p50 100 us, p99 300 us, max 300 us");
    }
}
