//! The twelve parameters of the hand's motion, frame by frame (section 4), and what they add up to.
//!
//! `paper` mode: every complete frame is solved against the last complete one. A frame in which
//! too few balls were measured is refused with a reason and changes nothing: the reference R(t)
//! stays, so the next complete frame's increment spans the gap and no motion is lost.

use crate::config::{HandConfig, MAX_VIEWS};
use crate::geometry::{ImagePoint, Pose};
use crate::hand::affine::{AffineFrame, AffineRefusal, AffineView, Arms, Centres};
use crate::hand::orientation::{OrientationRefusal, gram_schmidt, nearest_rotation_step};
use crate::observation::{BALLS, Ball, Observations};
use nalgebra::{Matrix3, Vector3};

#[cfg(test)]
mod tests;

/// One frame's motion of the hand. Every pose solver of the hand gives this type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The origin of R(t+1) in R(t), metres.
    pub alpha: Vector3<f32>,
    /// The rotation R(t)_from_R(t+1).
    pub phi: Matrix3<f32>,
    /// engage_from_now: where the hand is, in the feature frame latched by the last engage (before
    /// the first one: in the first complete frame).
    pub since_engage: Pose,
    /// How many times the hand was latched; where it changes, `since_engage` is the identity and
    /// the increment is from before the latch.
    pub engagements: u32,
    /// The root mean square of measured minus projected over all balls and views, px.
    pub residual_px: f32,
    /// How many frames the increment spans: 0 for the first complete frame, which has nothing to
    /// be compared with, 1 for consecutive frames, more where frames between were refused.
    pub spans: u32,
}

impl Motion {
    /// alpha and Phi as one motion, R(t)_from_R(t+1).
    #[must_use]
    pub const fn increment(&self) -> Pose {
        Pose { rotation: self.phi, translation: self.alpha }
    }
}

/// Why a frame gives no motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MotionRefusal {
    /// Fewer than two views show all four balls; the first ball that is missing.
    BallMissing {
        /// The view's place in the list.
        view: u8,
        /// The ball that was not measured in it.
        ball: Ball,
    },
    /// Two views or more are complete, but fewer than two of them were so in the reference frame.
    NoSharedViews,
    /// No place of the hand goes with what the views show.
    Inconsistent,
    /// The places of the balls could not be solved.
    Affine(AffineRefusal),
    /// The places of the balls make no feature frame.
    Orientation(OrientationRefusal),
}

impl core::fmt::Display for MotionRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::BallMissing { view, ball } => {
                write!(f, "the {} ball was not measured in view {view}", ball.name())
            }
            Self::NoSharedViews => {
                f.write_str("fewer than two views are complete both now and in the reference frame")
            }
            Self::Inconsistent => f.write_str("no place of the hand goes with what the views show"),
            Self::Affine(reason) => reason.fmt(f),
            Self::Orientation(reason) => reason.fmt(f),
        }
    }
}

impl core::error::Error for MotionRefusal {}

impl From<AffineRefusal> for MotionRefusal {
    fn from(reason: AffineRefusal) -> Self {
        Self::Affine(reason)
    }
}

impl From<OrientationRefusal> for MotionRefusal {
    fn from(reason: OrientationRefusal) -> Self {
        Self::Orientation(reason)
    }
}

/// The four centres in each view that showed all of them.
type Views = [Option<Centres>; MAX_VIEWS];

/// One increment R(t)_from_R(t+1).
#[derive(Clone, Copy, Debug)]
struct Increment {
    motion: Pose,
    spans: u32,
}

/// `paper` mode: frame-to-frame affine motion, added up since engage.
#[derive(Clone, Debug)]
pub struct MotionTracker {
    arms: Arms,
    config: HandConfig,
    /// R(t): the last complete frame.
    reference: Option<Views>,
    last: Increment,
    /// Frames refused since the reference.
    refused: u32,
    since_engage: Pose,
    engagements: u32,
    latch_at_next: bool,
}

impl MotionTracker {
    /// A tracker of a feature frame with these arms, which has seen nothing yet.
    #[must_use]
    pub fn new(arms: Arms, config: HandConfig) -> Self {
        Self {
            arms,
            config,
            reference: None,
            last: Increment { motion: Pose::identity(), spans: 1 },
            refused: 0,
            since_engage: Pose::identity(),
            engagements: 0,
            latch_at_next: false,
        }
    }

    /// Latches the hand: from here on `since_engage` is told from where the hand is now.
    ///
    /// Where the hand is not seen now, the latch waits for the next complete frame, so that motion
    /// made unseen before it cannot move the arm.
    pub fn engage(&mut self) {
        if self.reference.is_some() && self.refused == 0 {
            self.latch();
        } else {
            self.latch_at_next = true;
        }
    }

    /// Forgets the reference and the pose, as after the cameras were moved; `engagements` counts on.
    pub fn restart(&mut self) {
        *self = Self { engagements: self.engagements, ..Self::new(self.arms, self.config) };
    }

    /// engage_from_now of the last complete frame.
    #[must_use]
    pub const fn since_engage(&self) -> &Pose {
        &self.since_engage
    }

    /// How many times the hand was latched.
    #[must_use]
    pub const fn engagements(&self) -> u32 {
        self.engagements
    }

    /// Takes one frame: what each camera saw of the four balls, in the same order of cameras every
    /// time. Views that do not show all four (visible or occluded) are left out; two must remain.
    ///
    /// # Errors
    /// [`MotionRefusal`]; the reference and the pose stay as they were.
    pub fn update(&mut self, views: &[Observations]) -> Result<Motion, MotionRefusal> {
        let solved = self.solve(views);
        if solved.is_err() {
            self.refused = self.refused.saturating_add(1);
        }
        solved
    }

    /// Where the camera `view` is expected to see the four balls in the next frame if the hand moves
    /// as it did last (section 3.5), px; None for a view that was not complete in the reference,
    /// and for all when that was too long ago.
    ///
    /// For consecutive frames this is `x_k(t+1) = x_0(t) + M(t) (alpha + Phi l_k E_k)`. Over refused
    /// frames each ball is carried on in a straight line at its speed in the last increment.
    #[must_use]
    pub fn predict(&self, view: usize) -> [Option<ImagePoint>; BALLS] {
        let centres = self.reference.as_ref().and_then(|views| views.get(view)).and_then(Option::as_ref);
        let (Some(centres), true) = (centres, self.refused < self.config.max_predicted_frames) else {
            return [None; BALLS];
        };
        let view = AffineView::new(centres, self.arms);
        let frames = (self.refused as f32 + 1.0) / self.last.spans as f32;
        self.arms.balls_in_frame().map(|ball| {
            let moved = self.last.motion.rotation * ball + self.last.motion.translation;
            let point = view.project(&(ball + (moved - ball) * frames));
            point.is_finite().then_some(point)
        })
    }

    fn latch(&mut self) {
        self.since_engage = Pose::identity();
        self.engagements = self.engagements.wrapping_add(1);
        self.latch_at_next = false;
    }

    fn solve(&mut self, views: &[Observations]) -> Result<Motion, MotionRefusal> {
        let now = complete_views(views)?;
        let (increment, residual_px) = match &self.reference {
            Some(reference) => self.increment(reference, &now)?,
            None => (Increment { motion: Pose::identity(), spans: 0 }, 0.0),
        };
        // a frame that cannot serve as the next reference is refused before it changes anything
        AffineFrame::new(&seen(&now), self.arms, &self.config)?;
        let since_engage = advance(&self.since_engage, &increment.motion);
        if since_engage.translation.iter().chain(since_engage.rotation.iter()).any(|x| !x.is_finite()) {
            return Err(AffineRefusal::NotFinite.into());
        }

        self.reference = Some(now);
        self.refused = 0;
        self.last = Increment { spans: increment.spans.max(1), ..increment };
        self.since_engage = since_engage;
        if self.latch_at_next {
            self.latch();
        }
        Ok(Motion {
            alpha: increment.motion.translation,
            phi: increment.motion.rotation,
            since_engage: self.since_engage,
            engagements: self.engagements,
            residual_px,
            spans: increment.spans,
        })
    }

    /// R(t)_from_R(t+1) and the residual in px, from the views complete in both.
    fn increment(&self, reference: &Views, now: &Views) -> Result<(Increment, f32), MotionRefusal> {
        let mut before = heapless::Vec::<Centres, MAX_VIEWS>::new();
        let mut after = heapless::Vec::<Centres, MAX_VIEWS>::new();
        for (was, is) in reference.iter().zip(now) {
            if let (Some(was), Some(is)) = (was, is) {
                // both have room for every view
                let _ = (before.push(*was), after.push(*is));
            }
        }
        if before.len() < 2 {
            return Err(MotionRefusal::NoSharedViews);
        }
        let frame = AffineFrame::new(&before, self.arms, &self.config)?;
        let mut places = [Vector3::zeros(); BALLS];
        let mut mean_square = 0.0;
        for (ball, place) in places.iter_mut().enumerate() {
            let points: heapless::Vec<ImagePoint, MAX_VIEWS> = points_of(ball, &after);
            let located = frame.locate(&points)?;
            *place = located.alpha;
            mean_square += located.residual_px * located.residual_px / BALLS as f32;
        }
        let [origin, ends @ ..] = places;
        let rotation = gram_schmidt(&ends.map(|end| end - origin), &self.config)?;
        let motion = Pose { rotation, translation: origin };
        Ok((Increment { motion, spans: self.refused.saturating_add(1) }, libm::sqrtf(mean_square)))
    }
}

/// X(t+1) = X(t) + R(t) alpha and R(t+1) = R(t) Phi, kept a rotation.
fn advance(pose: &Pose, increment: &Pose) -> Pose {
    let next = pose.compose(increment);
    Pose { rotation: nearest_rotation_step(&next.rotation), ..next }
}

/// The views that show all four balls; refused where fewer than two do.
fn complete_views(views: &[Observations]) -> Result<Views, MotionRefusal> {
    if views.len() < 2 {
        return Err(AffineRefusal::TooFewViews.into());
    }
    if views.len() > MAX_VIEWS {
        return Err(AffineRefusal::TooManyViews.into());
    }
    let mut complete: Views = [None; MAX_VIEWS];
    let mut count = 0;
    let mut missing = None;
    for ((view, observations), slot) in (0_u8..).zip(views).zip(&mut complete) {
        match Ball::ALL.into_iter().zip(observations).find(|(_, seen)| !seen.state.is_measured()) {
            Some((ball, _)) => missing = missing.or(Some(MotionRefusal::BallMissing { view, ball })),
            None => {
                *slot = Some(observations.map(|observation| observation.centre));
                count += 1;
            }
        }
    }
    match missing {
        Some(refusal) if count < 2 => Err(refusal),
        _ => Ok(complete),
    }
}

/// The complete views without their places in the list.
fn seen(views: &Views) -> heapless::Vec<Centres, MAX_VIEWS> {
    let mut seen = heapless::Vec::new();
    for centres in views.iter().flatten() {
        // has room for every view
        let _ = seen.push(*centres);
    }
    seen
}

/// One ball's centre in each view.
fn points_of(ball: usize, views: &[Centres]) -> heapless::Vec<ImagePoint, MAX_VIEWS> {
    let mut points = heapless::Vec::new();
    for centre in views.iter().filter_map(|centres| centres.get(ball)) {
        // has room for every view
        let _ = points.push(*centre);
    }
    points
}
