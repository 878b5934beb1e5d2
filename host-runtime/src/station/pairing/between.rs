//! Where a camera's balls were between two of its pictures.

use super::Sighting;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{ImageCovariance, Observation, ObservationState, Observations};

/// The four balls at `t_us`, on the straight way from where they were in one picture to where they are
/// in the next; `before` is the picture before the first, if there is one.
///
/// With the share s of the way, the covariance of a centre is the two pictures', weighed (1 - s)² and
/// s², and what the straight way leaves out: with the acceleration a, as the three pictures show it,
/// and the time h between the two, the ball is a h² s (1 - s) / 2 beside it.
///
/// A ball is known as badly as it is in the worse of the two; one that is lost in either is lost.
#[must_use]
pub fn between(before: Option<&Sighting>, first: &Sighting, last: &Sighting, t_us: u64) -> Observations {
    let seconds = |from: u64, to: u64| to.saturating_sub(from) as f32 * 1e-6;
    let span_s = seconds(first.capture_us, last.capture_us);
    let share = if span_s > 0.0 { seconds(first.capture_us, t_us) / span_s } else { 1.0 };
    let mut balls = Observations::default();
    for (at, ball) in balls.iter_mut().enumerate() {
        let (Some(a), Some(b)) = (first.balls.get(at), last.balls.get(at)) else { continue };
        let earlier = before.and_then(|before| Some((before.balls.get(at)?, before.capture_us)));
        let bend = earlier
            .filter(|(ball, _)| [ball, a, b].iter().all(|ball| ball.state.is_measured()))
            .map_or_else(ImagePoint::default, |(ball, capture_us)| {
                let before_s = seconds(capture_us, first.capture_us);
                let (was, is) =
                    ((a.centre - ball.centre) * before_s.recip(), (b.centre - a.centre) * span_s.recip());
                let acceleration = (is - was) * (2.0 / (before_s + span_s));
                acceleration * (span_s * span_s * share * (1.0 - share) / 2.0)
            });
        *ball = ball_between(a, b, share, bend);
    }
    balls
}

fn ball_between(a: &Observation, b: &Observation, share: f32, bend: ImagePoint) -> Observation {
    let state = worse(a.state, b.state);
    let diameter = a.diameter + (b.diameter - a.diameter) * share;
    if state == ObservationState::Lost {
        return Observation { diameter, ..Observation::default() };
    }
    let (wa, wb) = ((1.0 - share) * (1.0 - share), share * share);
    let mix = |x: f32, y: f32, bend: f32| wa * x + wb * y + bend;
    let (p, q) = (a.covariance, b.covariance);
    Observation {
        state,
        centre: a.centre + (b.centre - a.centre) * share,
        diameter,
        covariance: ImageCovariance {
            uu: mix(p.uu, q.uu, bend.u * bend.u),
            uv: mix(p.uv, q.uv, bend.u * bend.v),
            vv: mix(p.vv, q.vv, bend.v * bend.v),
        },
        visible: a.visible.min(b.visible),
    }
}

const fn worse(a: ObservationState, b: ObservationState) -> ObservationState {
    if a as u8 > b as u8 { a } else { b }
}
