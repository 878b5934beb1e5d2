//! From the hand to the goal.
//!
//! ```text
//! goal place     = start + scale C (hand now - hand at latch)       scale: as it was at the press
//! goal rotation  = C (R now  R at latch^T) C^T  start            C = robot_from_hand
//! ```
//!
//! Both motions are told in the hand's axes at engage (in which the sender tells them) and turned
//! into the robot's by one fixed rotation; where the tool happens to point does not matter. Nothing is
//! added up: the goal depends on where the hand is, not on which commands came.
//!
//! Where the goal may not go further (the box, the lead over the arm) the hand slips: the latch moves
//! along, so that the way back begins at once. Only there does the goal depend on the way. The lead
//! and the box are convex sets around the goal before, so the goal never steps further than the hand.

use super::command::nearest_rotation;
use super::decision::Uncertainty;
use super::status::{Note, Notes};
use crate::config::{BelievedMotion, TeleopConfig, Turning};
use crate::geometry::Pose;
use crate::hand::so3;
use crate::hand::state::PoseCovariance;
use crate::real::Real;
use crate::wire::ScaleShare;
use nalgebra::{Matrix3, Vector3};

/// With a scale on turns, the latch moves along beyond this angle, radians: towards half a turn the
/// axis of a rotation becomes uncertain, and a scaled one would jump.
const MAX_SCALED_TURN_RAD: f64 = 2.6;

/// The settings of the law in the precision of choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Law<T> {
    scale: T,
    /// `None` where the tool keeps its orientation.
    turn_scale: Option<T>,
    robot_from_hand: Matrix3<T>,
    min: Vector3<T>,
    max: Vector3<T>,
    max_lead: T,
    max_turn_lead: T,
    believed: BelievedMotion,
}

/// Where hand and set-point were latched, and what came of it so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Follow<T> {
    /// The hand at the latch, and where the goal is then. The two places, and the two rotations,
    /// belong together; where something slips only its own pair moves.
    hand: Pose<T>,
    start: Pose<T>,
    /// Where the hand was last followed to, and the goal then.
    last: Pose<T>,
    goal: Pose<T>,
    /// Metres of the tool for one of the hand.
    scale: T,
}

impl<T: Real> Follow<T> {
    /// The hand at `hand` leaves the goal at `start`, and moves it by this scale from there.
    pub(super) const fn latched(hand: Pose<T>, start: Pose<T>, scale: T) -> Self {
        Self { hand, start, last: hand, goal: start, scale }
    }

    pub(super) const fn goal(&self) -> &Pose<T> {
        &self.goal
    }

    /// `paper` mode, which adds up: the goal by itself, and where the hand was then.
    pub(super) const fn step_to(&mut self, hand: Pose<T>, goal: Pose<T>) {
        self.last = hand;
        self.goal = goal;
    }

    pub(super) const fn last(&self) -> &Pose<T> {
        &self.last
    }
}

impl<T: Real> Law<T> {
    pub(super) fn new(config: &TeleopConfig) -> Self {
        let box_corner = |corner: [f64; 3]| Vector3::from(corner.map(T::of));
        Self {
            scale: T::of(config.scale),
            turn_scale: match config.turning {
                Turning::Scaled(scale) => Some(T::of(scale)),
                Turning::Locked => None,
            },
            robot_from_hand: config.robot_from_hand.map(T::of),
            min: box_corner(config.workspace.min_m),
            max: box_corner(config.workspace.max_m),
            max_lead: T::of(config.max_lead_m),
            max_turn_lead: T::of(config.max_lead_rad),
            believed: config.believed,
        }
    }

    /// Metres of the tool for one of the hand, by this share of the most.
    pub(super) fn scale(&self, share: ScaleShare) -> T {
        // all of it is that, to the bit
        if share == ScaleShare::FULL {
            self.scale
        } else {
            self.scale * T::of(f64::from(share.percent()) * 0.01)
        }
    }

    /// How well the goal is known where the hand is known so well, and followed by this scale.
    pub(super) fn uncertainty(&self, p: &PoseCovariance, scale: T) -> Uncertainty<T> {
        let deviation = |variance: f32| T::of(f64::from(libm::sqrtf(variance.max(0.0))));
        Uncertainty {
            place_m: deviation(p.m11 + p.m22 + p.m33) * scale,
            turn_rad: deviation(p.m44 + p.m55 + p.m66) * self.turn_scale.unwrap_or_else(T::zero),
        }
    }

    /// Whether a hand can have moved so in `gap_us` microseconds (see [`BelievedMotion`]).
    pub(super) fn believes(&self, from: &Pose<T>, to: &Pose<T>, gap_us: u64) -> bool {
        // a gap of over an hour is one of an hour
        let gap = T::of(f64::from(u32::try_from(gap_us).unwrap_or(u32::MAX)) * 1e-6);
        let b = &self.believed;
        let within = |moved: T, slack: f64, speed: f64, most: f64| {
            moved <= (T::of(slack) + T::of(speed) * gap).min(T::of(most))
        };
        within((to.translation - from.translation).norm(), b.slack_m, b.speed_m_s, b.most_m)
            && within(angle(&to.rotation, &from.rotation), b.slack_rad, b.speed_rad_s, b.most_rad)
    }

    /// Follows the hand to `hand`; `set_point` is where the arm was last sent.
    pub(super) fn follow(
        &self,
        follow: &mut Follow<T>,
        hand: &Pose<T>,
        set_point: &Pose<T>,
        notes: &mut Notes,
    ) {
        let asked = self.place(follow, hand);
        let place = self.limited_place(&asked, &follow.goal, set_point, notes);
        if place != asked {
            follow.hand.translation = hand.translation;
            follow.start.translation = place;
        }

        let turned = self.turned(follow, hand);
        let rotation = self.limited_rotation(&turned, &follow.goal, set_point, notes);
        if rotation != turned {
            follow.hand.rotation = hand.rotation;
            follow.start.rotation = rotation;
        }
        follow.last = *hand;
        follow.goal = Pose { rotation, translation: place };
    }

    /// Section 5 as printed, for one packet: X + alpha, M Phi.
    ///
    /// alpha is told in the hand's axes of the frame before, and added in the robot's: it is printed
    /// so. The box and the lead hold here too.
    pub(super) fn paper(
        &self,
        follow: &Follow<T>,
        measured: &Pose<T>,
        set_point: &Pose<T>,
        increment: &Pose<T>,
        notes: &mut Notes,
    ) -> Pose<T> {
        let goal = follow.goal();
        let place = measured.translation + self.robot_from_hand * increment.translation * follow.scale;
        let rotation = match self.turn_scale {
            None => goal.rotation,
            Some(_) if increment.rotation == Matrix3::identity() => measured.rotation,
            Some(scale) if scale == T::one() => nearest_rotation(&(measured.rotation * increment.rotation)),
            Some(scale) => {
                let phi = so3::exp(&(so3::log(&increment.rotation) * scale));
                nearest_rotation(&(measured.rotation * phi))
            }
        };
        Pose {
            translation: self.limited_place(&place, goal, set_point, notes),
            rotation: self.limited_rotation(&rotation, goal, set_point, notes),
        }
    }

    fn place(&self, follow: &Follow<T>, hand: &Pose<T>) -> Vector3<T> {
        let moved = hand.translation - follow.hand.translation;
        follow.start.translation + self.robot_from_hand * moved * follow.scale
    }

    fn turned(&self, follow: &mut Follow<T>, hand: &Pose<T>) -> Matrix3<T> {
        // a hand that has not turned turns nothing, to the bit
        let Some(scale) = self.turn_scale.filter(|_| hand.rotation != follow.hand.rotation) else {
            return follow.start.rotation;
        };
        let turn = hand.rotation * follow.hand.rotation.transpose();
        let turn = if scale == T::one() {
            turn
        } else {
            let mut vector = so3::log(&turn);
            if vector.norm() > T::of(MAX_SCALED_TURN_RAD) {
                follow.hand.rotation = follow.last.rotation;
                follow.start.rotation = follow.goal.rotation;
                vector = so3::log(&(hand.rotation * follow.last.rotation.transpose()));
            }
            so3::exp(&(vector * scale))
        };
        let c = &self.robot_from_hand;
        nearest_rotation(&(c * turn * c.transpose() * follow.start.rotation))
    }

    /// The place nearest to `place` that is in the box and not too far ahead of the set-point. Where
    /// `before` was out of either, that far out is allowed: nothing is pulled in, everything may
    /// come back.
    fn limited_place(
        &self,
        place: &Vector3<T>,
        before: &Pose<T>,
        set_point: &Pose<T>,
        notes: &mut Notes,
    ) -> Vector3<T> {
        let before = &before.translation;
        let lead = place - set_point.translation;
        let most = (before - set_point.translation).norm().max(self.max_lead);
        let length = lead.norm();
        let place = if length > most {
            notes.add(Note::AheadOfArm);
            set_point.translation + lead * (most / length)
        } else {
            *place
        };
        let least = self.min.zip_map(before, |min, before| min.min(before));
        let largest = self.max.zip_map(before, |max, before| max.max(before));
        let inside = place.zip_zip_map(&least, &largest, |x, least, largest| x.max(least).min(largest));
        if inside != place {
            notes.add(Note::WorkspaceEdge);
        }
        inside
    }

    /// The same for turns ahead of the set-point.
    fn limited_rotation(
        &self,
        rotation: &Matrix3<T>,
        before: &Pose<T>,
        set_point: &Pose<T>,
        notes: &mut Notes,
    ) -> Matrix3<T> {
        let lead = so3::log(&(rotation * set_point.rotation.transpose()));
        let most = angle(&before.rotation, &set_point.rotation).max(self.max_turn_lead);
        let length = lead.norm();
        if length > most {
            notes.add(Note::TurnedAheadOfArm);
            nearest_rotation(&(so3::exp(&(lead * (most / length))) * set_point.rotation))
        } else {
            *rotation
        }
    }
}

/// The angle between two orientations, radians.
pub(super) fn angle<T: Real>(a: &Matrix3<T>, b: &Matrix3<T>) -> T {
    so3::log(&(a * b.transpose())).norm()
}
