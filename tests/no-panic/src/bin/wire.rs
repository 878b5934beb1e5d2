//! Writing any packet into any slice, and reading any bytes.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::{Ball, Observation};
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::wire::{
    ArmReason, ArmState, ArmStatePacket, ArmVerdict, ButtonsPacket, CommandEcho, ControllerState, Covariance,
    Decoder, Feed, MeasuredJoints, MotionPacket, ObservationPacket, Packet, PressFor, PreviewPacket,
    ScaleShare, Settled, Shown, ShownPacket, Strip, Transform, decode_body, encode, encode_body,
};

tetrad_no_panic::program!({
    let observations = Packet::from(ObservationPacket {
        camera: 1,
        session: 2,
        sequence: 3,
        capture_us: 4,
        ready_us: 5,
        observed_us: 6,
        width: 7,
        height: 8,
        pixels_tested: 9,
        balls: [Observation::default(); 4],
    });
    let motion = Packet::from(MotionPacket {
        session: 1,
        sequence: 2,
        capture_us: 3,
        engaged: true,
        engagements: 4,
        state: PoseState::Held,
        spans: 5,
        views: 6,
        seen_in: [7; 4],
        residual_px: 8.0,
        increment: Transform::IDENTITY,
        since_engage: Transform::IDENTITY,
        covariance: Some(Covariance { upper: [0.0; 21] }),
    });
    let state = Packet::from(ArmStatePacket {
        session: 1,
        sequence: 2,
        time_us: 3,
        state: ArmState::Engaged,
        reason: ArmReason::None,
        notes: 4,
        verdict: ArmVerdict::Pass,
        limits: 5,
        speed_share: 0.5,
        controller: ControllerState::Fault { joint: 6, code: 7 },
        measured: Some(MeasuredJoints { joints: [0.0; 6], age_us: 8 }),
        set_point: [0.0; 6],
        tool: Transform::IDENTITY,
        command: Some(CommandEcho {
            session: 9,
            sequence: 10,
            received_us: 11,
            solved_after_us: 12,
            written_after_us: 13,
        }),
        settled: Some(Settled { sequence: 14, after_us: 15 }),
        buttons_age_us: Some(16),
        scale: 0.5,
    });
    let buttons = Packet::from(ButtonsPacket {
        session: 1,
        sequence: 2,
        time_us: 3,
        pressed: true,
        stop: false,
        resets: 4,
        press_for: black_box(PressFor::Home),
        scale: black_box(ScaleShare::FULL),
    });
    let preview = Packet::from(PreviewPacket {
        camera: 1,
        session: 2,
        sequence: 3,
        ball: Ball::Blue,
        left: 4,
        top: 5,
        step: 6,
        row: 7,
        pixels: [[8; 32]; 6],
    });
    let look = Shown::Look { capture_us: 3, length: 4, width: 5, height: 6, format: PixelFormat::Nv12 };
    let bytes = black_box([1_u8; 300]);
    let strip = Strip::of(bytes.get(..black_box(9)).unwrap_or_default());
    let shown = strip.map_or(look, |strip| Shown::Strip { offset: 3, strip });
    let shown = Packet::from(ShownPacket { session: 1, picture: 2, shown });
    let mut buffer = black_box([0_u8; 300]);
    for packet in black_box([observations, motion, state, buttons, preview, shown]) {
        for length in black_box([0_usize, 9, 300]) {
            if let Some(out) = buffer.get_mut(..length) {
                let _ = black_box(encode_body(&packet, out));
                let _ = black_box(encode(&packet, out));
            }
        }
    }
    let _ = black_box(decode_body(black_box(&buffer)));
    let mut decoder = black_box(Decoder::<256>::new());
    let mut rest: &[u8] = black_box(&buffer);
    while let Feed::Frame { result, rest: left } = decoder.feed(rest) {
        let _ = black_box(result);
        rest = left;
    }
});
