//! The operator's last stage: what a step of the pipeline tells the slave.

use crate::pipeline::{HandStep, Step};
use tetrad_core::geometry::Pose;
use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::{BALLS, Observations};
use tetrad_core::wire::{MotionPacket, Packet, encode};

/// Makes the packets of one sender.
#[derive(Clone, Debug)]
pub struct MotionSender {
    session: u32,
    sequence: u32,
    buffer: Vec<u8>,
}

impl MotionSender {
    /// A sender of this session: a number chosen anew at each start, so that packets of an earlier
    /// run are not taken for this one's.
    #[must_use]
    pub fn new(session: u32) -> Self {
        Self { session, sequence: 0, buffer: vec![0; tetrad_core::wire::MAX_FRAME_LEN] }
    }

    /// The packet of a step whose pictures were taken at `capture_us`; `None` where no hand is solved
    /// for. `engaged`: whether the operator wants the arm to move.
    ///
    /// The pose is the filtered one where there is one: an arm shall not be shaken by the noise of a
    /// camera.
    pub fn packet(&mut self, step: &Step, capture_us: u64, engaged: bool) -> Option<MotionPacket> {
        let hand = step.hand.as_ref()?;
        let seen = step.cameras.iter().map(|camera| &camera.report.observations);
        Some(self.packet_of(hand, seen, capture_us, engaged))
    }

    /// The same of a hand alone, and of what each camera saw.
    pub fn packet_of<'a>(
        &mut self,
        hand: &HandStep,
        seen: impl ExactSizeIterator<Item = &'a Observations>,
        capture_us: u64,
        engaged: bool,
    ) -> MotionPacket {
        let HandStep { report, filtered, engagements, .. } = hand;
        let motion = report.motion.as_ref().ok();
        let pose = filtered.or(report.pose);
        let views = u8::try_from(seen.len()).unwrap_or(u8::MAX);
        let mut seen_in = [0u8; BALLS];
        for balls in seen {
            for (count, ball) in seen_in.iter_mut().zip(balls) {
                *count += u8::from(ball.state.is_measured());
            }
        }
        let packet = MotionPacket {
            session: self.session,
            sequence: self.sequence,
            capture_us,
            engaged,
            engagements: *engagements,
            // without a pose there is nothing that could be followed, whatever the state is called
            state: if pose.is_some() { report.state } else { PoseState::Lost },
            spans: motion.map_or(0, |motion| motion.spans),
            views,
            seen_in,
            residual_px: motion.map_or(0.0, |motion| motion.residual_px),
            increment: motion.map_or_else(Pose::identity, |motion| motion.increment()).into(),
            since_engage: pose.unwrap_or_else(Pose::identity).into(),
            covariance: report.covariance.map(Into::into),
        };
        self.sequence = self.sequence.wrapping_add(1);
        packet
    }

    /// The bytes of a packet as they go over a stream: COBS, CRC and a zero.
    ///
    /// # Errors
    /// [`tetrad_core::wire::EncodeError`] for numbers that may not be sent.
    pub fn frame(&mut self, packet: MotionPacket) -> Result<&[u8], tetrad_core::wire::EncodeError> {
        let length = encode(&Packet::Motion(packet), &mut self.buffer)?;
        Ok(self.buffer.get(..length).unwrap_or_default())
    }
}
