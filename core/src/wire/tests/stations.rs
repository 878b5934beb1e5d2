//! The packets between the operator and the slave: the arm's state, and the buttons.

use super::super::body::{ARM_STATE, BUTTONS};
use super::pinned::{documented, hex};
use super::*;

/// The packets of the examples in docs/wire.md.
pub(super) fn examples() -> [Packet; 2] {
    let half_turn = [-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0];
    let state = ArmStatePacket {
        session: 400,
        sequence: 9,
        time_us: 2_000_000,
        state: ArmState::Engaged,
        reason: ArmReason::None,
        notes: 0b10,
        verdict: ArmVerdict::Clamp,
        limits: 0b10_0000_0000,
        speed_share: 0.75,
        controller: ControllerState::Ready,
        measured: Some(MeasuredJoints { joints: [0.0, 0.5, -0.5, 0.0, 1.0, 0.0], age_us: 900 }),
        set_point: [0.0, 0.5, -0.5, 0.0, 1.25, 0.0],
        tool: Transform { translation: [0.5, -0.125, 0.75], rotation: half_turn },
        command: Some(CommandEcho {
            session: 300,
            sequence: 8,
            received_us: 1_990_000,
            solved_after_us: 40,
            written_after_us: 200,
        }),
        settled: Some(Settled { sequence: 5, after_us: 60_000 }),
        buttons_age_us: Some(12_000),
        scale: 0.5,
    };
    let buttons = ButtonsPacket {
        session: 300,
        sequence: 5,
        time_us: 1_000_000,
        pressed: true,
        stop: false,
        resets: 1,
        press_for: PressFor::Home,
        scale: ScaleShare::from_percent(50).unwrap(),
    };
    [state.into(), buttons.into()]
}

/// Packets whose fields all take the most bytes.
fn largest() -> [Packet; 2] {
    let [Packet::ArmState(mut state), Packet::Buttons(mut buttons)] = examples() else { unreachable!() };
    (state.session, state.sequence, state.time_us) = (u32::MAX, u32::MAX, u64::MAX);
    (state.limits, state.buttons_age_us) = (u64::MAX, Some(u32::MAX));
    state.controller = ControllerState::Fault { joint: u8::MAX, code: u32::MAX };
    state.measured = Some(MeasuredJoints { joints: [1.0; 6], age_us: u32::MAX });
    state.command = Some(CommandEcho {
        session: u32::MAX,
        sequence: u32::MAX,
        received_us: u64::MAX,
        solved_after_us: u32::MAX,
        written_after_us: u32::MAX,
    });
    state.settled = Some(Settled { sequence: u32::MAX, after_us: u32::MAX });
    (buttons.session, buttons.sequence, buttons.time_us) = (u32::MAX, u32::MAX, u64::MAX);
    buttons.resets = u32::MAX;
    [state.into(), buttons.into()]
}

fn controller() -> impl Strategy<Value = ControllerState> {
    use ControllerState::*;
    let fault = (any::<u8>(), any::<u32>()).prop_map(|(joint, code)| Fault { joint, code });
    let plain = prop::sample::select(vec![Disabled, Enabling, NotHomed, Ready, Stopped, Lost]);
    prop_oneof![plain, fault]
}

fn arm_state_packet() -> impl Strategy<Value = Packet> {
    let law = (
        prop::sample::select(ArmState::ALL.to_vec()),
        prop::sample::select(ArmReason::ALL.to_vec()),
        prop::sample::select(ArmVerdict::ALL.to_vec()),
        any::<(u8, u64)>(),
        0.0_f32..=1.0,
    );
    let joints = || prop::array::uniform6(finite());
    let measured = prop::option::of((joints(), any::<u32>()));
    let command = prop::option::of(any::<(u32, u32, u64, u32, u32)>());
    let progress = (command, any::<Option<(u32, u32)>>());
    let place = (controller(), measured, joints(), pose(3.1, 2.0));
    (any::<(u32, u32, u64)>(), law, place, progress, any::<Option<u32>>(), finite()).prop_map(
        |((session, sequence, time_us), law, place, (command, settled), buttons_age_us, scale)| {
            let (state, reason, verdict, (notes, limits), speed_share) = law;
            let (controller, measured, set_point, tool) = place;
            let measured = measured.map(|(joints, age_us)| MeasuredJoints { joints, age_us });
            let command = command.map(|(session, sequence, received_us, solved, written)| CommandEcho {
                session,
                sequence,
                received_us,
                solved_after_us: solved,
                written_after_us: written,
            });
            let settled = settled.map(|(sequence, after_us)| Settled { sequence, after_us });
            ArmStatePacket {
                session,
                sequence,
                time_us,
                state,
                reason,
                notes,
                verdict,
                limits,
                speed_share,
                controller,
                measured,
                set_point,
                tool: tool.into(),
                command,
                settled,
                buttons_age_us,
                scale,
            }
            .into()
        },
    )
}

fn buttons_packet() -> impl Strategy<Value = Packet> {
    let wished = (prop::sample::select(PressFor::ALL.to_vec()), 1..=100_u8);
    (any::<(u32, u32, u64, bool, bool, u32)>(), wished).prop_map(
        |((session, sequence, time_us, pressed, stop, resets), (press_for, percent))| {
            let scale = ScaleShare::from_percent(percent).unwrap();
            ButtonsPacket { session, sequence, time_us, pressed, stop, resets, press_for, scale }.into()
        },
    )
}

pub(super) fn packet() -> impl Strategy<Value = Packet> {
    prop_oneof![arm_state_packet(), buttons_packet()]
}

#[test]
fn the_document_shows_what_is_sent() {
    for (name, packet) in ["arm state", "buttons"].into_iter().zip(examples()) {
        assert_eq!(hex(&documented(&std::format!("{name} body"))), hex(&body_of(&packet)));
        assert_eq!(decode_all(&frame_of(&packet)), [Ok(packet)]);
    }
    for (name, longest) in [("arm state", ArmStatePacket::MAX_LEN), ("buttons", ButtonsPacket::MAX_LEN)] {
        let fact = std::format!("| {name} | {} | {} |", 2 + longest, 2 + longest + 4);
        assert!(super::pinned::DOCUMENT.contains(&fact), "docs/wire.md lacks: {fact}");
    }
}

#[test]
fn the_lengths_are_reached_and_never_passed() {
    let [state, buttons] = largest();
    assert_eq!(body_of(&state).len(), 2 + ArmStatePacket::MAX_LEN);
    assert_eq!(body_of(&buttons).len(), 2 + ButtonsPacket::MAX_LEN);
}

#[test]
fn the_numbers_of_enums_are_pinned() {
    let [Packet::ArmState(packet), _] = examples() else { unreachable!() };
    let byte_of = |packet: ArmStatePacket, place: usize| body_of(&packet.into())[place];
    // version, kind, session of 2 bytes, sequence of 1, time of 3
    let at = 2 + 2 + 1 + 3;
    for (number, state) in (0..).zip(ArmState::ALL) {
        assert_eq!(byte_of(ArmStatePacket { state, ..packet }, at), number, "{state:?}");
    }
    for (number, reason) in (0..).zip(ArmReason::ALL) {
        assert_eq!(byte_of(ArmStatePacket { reason, ..packet }, at + 1), number, "{reason:?}");
    }
    for (number, verdict) in (0..).zip(ArmVerdict::ALL) {
        assert_eq!(byte_of(ArmStatePacket { verdict, ..packet }, at + 3), number, "{verdict:?}");
    }
    use ControllerState::*;
    let all = [Disabled, Enabling, NotHomed, Ready, Stopped, Fault { joint: 1, code: 2 }, Lost];
    for (number, controller) in (0..).zip(all) {
        // behind limits of 2 bytes and the share
        let place = at + 4 + 2 + 4;
        assert_eq!(byte_of(ArmStatePacket { controller, ..packet }, place), number, "{controller:?}");
    }
    let [_, Packet::Buttons(buttons)] = examples() else { unreachable!() };
    for (number, press_for) in (0..).zip(PressFor::ALL) {
        let body = body_of(&ButtonsPacket { press_for, ..buttons }.into());
        assert_eq!(body[body.len() - 2], number, "{press_for:?}");
    }
    let [state, buttons] = examples().map(|packet| body_of(&packet));
    assert_eq!((state[1], buttons[1]), (ARM_STATE, BUTTONS));
    assert_eq!((ARM_STATE, BUTTONS), (3, 4));
}

#[test]
fn what_cannot_be_an_arm_is_neither_sent_nor_taken() {
    let [Packet::ArmState(packet), _] = examples() else { unreachable!() };
    let body = body_of(&packet.into());
    let refused = |packet: ArmStatePacket| {
        let mut out = [0; MAX_FRAME_LEN];
        encode(&packet.into(), &mut out).unwrap_err()
    };
    let mut bad = packet;
    bad.set_point[5] = f32::NAN;
    assert_eq!(refused(bad), EncodeError::Value(BadValue::NotFinite));
    let mut bad = packet;
    bad.measured = Some(MeasuredJoints { joints: [f32::INFINITY; 6], age_us: 0 });
    assert_eq!(refused(bad), EncodeError::Value(BadValue::NotFinite));
    let mut bad = packet;
    bad.tool.rotation[0] = 1.0;
    assert_eq!(refused(bad), EncodeError::Value(BadValue::NotARotation));
    for share in [-0.1, 1.1, f32::NAN] {
        let bad = ArmStatePacket { speed_share: share, ..packet };
        assert_eq!(refused(bad), EncodeError::Value(BadValue::NotAShare));
    }
    let share_at = 2 + 2 + 1 + 3 + 4 + 2;
    let mut changed = body.clone();
    changed[share_at..share_at + 4].copy_from_slice(&2.0_f32.to_le_bytes());
    assert_eq!(decode_body(&changed), Err(DecodeError::Value(BadValue::NotAShare)));
    let mut bad = packet;
    bad.scale = f32::INFINITY;
    assert_eq!(refused(bad), EncodeError::Value(BadValue::NotFinite));
    for len in 2..body.len() {
        assert_eq!(decode_body(&body[..len]), Err(DecodeError::MalformedBody), "cut to {len}");
    }
    assert_eq!(decode_body(&[&body[..], &[0]].concat()), Err(DecodeError::TrailingBytes));
}

#[test]
fn a_percentage_that_is_none_is_not_taken() {
    let [_, buttons] = examples();
    let mut body = body_of(&buttons);
    let last = body.len() - 1;
    for percent in [0, 101, 255] {
        body[last] = percent;
        assert_eq!(decode_body(&body), Err(DecodeError::Value(BadValue::NotAShare)), "{percent}");
    }
    (body[last], body[last - 1]) = (100, 2);
    assert_eq!(decode_body(&body), Err(DecodeError::MalformedBody), "a press for what nobody knows");
}

#[test]
fn the_age_of_a_command_is_by_the_slaves_clock() {
    let [Packet::ArmState(packet), _] = examples() else { unreachable!() };
    assert_eq!(packet.command_age_us(), Some(10_000));
    assert_eq!(ArmStatePacket { command: None, ..packet }.command_age_us(), None);
}
