//! What a camera and the hand were taught during a session, as it is written, and what a replay makes of it:
//! with what the session began with, all that its trackers ever began with.

use super::schema::tetrad as msg;
use crate::balls::ball_by_name;
use crate::station::camera::{Order, Taught};
use tetrad_core::config::TrackerConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::Arms;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::{Primary, Reference};
use tetrad_core::vision::frame::Rgb;

/// Where each ball is; `None` where it is searched for.
type Places = [Option<ImagePoint>; BALLS];

/// A camera's order as it is written: from the picture of that number on it looks for these balls.
#[must_use]
pub(super) fn message(order: &Order, from: u32, time_us: u64) -> msg::Taught {
    let balls = balls_message(&order.balls, &[None; BALLS]);
    msg::Taught { frame: from, time_us, rigid: order.config.rigid, balls }
}

/// The order again, of a camera that tracks with `config`.
///
/// # Errors
/// What is missing, or not among what there can be.
pub(super) fn order_of(message: &msg::Taught, config: TrackerConfig) -> Result<Order, String> {
    let (balls, _) = balls_of(&message.balls)?;
    Ok(Order { balls, config: TrackerConfig { rigid: message.rigid, ..config } })
}

/// The arms of the hand that begins.
///
/// # Errors
/// What is missing, or no length that arms have.
pub(super) fn arms_of(message: &msg::HandBegins) -> Result<Arms, String> {
    let lengths = message.arms_m.as_slice();
    let three = lengths.try_into().map_err(|_| format!("arms have three lengths, not {}", lengths.len()))?;
    Arms::new(three).map_err(|error| format!("arms of {lengths:?} m: {error}"))
}

/// Balls as they are written: those that there are.
#[must_use]
pub(super) fn balls_message(balls: &Taught, places: &Places) -> Vec<msg::LearntBall> {
    let all = Ball::ALL.into_iter().zip(balls).zip(places);
    all.filter_map(|((ball, learnt), place)| Some(ball_message(ball, &(*learnt)?, *place))).collect()
}

/// And back, with their places.
///
/// # Errors
/// The ball that cannot be understood.
pub(super) fn balls_of(messages: &[msg::LearntBall]) -> Result<(Taught, Places), String> {
    let (mut balls, mut places) = ([None; BALLS], [None; BALLS]);
    for message in messages {
        let ball = ball_by_name(&message.ball)?;
        let learnt = ball_of(message).ok_or_else(|| format!("the {} ball has no colours", message.ball))?;
        balls[ball.index()] = Some(learnt);
        places[ball.index()] = message.place.map(|place| ImagePoint::new(place.u, place.v));
    }
    Ok((balls, places))
}

fn ball_message(ball: Ball, learnt: &LearntBall, place: Option<ImagePoint>) -> msg::LearntBall {
    let colour = |rgb: Rgb| Some(msg::Colour { r: rgb.r.into(), g: rgb.g.into(), b: rgb.b.into() });
    let Reference { primary, reference, typical, background } = learnt.reference;
    msg::LearntBall {
        ball: ball.name().to_owned(),
        primary: primary as u32,
        reference: colour(reference),
        typical: colour(typical),
        background: colour(background),
        diameter_px: learnt.diameter,
        aspect: learnt.aspect,
        place: place.map(|place| msg::Place { u: place.u, v: place.v }),
    }
}

fn ball_of(message: &msg::LearntBall) -> Option<LearntBall> {
    let component = |value: u32| u8::try_from(value).ok();
    let colour = |colour: Option<msg::Colour>| {
        let colour = colour?;
        Some(Rgb::new(component(colour.r)?, component(colour.g)?, component(colour.b)?))
    };
    let primary = Primary::ALL.into_iter().find(|primary| *primary as u32 == message.primary)?;
    let reference = Reference {
        primary,
        reference: colour(message.reference)?,
        typical: colour(message.typical)?,
        background: colour(message.background)?,
    };
    Some(LearntBall { reference, diameter: message.diameter_px, aspect: message.aspect })
}

#[cfg(test)]
mod tests {
    use super::*;
    use prost::Message as _;

    const GREEN: LearntBall = LearntBall {
        reference: Reference {
            primary: Primary::Green,
            reference: Rgb::new(3, 240, 250),
            typical: Rgb::new(30, 190, 200),
            background: Rgb::new(255, 128, 0),
        },
        diameter: 12.0 + 1.0 / 3.0,
        aspect: 1.1,
    };

    fn order() -> Order {
        let config = TrackerConfig { rigid: false, ..TrackerConfig::paper() };
        Order { balls: [None, Some(GREEN), None, None], config }
    }

    #[test]
    fn an_order_comes_back_to_the_bit() {
        for rigid in [false, true] {
            let order = Order { config: TrackerConfig { rigid, ..order().config }, ..order() };
            let bytes = message(&order, 7, 9).encode_to_vec();
            let back = msg::Taught::decode(bytes.as_slice()).unwrap();
            assert_eq!((back.frame, back.time_us), (7, 9));
            // whether it is a rigid frame is the order's, all else the camera's
            assert_eq!(order_of(&back, TrackerConfig::paper()).unwrap(), order);
        }
    }

    #[test]
    fn what_cannot_be_understood_is_named() {
        let mut pink = message(&order(), 7, 9);
        pink.balls[0].ball = "pink".to_owned();
        assert!(order_of(&pink, TrackerConfig::paper()).unwrap_err().contains("no ball `pink`"));
        let arms = |arms_m: &[f32]| {
            arms_of(&msg::HandBegins { arms_m: arms_m.to_vec(), ..msg::HandBegins::default() })
        };
        assert_eq!(arms(&[0.08, 0.09, 0.1]).unwrap().lengths_m(), [0.08, 0.09, 0.1]);
        assert!(arms(&[0.08]).unwrap_err().contains("three lengths, not 1"));
        assert!(arms(&[0.08, -0.08, 0.08]).unwrap_err().starts_with("arms of [0.08, -0.08, 0.08] m: "));
    }
}
