//! One cycle as a packet: what the slave station tells the operator.

use super::{ArmReading, SlaveStep};
use crate::arm::governor::{Limits, Verdict};
use crate::arm::port::PortStatus;
use crate::arm::teleop::{ArmedReason, FaultReason, HoldReason, State, Status, StopReason};
use crate::config::JOINTS;
use crate::geometry::Pose;
use crate::real::Real;
use crate::wire::{
    ArmReason, ArmState, ArmStatePacket, ArmVerdict, CommandEcho, ControllerState, MeasuredJoints, Settled,
    Transform,
};
use nalgebra::{Matrix3, Vector3};

/// What a cycle does not know of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// The station's session.
    pub session: u32,
    /// Counts the packets.
    pub sequence: u32,
    /// When the cycle was, microseconds of the station's clock.
    pub time_us: u64,
    /// The newest motion that was used.
    pub command: Option<CommandEcho>,
    /// The newest motion whose goal the measured joints have reached.
    pub settled: Option<Settled>,
    /// How long ago the operator's buttons were heard, microseconds.
    pub buttons_age_us: Option<u32>,
}

impl<T: Real> SlaveStep<T> {
    /// The packet of this cycle. What is not finite is not measured.
    #[must_use]
    pub fn report(&self, reading: &ArmReading<T>, stamp: &Stamp) -> ArmStatePacket {
        let measured = reading.joints.filter(|reading| reading.joints.iter().all(|angle| angle.is_finite()));
        let measured = measured
            .map(|reading| MeasuredJoints { joints: reading.joints.map(single), age_us: reading.age_us });
        let tool =
            self.governed.map(|governed| governed.pose).or(self.measured.filter(|_| measured.is_some()));
        ArmStatePacket {
            session: stamp.session,
            sequence: stamp.sequence,
            time_us: stamp.time_us,
            state: state(self.decision.status.state()),
            reason: reason(self.decision.status),
            notes: self.decision.notes.bits(),
            verdict: self.governed.map_or(ArmVerdict::Pass, |governed| verdict(governed.verdict)),
            limits: self.governed.map_or(Limits::NONE, |governed| governed.limits).bits(),
            speed_share: self.governed.map_or(0.0, |governed| share(governed.speed_share)),
            controller: controller(reading.status),
            measured,
            set_point: self
                .governed
                .map(|governed| governed.set_point.map(single))
                .or(measured.map(|measured| measured.joints))
                .unwrap_or([0.0; JOINTS]),
            tool: tool.map_or(Transform::IDENTITY, |pose| single_pose(&pose).into()),
            command: stamp.command,
            settled: stamp.settled,
            buttons_age_us: stamp.buttons_age_us,
            scale: single(self.decision.scale),
        }
    }
}

fn single<T: Real>(value: T) -> f32 {
    value.to_f64() as f32
}

/// Rounding may carry a share a little beyond its ends; what is no number is none at all.
fn share<T: Real>(value: T) -> f32 {
    let share = single(value);
    if share > 1.0 {
        1.0
    } else if share > 0.0 {
        share
    } else {
        0.0
    }
}

fn single_pose<T: Real>(pose: &Pose<T>) -> Pose<f32> {
    let (t, r) = (&pose.translation, &pose.rotation);
    let [r1, r2, r3] = [
        [r.m11, r.m12, r.m13].map(single),
        [r.m21, r.m22, r.m23].map(single),
        [r.m31, r.m32, r.m33].map(single),
    ];
    let ([a, b, c], [d, e, f], [g, h, i]) = (r1, r2, r3);
    Pose {
        rotation: Matrix3::new(a, b, c, d, e, f, g, h, i),
        translation: Vector3::new(single(t.x), single(t.y), single(t.z)),
    }
}

const fn state(state: State) -> ArmState {
    match state {
        State::Stopped => ArmState::Stopped,
        State::Armed => ArmState::Armed,
        State::Engaged => ArmState::Engaged,
        State::Hold => ArmState::Hold,
        State::Fault => ArmState::Fault,
    }
}

const fn reason(status: Status) -> ArmReason {
    match status {
        Status::Engaged => ArmReason::None,
        Status::Stopped(StopReason::Started) => ArmReason::Started,
        // a station that ends is asked to: the link's end tells the rest
        Status::Stopped(StopReason::Asked | StopReason::Ending) => ArmReason::Asked,
        Status::Stopped(StopReason::TwoSenders) => ArmReason::TwoSenders,
        Status::Stopped(StopReason::SetPointRefused) => ArmReason::SetPointRefused,
        Status::Fault(FaultReason::ArmNotReady) => ArmReason::ArmNotReady,
        Status::Fault(FaultReason::Arm) => ArmReason::Arm,
        Status::Fault(FaultReason::ArmCannotStart) => ArmReason::ArmCannotStart,
        Status::Fault(FaultReason::ArmAstray) => ArmReason::ArmAstray,
        Status::Fault(FaultReason::ArmBlind) => ArmReason::ArmBlind,
        Status::Fault(FaultReason::ArmPoseNotFinite | FaultReason::ArmPoseNotARotation) => ArmReason::ArmPose,
        Status::Fault(FaultReason::ClockWentBack) => ArmReason::ClockWentBack,
        Status::Hold(HoldReason::NoCommand) => ArmReason::NoCommand,
        Status::Hold(HoldReason::NoHoldToRun) => ArmReason::NoHoldToRun,
        Status::Hold(HoldReason::BadCommand(_)) => ArmReason::BadCommand,
        Status::Hold(HoldReason::HandNotSeen) => ArmReason::HandNotSeen,
        Status::Hold(HoldReason::HandNotMeasured) => ArmReason::HandNotMeasured,
        Status::Armed(ArmedReason::Press) => ArmReason::Press,
        Status::Armed(ArmedReason::Engage) => ArmReason::Engage,
        Status::Armed(ArmedReason::LetGo(_)) => ArmReason::LetGo,
        Status::Armed(ArmedReason::NewSender) => ArmReason::NewSender,
        Status::Armed(ArmedReason::PressChanged) => ArmReason::PressChanged,
    }
}

const fn verdict(verdict: Verdict) -> ArmVerdict {
    match verdict {
        Verdict::Pass => ArmVerdict::Pass,
        Verdict::Clamp => ArmVerdict::Clamp,
        Verdict::Reject => ArmVerdict::Reject,
    }
}

const fn controller(status: PortStatus) -> ControllerState {
    match status {
        PortStatus::Disabled => ControllerState::Disabled,
        PortStatus::Enabling => ControllerState::Enabling,
        PortStatus::NotHomed => ControllerState::NotHomed,
        PortStatus::Ready => ControllerState::Ready,
        PortStatus::Stopped => ControllerState::Stopped,
        PortStatus::Fault(fault) => ControllerState::Fault {
            joint: match fault.joint {
                Some(joint) => joint,
                None => 0,
            },
            code: fault.code,
        },
        PortStatus::Lost => ControllerState::Lost,
    }
}
