//! From what is computed with to what is written, and back: no number is rounded on the way.

use super::schema::foxglove as fox;
use super::schema::tetrad as msg;
use crate::pipeline::HandStep;
use crate::station::pairing::{Joined, Source};
use nalgebra::{Rotation3, UnitQuaternion};
use tetrad_core::geometry::{ImagePoint, Pose};
use tetrad_core::hand::motion::Motion;
use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::{BALLS, Ball, ImageCovariance, Observation, ObservationState, Observations};
use tetrad_core::wire::{Covariance, MotionPacket, Transform};

/// One NaN for all, so that bits can be compared.
fn folded(value: f32) -> f32 {
    if value.is_nan() { f32::NAN } else { value }
}

fn ball_state(state: ObservationState) -> msg::BallState {
    match state {
        ObservationState::Visible => msg::BallState::Visible,
        ObservationState::Occluded => msg::BallState::Occluded,
        ObservationState::Predicted => msg::BallState::Predicted,
        ObservationState::Lost => msg::BallState::Lost,
    }
}

fn hand_state(state: PoseState) -> msg::HandState {
    match state {
        PoseState::Both => msg::HandState::Both,
        PoseState::Three => msg::HandState::Three,
        PoseState::One => msg::HandState::One,
        PoseState::Predicted => msg::HandState::Predicted,
        PoseState::Held => msg::HandState::Held,
        PoseState::Lost => msg::HandState::Lost,
    }
}

/// The hand's state of that number.
#[must_use]
pub(super) fn pose_state(number: i32) -> PoseState {
    PoseState::ALL.into_iter().find(|state| hand_state(*state) as i32 == number).unwrap_or_default()
}

/// The four balls as they are written.
#[must_use]
pub(super) fn balls(seen: &Observations) -> Vec<msg::Observation> {
    let ball = |seen: &Observation| msg::Observation {
        state: ball_state(seen.state).into(),
        u: folded(seen.centre.u),
        v: folded(seen.centre.v),
        diameter: folded(seen.diameter),
        uu: folded(seen.covariance.uu),
        uv: folded(seen.covariance.uv),
        vv: folded(seen.covariance.vv),
        visible: folded(seen.visible),
    };
    seen.iter().map(ball).collect()
}

/// And back; what is missing is lost.
#[must_use]
pub(super) fn observations(balls: &[msg::Observation]) -> Observations {
    let mut all = Observations::default();
    for (slot, ball) in all.iter_mut().zip(balls) {
        *slot = Observation {
            state: match ball.state() {
                msg::BallState::Visible => ObservationState::Visible,
                msg::BallState::Occluded => ObservationState::Occluded,
                msg::BallState::Predicted => ObservationState::Predicted,
                msg::BallState::Lost => ObservationState::Lost,
            },
            centre: ImagePoint::new(ball.u, ball.v),
            diameter: ball.diameter,
            covariance: ImageCovariance { uu: ball.uu, uv: ball.uv, vv: ball.vv },
            visible: ball.visible,
        };
    }
    all
}

/// a_from_b as it is written.
pub(super) fn transform(transform: Transform) -> msg::Transform {
    msg::Transform {
        translation: transform.translation.map(folded).to_vec(),
        rotation: transform.rotation.map(folded).to_vec(),
    }
}

/// The pose in a message; `None` where numbers are missing.
#[must_use]
pub(super) fn pose(transform: &msg::Transform) -> Option<Pose> {
    let translation = transform.translation.as_slice().try_into().ok()?;
    let rotation = transform.rotation.as_slice().try_into().ok()?;
    Some(Transform { translation, rotation }.into())
}

fn motion(motion: &Motion) -> msg::Motion {
    msg::Motion {
        increment: Some(transform(motion.increment().into())),
        since_engage: Some(transform(motion.since_engage.into())),
        engagements: motion.engagements,
        residual_px: folded(motion.residual_px),
        spans: motion.spans,
    }
}

/// The hand as it is written.
#[must_use]
pub(super) fn hand(frame: u64, capture_us: u64, step: &HandStep) -> msg::Hand {
    let report = &step.report;
    msg::Hand {
        frame,
        capture_us,
        state: hand_state(report.state).into(),
        pose: report.pose.map(|pose| transform(pose.into())),
        filtered: step.filtered.map(|pose| transform(pose.into())),
        covariance: report
            .covariance
            .map_or_else(Vec::new, |known| Covariance::from(known).upper.map(folded).to_vec()),
        motion: report.motion.as_ref().ok().map(motion),
        refusal: report.motion.as_ref().err().map_or_else(String::new, ToString::to_string),
        engagements: step.engagements,
    }
}

/// An instant as it is written.
#[must_use]
pub(super) fn instant(joined: &Joined, asked_us: u64) -> msg::Instant {
    let views = joined.views.iter().map(|view| {
        let (known, between_us) = match view.source {
            Source::Missing => (msg::Known::Missing, 0),
            Source::Seen => (msg::Known::Seen, 0),
            Source::Between(us) => (msg::Known::Between, us),
        };
        msg::View { known: known.into(), between_us, balls: balls(&view.balls) }
    });
    msg::Instant {
        capture_us: joined.t_us,
        asked_us,
        // at most eight
        reference: joined.reference as u32,
        views: views.collect(),
    }
}

/// What the slave was told.
#[must_use]
pub(super) fn command(packet: &MotionPacket) -> msg::Command {
    msg::Command {
        sequence: packet.sequence,
        capture_us: packet.capture_us,
        engaged: packet.engaged,
        state: hand_state(packet.state).into(),
        motion: Some(msg::Motion {
            increment: Some(transform(packet.increment)),
            since_engage: Some(transform(packet.since_engage)),
            engagements: packet.engagements,
            residual_px: packet.residual_px,
            spans: packet.spans,
        }),
        seen_in: packet.seen_in.iter().map(|views| u32::from(*views)).collect(),
    }
}

fn vector(pose: &Pose) -> fox::Vector3 {
    let x = pose.translation.map(f64::from);
    fox::Vector3 { x: x.x, y: x.y, z: x.z }
}

fn quaternion(pose: &Pose) -> fox::Quaternion {
    let rotation = Rotation3::from_matrix_unchecked(pose.rotation.map(f64::from));
    let q = UnitQuaternion::from_rotation_matrix(&rotation).into_inner();
    fox::Quaternion { x: q.i, y: q.j, z: q.k, w: q.w }
}

/// A pose for Foxglove.
#[must_use]
pub(super) fn pose_in_frame(timestamp: fox::Timestamp, frame: &str, pose: &Pose) -> fox::PoseInFrame {
    fox::PoseInFrame {
        timestamp: Some(timestamp),
        frame_id: frame.to_owned(),
        pose: Some(fox::Pose { position: Some(vector(pose)), orientation: Some(quaternion(pose)) }),
    }
}

/// parent_from_child for Foxglove.
#[must_use]
pub(super) fn frame_transform(
    timestamp: fox::Timestamp,
    [parent, child]: [&str; 2],
    pose: &Pose,
) -> fox::FrameTransform {
    fox::FrameTransform {
        timestamp: Some(timestamp),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(vector(pose)),
        rotation: Some(quaternion(pose)),
    }
}

/// Six joints for Foxglove.
#[must_use]
pub(super) fn joint_states(timestamp: fox::Timestamp, joints: &[f32]) -> fox::JointStates {
    let joint = |(number, position): (usize, &f32)| fox::JointState {
        name: format!("joint{}", number + 1),
        position: Some(f64::from(*position)),
        ..fox::JointState::default()
    };
    fox::JointStates { timestamp: Some(timestamp), joints: joints.iter().enumerate().map(joint).collect() }
}

/// How each ball is drawn: red, green, blue, yellow.
const PAINT: [fox::Color; BALLS] = [
    fox::Color { r: 1.0, g: 0.25, b: 0.25, a: 1.0 },
    fox::Color { r: 0.25, g: 1.0, b: 0.25, a: 1.0 },
    fox::Color { r: 0.4, g: 0.6, b: 1.0, a: 1.0 },
    fox::Color { r: 1.0, g: 1.0, b: 0.25, a: 1.0 },
];

/// What was seen, to be drawn over the picture: a rim a ball with its first letter, thin and with its
/// state where it was not seen whole.
#[must_use]
pub(super) fn annotations(timestamp: fox::Timestamp, seen: &Observations) -> fox::ImageAnnotations {
    let stamp = Some(timestamp);
    let mut all = fox::ImageAnnotations { timestamp: stamp, ..fox::ImageAnnotations::default() };
    for ((ball, seen), paint) in Ball::ALL.into_iter().zip(seen).zip(PAINT) {
        if seen.state == ObservationState::Lost {
            continue;
        }
        let (u, v, diameter) = (f64::from(seen.centre.u), f64::from(seen.centre.v), f64::from(seen.diameter));
        let whole = seen.state == ObservationState::Visible;
        // Foxglove's (0, 0) is the corner of the first pixel, ours its centre
        let place = |x: f64, y: f64| Some(fox::Point2 { x: x + 0.5, y: y + 0.5 });
        all.circles.push(fox::CircleAnnotation {
            timestamp: stamp,
            position: place(u, v),
            diameter,
            thickness: if whole { 2.0 } else { 1.0 },
            fill_color: Some(fox::Color::default()),
            outline_color: Some(paint),
        });
        let state = if whole { String::new() } else { format!(" {}", seen.state.name()) };
        all.texts.push(fox::TextAnnotation {
            timestamp: stamp,
            position: place(u + 0.6 * diameter, v - 0.6 * diameter),
            text: format!("{}{state}", ball.name()),
            font_size: 12.0,
            text_color: Some(paint),
            background_color: Some(fox::Color { a: 0.4, ..fox::Color::default() }),
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use prost::Message as _;

    #[test]
    fn every_number_of_an_observation_comes_back_to_the_bit() {
        let states = [
            ObservationState::Visible,
            ObservationState::Occluded,
            ObservationState::Predicted,
            ObservationState::Lost,
        ];
        let mut seen = Observations::default();
        for (at, (seen, state)) in seen.iter_mut().zip(states).enumerate() {
            let x = 1.0 / (3.0 + at as f32);
            *seen = Observation {
                state,
                centre: ImagePoint::new(x, 2.0 * x),
                diameter: 3.0 * x,
                covariance: ImageCovariance { uu: 4.0 * x, uv: -5.0 * x, vv: 6.0 * x },
                visible: 0.5 * x,
            };
        }
        let message = msg::Observations { balls: balls(&seen), ..msg::Observations::default() };
        let back = msg::Observations::decode(message.encode_to_vec().as_slice()).unwrap();
        assert_eq!(observations(&back.balls), seen);
        assert_eq!(observations(&back.balls[..2])[2].state, ObservationState::Lost, "what is missing");
    }

    #[test]
    fn states_have_the_numbers_of_the_schema() {
        for state in PoseState::ALL {
            assert_eq!(pose_state(hand_state(state).into()), state);
        }
        assert_eq!(pose_state(77), PoseState::Lost);
    }

    #[test]
    fn a_quarter_turn_about_z_is_the_quaternion_that_it_is() {
        let rotation = nalgebra::Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let translation = nalgebra::Vector3::new(0.5, 0.25, -1.0);
        let told = pose_in_frame(fox::Timestamp::of_us(7), "hand_start", &Pose { rotation, translation });
        let half = 0.5f64.sqrt();
        let fox::Quaternion { x, y, z, w } = told.pose.unwrap().orientation.unwrap();
        assert!(x.abs() < 1e-9 && y.abs() < 1e-9 && (z - half).abs() < 1e-9 && (w - half).abs() < 1e-9);
        assert_eq!(told.pose.unwrap().position, Some(fox::Vector3 { x: 0.5, y: 0.25, z: -1.0 }));
        let message = transform(Pose { rotation, translation }.into());
        assert_eq!(pose(&message), Some(Pose { rotation, translation }));
        assert_eq!(pose(&msg::Transform { rotation: vec![1.0], ..message }), None);
    }
}
