//! The format is pinned here: a test that fails because bytes changed asks for a new [`VERSION`].

use super::frame::{CHECK, Framer};
use super::*;
use crate::geometry::{ImagePoint, Pose};
use crate::hand::state::{PoseCovariance, PoseState};
use crate::hand::synthetic::pose;
use crate::observation::{ImageCovariance, Observation, ObservationState};
use postcard::ser_flavors::Flavor;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use std::{format, string::String, vec, vec::Vec};

mod node;
mod pinned;
mod shown;
mod stations;

/// The packets of the examples in docs/wire.md.
fn examples() -> [Packet; 2] {
    let ball = |state, u, v, diameter, [uu, uv, vv]: [f32; 3], visible| {
        let covariance = ImageCovariance { uu, uv, vv };
        Observation { state, centre: ImagePoint::new(u, v), diameter, covariance, visible }
    };
    let observation = ObservationPacket {
        camera: 1,
        session: 300,
        sequence: 7,
        capture_us: 1_000_000,
        ready_us: 2_000,
        observed_us: 2_900,
        width: 640,
        height: 480,
        pixels_tested: 1500,
        balls: [
            ball(ObservationState::Visible, 320.5, 240.25, 16.0, [0.0009765625, 0.0, 0.0009765625], 1.0),
            ball(ObservationState::Occluded, 100.0, 50.0, 15.5, [0.25, 0.0625, 0.125], 0.5),
            ball(ObservationState::Predicted, 10.0, 20.0, 16.0, [16.0, 0.0, 16.0], 0.0),
            ball(ObservationState::Lost, 0.0, 0.0, 15.0, [0.0; 3], 0.0),
        ],
    };
    let quarter_turn = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let motion = MotionPacket {
        session: 300,
        sequence: 8,
        capture_us: 1_033_333,
        engaged: true,
        engagements: 2,
        state: PoseState::Three,
        spans: 3,
        views: 2,
        seen_in: [2, 2, 2, 2],
        residual_px: 0.125,
        increment: Transform { translation: [0.0078125, 0.0, -0.015625], ..Transform::IDENTITY },
        since_engage: Transform { translation: [0.25, -0.5, 1.0], rotation: quarter_turn },
        covariance: Some(
            PoseCovariance::from_diagonal(&[1.0, 1.0, 4.0, 16.0, 16.0, 64.0].map(|k| k / 1_048_576.0).into())
                .into(),
        ),
    };
    [observation.into(), motion.into()]
}

/// Packets whose fields all take the most bytes.
fn largest() -> [Packet; 2] {
    let [Packet::Observation(mut observation), Packet::Motion(mut motion)] = examples() else {
        unreachable!()
    };
    (observation.camera, observation.session, observation.sequence) = (u8::MAX, u32::MAX, u32::MAX);
    (observation.capture_us, observation.pixels_tested) = (u64::MAX, u32::MAX);
    (observation.ready_us, observation.observed_us) = (u32::MAX, u32::MAX);
    (observation.width, observation.height) = (u16::MAX, u16::MAX);
    (motion.session, motion.sequence, motion.capture_us) = (u32::MAX, u32::MAX, u64::MAX);
    (motion.engagements, motion.spans) = (u32::MAX, u32::MAX);
    [observation.into(), motion.into()]
}

fn body_of(packet: &Packet) -> Vec<u8> {
    let mut out = [0xAA; MAX_BODY_LEN];
    let len = encode_body(packet, &mut out).unwrap();
    out[..len].to_vec()
}

fn frame_of(packet: &Packet) -> Vec<u8> {
    let mut out = [0xAA; MAX_FRAME_LEN];
    let len = encode(packet, &mut out).unwrap();
    out[..len].to_vec()
}

/// A sound frame around any content.
fn framed(body: &[u8]) -> Vec<u8> {
    let mut out = vec![0xAA; body.len() + body.len() / 254 + 5];
    let mut framer = Framer::new(&mut out);
    body.iter().for_each(|byte| framer.try_push(*byte).unwrap());
    let len = framer.finalize().unwrap();
    out.truncate(len);
    out
}

fn decode_all(stream: &[u8]) -> Vec<Result<Packet, DecodeError>> {
    Decoder::new().packets(stream).collect()
}

fn state() -> impl Strategy<Value = ObservationState> {
    use ObservationState::*;
    prop::sample::select(vec![Visible, Occluded, Predicted, Lost])
}

fn finite() -> impl Strategy<Value = f32> {
    any::<f32>().prop_map(|x| if x.is_finite() { x } else { 0.0 })
}

fn observation_packet() -> impl Strategy<Value = Packet> {
    let quality = (0.0_f32..1e9, 0.0_f32..=1.0);
    let ball = (state(), finite(), finite(), finite(), quality);
    let ball = ball.prop_map(|(state, u, v, diameter, (variance, visible))| {
        if state == ObservationState::Lost {
            return Observation { diameter, ..Observation::default() };
        }
        let covariance = ImageCovariance { uu: variance, uv: 0.5 * variance, vv: variance };
        Observation { state, centre: ImagePoint::new(u, v), diameter, covariance, visible }
    });
    let counts =
        (any::<u8>(), any::<u32>(), any::<u32>(), any::<[u32; 2]>(), any::<[u16; 2]>(), any::<u32>());
    let counts = (any::<u64>(), counts);
    (counts, prop::array::uniform4(ball)).prop_map(|(counts, balls)| {
        let (capture_us, counts) = counts;
        let (camera, session, sequence, [ready_us, observed_us], [width, height], pixels_tested) = counts;
        ObservationPacket {
            camera,
            session,
            sequence,
            capture_us,
            ready_us,
            observed_us,
            width,
            height,
            pixels_tested,
            balls,
        }
        .into()
    })
}

fn motion_packet() -> impl Strategy<Value = Packet> {
    let identity = (any::<u32>(), any::<u32>(), any::<u64>(), any::<bool>(), any::<u32>());
    let state = prop::sample::select(PoseState::ALL.to_vec());
    let covariance = prop::option::of((0.0_f32..1.0).prop_map(|k| {
        let mut covariance = PoseCovariance::from_diagonal_element(k);
        (covariance.m13, covariance.m31) = (-0.5 * k, -0.5 * k);
        covariance.into()
    }));
    let quality = (state, any::<u32>(), any::<u8>(), any::<[u8; 4]>(), finite());
    (identity, quality, pose(3.1, 0.1), pose(3.1, 5.0), covariance).prop_map(
        |(identity, quality, increment, since, covariance)| {
            let (session, sequence, capture_us, engaged, engagements) = identity;
            let (state, spans, views, seen_in, residual_px) = quality;
            MotionPacket {
                session,
                sequence,
                capture_us,
                engaged,
                engagements,
                state,
                spans,
                views,
                seen_in,
                residual_px,
                increment: increment.into(),
                since_engage: since.into(),
                covariance,
            }
            .into()
        },
    )
}

fn packet() -> impl Strategy<Value = Packet> {
    prop_oneof![observation_packet(), motion_packet(), stations::packet(), node::packet(), shown::packet()]
}

proptest! {
    #[test]
    fn packets_come_back(packet in packet()) {
        let body = body_of(&packet);
        prop_assert_eq!(decode_body(&body), Ok(packet));
        let frame = frame_of(&packet);
        prop_assert_eq!(&frame, &framed(&body));
        prop_assert_eq!(frame.iter().position(|byte| *byte == 0), Some(frame.len() - 1));
        prop_assert_eq!(decode_all(&frame), [Ok(packet)]);
    }

    #[test]
    fn a_stream_may_be_cut_anywhere(packets in prop::collection::vec(packet(), 1..5), cuts in prop::collection::vec(1_usize..60, 1..40)) {
        let stream: Vec<u8> = packets.iter().flat_map(frame_of).collect();
        let mut decoder = Decoder::new();
        let mut received = Vec::new();
        let (mut rest, mut cuts) = (&stream[..], cuts.into_iter().cycle());
        while !rest.is_empty() {
            let (chunk, behind) = rest.split_at(cuts.next().unwrap().min(rest.len()));
            received.extend(decoder.packets(chunk));
            rest = behind;
        }
        prop_assert_eq!(received, packets.into_iter().map(Ok).collect::<Vec<_>>());
    }

    #[test]
    fn what_stands_between_frames_harms_no_packet(
        packets in prop::collection::vec(packet(), 1..4),
        garbage in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let mut stream = Vec::new();
        for packet in &packets {
            stream.extend(&garbage);
            stream.push(0);
            stream.extend(frame_of(packet));
        }
        let received: Vec<_> = decode_all(&stream).into_iter().filter_map(Result::ok).collect();
        prop_assert_eq!(received, packets);
    }

    #[test]
    fn any_bytes_are_taken(stream in prop::collection::vec(prop_oneof![any::<u8>(), Just(0), Just(1), Just(255)], 0..2000)) {
        let mut whole = Decoder::new();
        let mut bytewise = Decoder::new();
        let singly: Vec<_> = stream.chunks(1).flat_map(|byte| bytewise.packets(byte).collect::<Vec<_>>()).collect();
        prop_assert_eq!(whole.packets(&stream).collect::<Vec<_>>(), singly);
        let _ = decode_body(&stream);
        let example = examples()[1];
        prop_assert!(whole.packets(&[0]).count() <= 1);
        prop_assert_eq!(whole.packets(&frame_of(&example)).collect::<Vec<_>>(), [Ok(example)]);
    }

    #[test]
    fn stuffing_holds_for_any_content(length in 2_usize..1500, zero_every in 1_usize..600, room in 0_usize..1600) {
        // contents of a version to come: named as such only if length and check came through whole
        let body: Vec<u8> = (0..length).map(|i| if i % zero_every == zero_every - 1 { 0 } else { 9 }).collect();
        prop_assume!(body[0] == 9);
        let frame = framed(&body);
        prop_assert_eq!(frame.iter().position(|byte| *byte == 0), Some(frame.len() - 1));
        let mut decoder = Decoder::<2048>::with_room();
        prop_assert_eq!(decoder.packets(&frame).collect::<Vec<_>>(), [Err(DecodeError::UnknownVersion(9))]);
        let mut small = vec![0; room];
        let mut framer = Framer::new(&mut small);
        let written = body.iter().try_for_each(|byte| framer.try_push(*byte)).and_then(|()| framer.finalize());
        prop_assert_eq!(written.is_ok(), room >= frame.len());
    }
}

#[test]
fn every_split_in_two_gives_the_packet() {
    for packet in examples().into_iter().chain(largest()) {
        let frame = frame_of(&packet);
        for at in 0..=frame.len() {
            let mut decoder = Decoder::new();
            let (head, tail) = frame.split_at(at);
            let first: Vec<_> = decoder.packets(head).collect();
            let second: Vec<_> = decoder.packets(tail).collect();
            assert_eq!([first, second].concat(), [Ok(packet)], "split at {at}");
        }
    }
}

#[test]
fn feed_gives_back_the_rest() {
    let [first, second] = examples();
    let stream = [frame_of(&first), frame_of(&second), vec![0, 0, 3]].concat();
    let mut decoder = Decoder::new();
    let Feed::Frame { result, rest } = decoder.feed(&stream) else { panic!("no frame") };
    assert_eq!((result, rest.len()), (Ok(first), frame_of(&second).len() + 3));
    let Feed::Frame { result, rest } = decoder.feed(rest) else { panic!("no frame") };
    assert_eq!((result, rest), (Ok(second), &[0, 0, 3][..]));
    assert_eq!(decoder.feed(rest), Feed::Consumed, "zero bytes are idle, and a frame has begun");
    assert_eq!(decoder.feed(&[]), Feed::Consumed);
    let cut = Feed::Frame { result: Err(DecodeError::BadFraming), rest: &[] };
    assert_eq!(decoder.feed(&[9, 0]), cut);
}

#[test]
fn no_flipped_bit_gives_a_packet() {
    let mut runner = TestRunner::deterministic();
    let random = (0..20).map(|_| packet().new_tree(&mut runner).unwrap().current());
    for packet in examples().into_iter().chain(largest()).chain(random.collect::<Vec<_>>()) {
        let frame = frame_of(&packet);
        for bit in 0..frame.len() * 8 {
            let mut damaged = frame.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            damaged.push(0);
            let mut decoder = Decoder::new();
            let received: Vec<_> = decoder.packets(&damaged).collect();
            assert!(
                !received.is_empty() && received.iter().all(Result::is_err),
                "bit {bit} of {packet:?}: {received:?}"
            );
            assert_eq!(decoder.packets(&frame).collect::<Vec<_>>(), [Ok(packet)], "after bit {bit}");
        }
    }
}

#[test]
fn no_run_of_damage_gives_a_wrong_packet() {
    let mut runner = TestRunner::deterministic();
    for _ in 0..2000 {
        let packet = packet().new_tree(&mut runner).unwrap().current();
        let frame = frame_of(&packet);
        let (at, damage) = (0..frame.len(), prop::collection::vec(any::<u8>(), 0..20))
            .new_tree(&mut runner)
            .unwrap()
            .current();
        // as many bytes replaced as come in, or fewer or more: lost and repeated bytes
        let until = (at + damage.len() / 2 + damage.len() % 3).min(frame.len());
        let mut damaged = frame.clone();
        damaged.splice(at..until, damage);
        damaged.push(0);
        for received in decode_all(&damaged).into_iter().flatten() {
            assert_eq!(received, packet);
        }
    }
}

#[test]
fn every_reason_to_refuse_a_frame() {
    use DecodeError::*;
    let [observation, motion] = examples().map(|packet| body_of(&packet));
    let refused = |body: &[u8]| {
        let [only] = decode_all(&framed(body))[..] else { panic!("one frame, one result") };
        assert!(body.len() < 2 || decode_body(body) == only, "the same with and without a frame");
        only.unwrap_err()
    };
    let with = |body: &[u8], at: usize, bytes: &[u8]| {
        let mut changed = body.to_vec();
        changed[at..at + bytes.len()].copy_from_slice(bytes);
        changed
    };
    assert_eq!(decode_all(&[5, 1, 2, 0]), [Err(BadFraming)]);
    assert_eq!(decode_all(&[3, 1, 2, 0]), [Err(BadCrc)]);
    assert_eq!(decode_all(&[2, 1, 0]), [Err(TooShort)]);
    assert_eq!(decode_all(&[1, 0]), [Err(TooShort)]);
    assert_eq!(refused(&[1]), TooShort);
    assert_eq!(refused(&[]), TooShort);
    assert_eq!(decode_all(&framed(&[9; 400])), [Err(Overlong)]);
    assert_eq!(
        Decoder::<80>::with_room().packets(&frame_of(&examples()[1])).collect::<Vec<_>>(),
        [Err(Overlong)]
    );
    assert_eq!(refused(&with(&motion, 0, &[0])), UnknownVersion(0));
    assert_eq!(refused(&with(&motion, 0, &[2])), UnknownVersion(2));
    assert_eq!(refused(&with(&motion, 1, &[0])), UnknownKind(0));
    assert_eq!(refused(&with(&motion, 1, &[9])), UnknownKind(9));

    for (name, body) in [("observation", &observation), ("motion", &motion)] {
        for len in 2..body.len() {
            assert_eq!(refused(&body[..len]), MalformedBody, "{name} cut to {len}");
        }
        assert_eq!(refused(&[&body[..], &[0]].concat()), TrailingBytes, "{name}");
        assert_eq!(refused(&with(body, 2, &[0xFF; 10])), MalformedBody, "{name}: a number without end");
    }
    let balls_at = observation.len() - 116;
    assert_eq!(refused(&with(&observation, balls_at, &[4])), MalformedBody, "no fifth state");
    for (place, nan) in [
        (1, f32::NAN),
        (5, f32::INFINITY),
        (9, f32::NEG_INFINITY),
        (13, f32::NAN),
        (25, f32::INFINITY),
        (38, f32::NAN),
    ] {
        let body = with(&observation, balls_at + place, &nan.to_le_bytes());
        assert_eq!(refused(&body), Value(BadValue::NotFinite), "byte {place} of the balls");
    }
    for (place, number) in [(13, -1.0_f32), (17, 0.1), (21, -0.5)] {
        let body = with(&observation, balls_at + place, &number.to_le_bytes());
        assert_eq!(refused(&body), Value(BadValue::NotACovariance), "byte {place} of the balls");
    }
    for share in [-0.1_f32, 1.5] {
        let body = with(&observation, balls_at + 25, &share.to_le_bytes());
        assert_eq!(refused(&body), Value(BadValue::NotAShare), "{share}");
    }
    let engaged_at = motion.len() - 194;
    assert_eq!(motion[engaged_at..engaged_at + 4], [1, 2, 1, 3], "engaged, engagements, state, spans");
    assert_eq!(refused(&with(&motion, engaged_at, &[2])), MalformedBody, "a bool of 2");
    assert_eq!(refused(&with(&motion, engaged_at + 2, &[6])), MalformedBody, "no seventh state");
    assert_eq!(refused(&with(&motion, motion.len() - 85, &[2])), MalformedBody, "neither there nor not");
    for from_end in [185, 181, 169, 133, 89, 84, 4] {
        let body = with(&motion, motion.len() - from_end, &f32::NAN.to_le_bytes());
        assert_eq!(refused(&body), Value(BadValue::NotFinite), "{from_end} bytes from the end");
    }
    for (from_end, number) in [(89, 1.01_f32), (89, -1.0), (169, 0.9), (101, 0.01)] {
        let body = with(&motion, motion.len() - from_end, &number.to_le_bytes());
        assert_eq!(refused(&body), Value(BadValue::NotARotation), "{number} {from_end} bytes from the end");
    }
    for (from_end, number) in [(4, -1.0_f32), (84, -1e-9), (80, 1.0)] {
        let body = with(&motion, motion.len() - from_end, &number.to_le_bytes());
        assert_eq!(refused(&body), Value(BadValue::NotACovariance), "{number} {from_end} bytes from the end");
    }
}

#[test]
fn what_may_not_be_sent_is_refused() {
    let [Packet::Observation(observation), Packet::Motion(motion)] = examples() else { unreachable!() };
    let refused = |packet: Packet| {
        let mut out = [0; MAX_FRAME_LEN];
        let reason = encode(&packet, &mut out).unwrap_err();
        assert_eq!(encode_body(&packet, &mut out), Err(reason));
        reason
    };
    let not_finite = EncodeError::Value(BadValue::NotFinite);
    for bad in [f32::NAN, f32::INFINITY] {
        let mut packet = observation;
        packet.balls[2].centre.u = bad;
        assert_eq!(refused(packet.into()), not_finite);
        let mut packet = observation;
        packet.balls[3].diameter = bad;
        assert_eq!(refused(packet.into()), not_finite);
        assert_eq!(refused(MotionPacket { residual_px: bad, ..motion }.into()), not_finite);
        let mut packet = motion;
        packet.increment.translation[1] = bad;
        assert_eq!(refused(packet.into()), not_finite);
    }
    let mut mirrored = motion;
    mirrored.since_engage.rotation[8] = -1.0;
    assert_eq!(refused(mirrored.into()), EncodeError::Value(BadValue::NotARotation));
    let mut zero = motion;
    zero.increment.rotation = [0.0; 9];
    assert_eq!(refused(zero.into()), EncodeError::Value(BadValue::NotARotation));

    let mut lost = observation;
    lost.balls[3].centre = ImagePoint::new(f32::NAN, 77.0);
    assert_eq!(body_of(&lost.into()), body_of(&observation.into()), "a lost ball has no place");
}

#[test]
fn a_buffer_that_is_too_short_is_refused() {
    for packet in examples().into_iter().chain(largest()) {
        for len in 0..frame_of(&packet).len() {
            assert_eq!(encode(&packet, &mut vec![0; len]), Err(EncodeError::BufferTooSmall), "{len}");
        }
        for len in 0..body_of(&packet).len() {
            assert_eq!(encode_body(&packet, &mut vec![0; len]), Err(EncodeError::BufferTooSmall), "{len}");
        }
    }
}

#[test]
fn a_transform_is_a_pose() {
    let mut runner = TestRunner::deterministic();
    for _ in 0..100 {
        let pose = pose(3.1, 2.0).new_tree(&mut runner).unwrap().current();
        assert_eq!(Pose::from(Transform::from(pose)), pose);
    }
    assert_eq!(Transform::from(Pose::identity()), Transform::IDENTITY);
    let quarter =
        Pose { rotation: nalgebra::Matrix3::new(0., -1., 0., 1., 0., 0., 0., 0., 1.), ..Pose::identity() };
    assert_eq!(Transform::from(quarter).rotation, [0., -1., 0., 1., 0., 0., 0., 0., 1.], "row by row");
}
