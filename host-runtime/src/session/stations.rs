//! What `tetrad operator --record` writes: the pictures of the cameras that are here, and everything that
//! comes to the operator's loop, in the order in which it came.

use super::convert;
use super::error::SessionError;
use super::picture;
use super::schema::foxglove::Level;
use super::schema::tetrad as msg;
use super::steps::{HAND, HAND_START};
use super::tape::{Feed, Recorded, Tape};
use super::taught;
use super::topic::Topic;
use crate::link::Received;
use crate::station::arm_words;
use crate::station::camera::{Onlooker, Order, Windows};
use crate::station::delays::{Delays, Spread, Stage};
use crate::station::operator::{Buttons, OperatorStep, OperatorTurn};
use std::collections::BTreeMap;
use std::path::Path;
use tetrad_core::arm::governor::Limits;
use tetrad_core::geometry::Pose;
use tetrad_core::hand::affine::Arms;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::wire::{ArmStatePacket, ObservationPacket, PressFor};

/// The frame of the robot's base, and that of its tool.
const BASE: &str = "base";
const TOOL: &str = "tool_set_point";

/// How often the delays are written, microseconds.
const DELAYS_US: u64 = 1_000_000;

/// Where one camera's thread leaves its pictures, and what it was taught between them.
struct CameraTape {
    feed: Feed,
    camera: usize,
    name: String,
}

impl Onlooker for CameraTape {
    /// Keeps a picture, or leaves it out where the disk is behind.
    fn pictured(&mut self, view: &FrameView<'_>, packet: &ObservationPacket, _windows: &Windows) {
        let stamp = self.feed.timestamp(packet.capture_us);
        self.feed.offer(Topic::Image(self.camera), packet.capture_us, packet.sequence, |bytes| {
            picture::encode(view, &self.name, stamp, bytes);
        });
    }

    fn taught(&mut self, order: &Order, from: u32, now_us: u64) {
        let message = taught::message(order, from, now_us);
        self.feed.insist(Topic::Taught(self.camera), now_us, from, &message);
    }
}

/// The session of an operator.
pub struct StationTape {
    tape: Tape,
    names: Vec<String>,
    instants: u64,
    buttons: Option<Buttons>,
    delays_us: Option<u64>,
}

impl StationTape {
    /// Of these cameras, as the configuration names them.
    #[must_use]
    pub const fn new(tape: Tape, names: Vec<String>) -> Self {
        Self { tape, names, instants: 0, buttons: None, delays_us: None }
    }

    /// What looks on at a camera of this computer.
    #[must_use]
    pub fn onlooker(&self, camera: usize) -> Box<dyn Onlooker> {
        let name = self.names.get(camera).cloned().unwrap_or_default();
        Box::new(CameraTape { feed: self.tape.feed().clone(), camera, name })
    }

    /// What a camera saw has come; what was seen nobody knows when is no part of the session.
    pub fn observed(&self, camera: usize, observation: &Received<ObservationPacket>) {
        let Received { what, received_us, captured_us: Some(capture_us) } = *observation else { return };
        let feed = self.tape.feed();
        let seen = msg::Observations {
            frame: u64::from(what.sequence),
            capture_us,
            missed: 0,
            pixels_tested: what.pixels_tested,
            balls: convert::balls(&what.balls),
            width: what.width.into(),
            height: what.height.into(),
            ready_us: capture_us.saturating_add(u64::from(what.ready_us)),
            observed_us: capture_us.saturating_add(u64::from(what.observed_us)),
            received_us,
        };
        feed.message(Topic::Observations(camera), capture_us, what.sequence, &seen);
        let drawn = convert::annotations(feed.timestamp(capture_us), &what.balls);
        feed.message(Topic::Annotations(camera), capture_us, what.sequence, &drawn);
    }

    /// The hand was set up anew, with these arms: what comes of the next turn is of another hand.
    pub fn hand_begins(&self, arms: Arms, now_us: u64) {
        let arms_m = arms.lengths_m().to_vec();
        let message = msg::HandBegins { frame: self.instants, time_us: now_us, arms_m };
        self.tape.feed().insist(Topic::HandBegins, now_us, self.instants as u32, &message);
    }

    /// The buttons as they are at `now_us`; written where they changed.
    pub fn buttons(&mut self, buttons: Buttons, now_us: u64) {
        if self.buttons.replace(buttons) == Some(buttons) {
            return;
        }
        let Buttons { pressed, stop, resets, press_for, scale } = buttons;
        let (home, scale_percent) = (press_for == PressFor::Home, scale.percent().into());
        let message = msg::Buttons { time_us: now_us, pressed, stop, resets, home, scale_percent };
        self.tape.feed().message(Topic::Buttons, now_us, 0, &message);
    }

    /// What came of a turn of the loop.
    pub fn turn(&mut self, turn: &OperatorTurn) {
        if let Some(step) = &turn.step {
            self.step(step);
        }
        if let Some(state) = &turn.arm {
            self.arm(state);
        }
    }

    fn step(&mut self, step: &OperatorStep) {
        let feed = self.tape.feed();
        let (t_us, number) = (step.joined.t_us, self.instants);
        self.instants += 1;
        let sequence = number as u32;
        feed.message(Topic::Instant, t_us, sequence, &convert::instant(&step.joined, step.asked_us));
        feed.message(Topic::Hand, t_us, sequence, &convert::hand(number, t_us, &step.hand));
        feed.message(Topic::Command, t_us, sequence, &convert::command(&step.motion));
        let stamp = feed.timestamp(t_us);
        if let Some(pose) = &step.hand.report.pose {
            feed.message(Topic::Pose, t_us, sequence, &convert::pose_in_frame(stamp, HAND_START, pose));
        }
        if let Some(pose) = &step.hand.filtered {
            feed.message(Topic::Filtered, t_us, sequence, &convert::pose_in_frame(stamp, HAND_START, pose));
            let tree = convert::frame_transform(stamp, [HAND_START, HAND], pose);
            feed.message(Topic::Transforms, t_us, sequence, &tree);
        }
    }

    fn arm(&self, state: &Received<ArmStatePacket>) {
        let feed = self.tape.feed();
        let (packet, t_us) = (&state.what, state.received_us);
        let limits = Limits::from_bits(packet.limits).iter().map(|limit| match limit.joint() {
            Some(joint) => format!("{}_{joint}", limit.name()),
            None => limit.name().to_owned(),
        });
        let measured = packet.measured.map(|measured| measured.joints);
        let tool: Pose = packet.tool.into();
        let message = msg::Arm {
            sequence: packet.sequence,
            slave_us: packet.time_us,
            received_us: t_us,
            state: arm_words::state_name(packet.state).to_owned(),
            standing: arm_words::standing(packet),
            limits: limits.collect(),
            speed_share: packet.speed_share,
            command_age_us: packet.command_age_us(),
            set_point: packet.set_point.to_vec(),
            measured: measured.map_or_else(Vec::new, |joints| joints.to_vec()),
            tool: Some(convert::transform(packet.tool)),
            slowed: arm_words::limits(packet),
            scale: packet.scale,
        };
        feed.message(Topic::Arm, t_us, packet.sequence, &message);
        let stamp = feed.timestamp(t_us);
        feed.message(
            Topic::SetPoint,
            t_us,
            packet.sequence,
            &convert::joint_states(stamp, &packet.set_point),
        );
        if let Some(joints) = measured {
            feed.message(Topic::Joints, t_us, packet.sequence, &convert::joint_states(stamp, &joints));
        }
        let tree = convert::frame_transform(stamp, [BASE, TOOL], &tool);
        feed.message(Topic::Transforms, t_us, packet.sequence, &tree);
    }

    /// How long each stage took so far; written once a second.
    pub fn delays(&mut self, delays: &Delays, now_us: u64) {
        if self.delays_us.is_some_and(|before| now_us.saturating_sub(before) < DELAYS_US) {
            return;
        }
        self.delays_us = Some(now_us);
        let stage = |stage: Stage| {
            let Spread { count, p50_us, p99_us, max_us } = delays.of(stage)?;
            Some(msg::Stage { name: stage.name().to_owned(), count, p50_us, p99_us, max_us })
        };
        let stages = Stage::ALL.into_iter().filter_map(stage).collect();
        self.tape.feed().message(Topic::Delays, now_us, 0, &msg::Delays { time_us: now_us, stages });
    }

    /// A line that the operator read.
    pub fn said(&self, line: &str, now_us: u64) {
        self.tape.feed().log(now_us, Level::Info, line);
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.tape.path()
    }

    /// How many messages were left out so far, for the disk was behind.
    #[must_use]
    pub fn left_out(&self) -> u64 {
        self.tape.left_out()
    }

    /// Whether nothing more is recorded, for writing has failed.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.tape.has_failed()
    }

    /// Why nothing more is recorded, once.
    #[must_use]
    pub fn take_failure(&self) -> Option<SessionError> {
        self.tape.take_failure()
    }

    /// Writes what waits and closes the file.
    ///
    /// # Errors
    /// Why it could not be written.
    pub fn finish(self) -> Result<Recorded, SessionError> {
        self.tape.finish(BTreeMap::from([("instants".to_owned(), self.instants.to_string())]))
    }
}
