//! Packets as stations send them, for tests: a hand at rest that two cameras see, a button that is let
//! go, a camera before which there is nothing. Take one and change what the test is about.

use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::{BALLS, Observation};
use tetrad_core::wire::{
    ArmReason, ArmState, ArmStatePacket, ArmVerdict, ButtonsPacket, ControllerState, MotionPacket,
    ObservationPacket, PressFor, ScaleShare, Transform,
};

/// A hand at rest where it was latched, for the first time; the operator wants the arm to move.
#[must_use]
pub const fn motion(session: u32, sequence: u32) -> MotionPacket {
    MotionPacket {
        session,
        sequence,
        capture_us: 0,
        engaged: true,
        engagements: 1,
        state: PoseState::Both,
        spans: 1,
        views: 2,
        seen_in: [2; BALLS],
        residual_px: 0.1,
        increment: Transform::IDENTITY,
        since_engage: Transform::IDENTITY,
        covariance: None,
    }
}

/// The same hand, this far from where it was latched, metres.
#[must_use]
pub const fn motion_to(session: u32, sequence: u32, place_m: [f32; 3]) -> MotionPacket {
    let since_engage = Transform { translation: place_m, ..Transform::IDENTITY };
    MotionPacket { since_engage, ..motion(session, sequence) }
}

/// Nothing is pressed, and nothing was asked for.
#[must_use]
pub const fn buttons(session: u32, sequence: u32) -> ButtonsPacket {
    ButtonsPacket {
        session,
        sequence,
        time_us: 0,
        pressed: false,
        stop: false,
        resets: 0,
        press_for: PressFor::Follow,
        scale: ScaleShare::FULL,
    }
}

/// An arm that is switched on and that nothing limits, in this state, for this reason.
#[must_use]
pub const fn arm_state(state: ArmState, reason: ArmReason) -> ArmStatePacket {
    ArmStatePacket {
        session: 1,
        sequence: 1,
        time_us: 1,
        state,
        reason,
        notes: 0,
        verdict: ArmVerdict::Pass,
        limits: 0,
        speed_share: 1.0,
        controller: ControllerState::Ready,
        measured: None,
        set_point: [0.0; 6],
        tool: Transform::IDENTITY,
        command: None,
        settled: None,
        buttons_age_us: None,
        scale: 1.0,
    }
}

/// A picture without a ball: in memory 1 ms after it was taken, looked through 2 ms later.
#[must_use]
pub fn observation(session: u32, sequence: u32) -> ObservationPacket {
    ObservationPacket {
        camera: 0,
        session,
        sequence,
        capture_us: 0,
        ready_us: 1_000,
        observed_us: 3_000,
        width: 640,
        height: 480,
        pixels_tested: 100,
        balls: [Observation::default(); BALLS],
    }
}
