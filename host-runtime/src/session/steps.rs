//! What `tetrad record` writes of each step of its pipeline.

use super::convert;
use super::picture;
use super::schema::tetrad as msg;
use super::tape::Feed;
use super::topic::Topic;
use crate::pipeline::Step;
use crate::source::{Frame, Gap};
use prost::Message;

/// The frame that the hand is told in: its own of the first complete picture.
pub(super) const HAND_START: &str = "hand_start";
/// The frame of the hand.
pub(super) const HAND: &str = "hand";

/// Writes steps. There is nothing that a wait would delay but the pictures' source, and a camera that is
/// not asked in time leaves pictures out before they are tracked: nothing that was tracked is missing.
pub struct Steps {
    feed: Feed,
    names: Vec<String>,
}

impl Steps {
    /// Of these cameras.
    #[must_use]
    pub const fn new(feed: Feed, names: Vec<String>) -> Self {
        Self { feed, names }
    }

    /// Writes a step: the frames with their times in microseconds, in the cameras' order, and what came of
    /// them. Whether it was taken, which it is not once writing has failed.
    pub fn step(&self, frames: &[(Frame<'_>, u64)], step: &Step) -> bool {
        let mut taken = true;
        for (at, ((frame, t_us), name)) in frames.iter().zip(&self.names).enumerate() {
            let stamp = self.feed.timestamp(*t_us);
            let fill = |bytes: &mut Vec<u8>| picture::encode(&frame.view, name, stamp, bytes);
            taken &= self.feed.put(Topic::Image(at), *t_us, frame.number as u32, fill);
        }
        for (at, ((frame, t_us), camera)) in frames.iter().zip(&step.cameras).enumerate() {
            let report = &camera.report;
            let missed = if let Gap::Missed(missed) = frame.gap { missed } else { 0 };
            let seen = msg::Observations {
                // as the picture's sequence is
                frame: u64::from(frame.number as u32),
                capture_us: *t_us,
                missed,
                pixels_tested: report.tested,
                balls: convert::balls(&report.observations),
                width: u32::from(frame.view.width()),
                height: u32::from(frame.view.height()),
                ..msg::Observations::default()
            };
            taken &= self.put(Topic::Observations(at), *t_us, frame.number, &seen);
            let drawn = convert::annotations(self.feed.timestamp(*t_us), &report.observations);
            taken &= self.put(Topic::Annotations(at), *t_us, frame.number, &drawn);
        }
        if let (Some(hand), Some((frame, t_us))) = (&step.hand, frames.first()) {
            let message = convert::hand(u64::from(frame.number as u32), *t_us, hand);
            taken &= self.put(Topic::Hand, *t_us, frame.number, &message);
            let stamp = self.feed.timestamp(*t_us);
            if let Some(pose) = &hand.report.pose {
                let told = convert::pose_in_frame(stamp, HAND_START, pose);
                taken &= self.put(Topic::Pose, *t_us, frame.number, &told);
            }
            if let Some(pose) = &hand.filtered {
                let told = convert::pose_in_frame(stamp, HAND_START, pose);
                taken &= self.put(Topic::Filtered, *t_us, frame.number, &told);
                let tree = convert::frame_transform(stamp, [HAND_START, HAND], pose);
                taken &= self.put(Topic::Transforms, *t_us, frame.number, &tree);
            }
        }
        taken
    }

    fn put(&self, topic: Topic, t_us: u64, number: u64, message: &impl Message) -> bool {
        let fill = |bytes: &mut Vec<u8>| bytes.extend_from_slice(&message.encode_to_vec());
        self.feed.put(topic, t_us, number as u32, fill)
    }
}
