//! A way round: where the joints' way to the goal is barred by the workspace, by way of other joints.
//!
//! Straight in the joints the tool swings out; held at a face, it may come to stand where all that would
//! bring it nearer leads out. Then the arm is folded or raised first: of a grid of places of the upper
//! arm and the forearm the one is taken by way of which the tool keeps best to the workspace.

use super::axis::Span;
use super::goal::Bounded;
use super::way::{Kind, Way};
use crate::arm::puma560::{Configuration, Joints, Puma560};
use crate::config::JOINTS;
use crate::real::Real;

/// In so many parts the ranges of joints 2 and 3 are divided: the places that are tried are between them,
/// and in every other round the ends: with its elbow folded most the arm has room to turn over.
const PLACES: u8 = 6;

/// How far from the ends that is, radians.
const KEPT_FROM_ENDS_RAD: f64 = 0.02;

/// So far joint 5 is turned for the tool to stand aside, radians: a tool in line with the forearm takes
/// the most room below and above a folded arm.
const ASIDE_RAD: f64 = 1.2;

/// Where the tool is looked for on each of both halves.
const LOOKS: u8 = 8;

/// How far from the faces that way should keep, metres.
const KEPT_FROM_FACES_M: f64 = 0.02;

/// How many metres nearer, on the whole way, weigh as much as a radian more of way.
const METRES_PER_RADIAN: f64 = 0.004;

/// When no joint has farther to go to where the way leads round, it goes on from there, radians.
const ROUND_RAD: f64 = 0.15;

/// What counts as coming nearer, radians, all joints together.
const NEARER_RAD: f64 = 0.02;

/// For so long the tool is at a face and comes no nearer before a way round is looked for, seconds.
const PATIENCE_S: f64 = 0.3;

/// So many ways round are looked for.
const MOST_TRIED: u8 = 60;

/// After so long another way round is looked for, seconds.
const LONGEST_S: f64 = 4.0;

/// How the joints' way gets on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Detour<T> {
    /// By way of here.
    pub(super) via: Option<Joints<T>>,
    /// What was left when it last came nearer, radians.
    nearest: T,
    waited: T,
    /// For how long it has gone round, seconds.
    age: T,
    /// How many ways round were looked for.
    tried: u8,
}

impl<T: Real> Detour<T> {
    pub(super) fn none() -> Self {
        Self { via: None, nearest: T::zero(), waited: T::zero(), age: T::zero(), tried: 0 }
    }

    /// Whether a way round is to be looked for, after one more cycle.
    pub(super) fn is_due(&mut self, way: &Way<T>, at_face: bool, cycle: T) -> bool {
        if way.kind != Kind::ByJoints {
            *self = Self::none();
            return false;
        }
        if self.via.is_some() && way.left.iter().all(|left| left.abs() <= T::of(ROUND_RAD)) {
            *self = Self { tried: self.tried, ..Self::none() };
        }
        let left = way.left.iter().fold(T::zero(), |sum, left| sum + left.abs());
        let nearer = T::of(NEARER_RAD);
        // also where the goal has moved away
        if (left - self.nearest).abs() >= nearer {
            (self.nearest, self.waited) = (left, T::zero());
        } else if at_face {
            self.waited += cycle;
        }
        if self.via.is_some() {
            self.age += cycle;
        }
        if self.waited < T::of(PATIENCE_S) && self.age < T::of(LONGEST_S) {
            return false;
        }
        *self = Self { tried: self.tried.saturating_add(1), ..Self::none() };
        true
    }

    /// The tool has come to rest on this way: another one is due. Whether there is any left.
    pub(super) fn hurry(&mut self) -> bool {
        self.waited = T::of(PATIENCE_S);
        self.tried < MOST_TRIED
    }

    /// The goal is another one.
    pub(super) fn try_again(&mut self) {
        if self.tried >= MOST_TRIED {
            self.tried = 0;
        }
    }

    /// How often each of [`Self::turned`] has been tried before.
    pub(super) const fn round(&self) -> u8 {
        self.tried.saturating_sub(1) / 3
    }

    /// Which of the ways round is to be looked for: one that failed is not taken again.
    pub(super) fn turned(&self) -> T {
        T::of(match self.tried % 3 {
            1 => 0.5,
            2 => 0.0,
            _ => 1.0,
        })
    }
}

/// What a way round has to keep to.
pub(super) struct Around<'a, T> {
    pub(super) arm: &'a Puma560<T>,
    pub(super) edges: &'a Bounded<T>,
    pub(super) ranges: &'a [Span<T>; JOINTS],
    pub(super) posture: Configuration,
    /// How much of their way the other joints shall have gone there, a share.
    pub(super) turned: T,
    /// How often all shares have been tried.
    pub(super) round: u8,
}

impl<T: Real> Around<'_, T> {
    /// By way of which joints to go.
    pub(super) fn via(&self, from: &Joints<T>, to: &Joints<T>) -> Option<Joints<T>> {
        let middle = between(from, to, self.turned);
        let [_, upper_arm, forearm, _, wrist, _] = self.ranges;
        let mut best = None;
        let mut least = T::of(1e9);
        // at first between the ends and with the wrist as it is
        let (round, to_the_ends) = (self.round / 2, self.round % 2 == 1);
        let (least_place, places) = if to_the_ends { (0, PLACES) } else { (1, PLACES - 1) };
        for i in least_place..=places {
            for k in least_place..=places {
                // what failed in one round is left out in one of the next
                if !round.is_multiple_of(4) && (i + k + round).is_multiple_of(3) {
                    continue;
                }
                let [q1, _, _, q4, q5, q6] = middle;
                let q5 = if to_the_ends { aside(q5, wrist) } else { q5 };
                let via = [q1, place(upper_arm, i), place(forearm, k), q4, q5, q6];
                let stands = self.arm.configuration(&via);
                if stands.elbow != self.posture.elbow || stands.shoulder != self.posture.shoulder {
                    continue;
                }
                let cost = self.cost(from, &via, least);
                let cost = cost + self.cost(to, &via, least - cost);
                if cost < least {
                    (best, least) = (Some(via), cost);
                }
            }
        }
        best
    }

    /// The way and how far it leads out, radians; given up where it comes to more than `most`.
    fn cost(&self, from: &Joints<T>, to: &Joints<T>, most: T) -> T {
        let way = from.iter().zip(to).fold(T::zero(), |way, (from, to)| way.max((*to - *from).abs()));
        let weight = T::of(METRES_PER_RADIAN) * T::of(f64::from(LOOKS));
        let mut out = T::zero();
        for look in 1..=LOOKS {
            let share = T::of(f64::from(look) / f64::from(LOOKS));
            let place = self.arm.forward(&between(from, to, share)).translation;
            let sides = self.edges.min.iter().zip(self.edges.max.iter());
            for (x, (min, max)) in place.iter().zip(sides) {
                let keep = T::of(KEPT_FROM_FACES_M).min((*max - *min) * T::of(0.25));
                out += (*min + keep - *x).max(*x + keep - *max).max(T::zero());
            }
            if way + out / weight >= most {
                break;
            }
        }
        way + out / weight
    }
}

fn place<T: Real>(range: &Span<T>, number: u8) -> T {
    let end = T::of(KEPT_FROM_ENDS_RAD);
    let place = range.min + (range.max - range.min) * T::of(f64::from(number) / f64::from(PLACES));
    place.max(range.min + end).min(range.max - end)
}

fn aside<T: Real>(q5: T, range: &Span<T>) -> T {
    let most = T::of(ASIDE_RAD);
    if q5 < T::zero() { (-most).max(range.min) } else { most.min(range.max) }
}

fn between<T: Real>(from: &Joints<T>, to: &Joints<T>, share: T) -> Joints<T> {
    let mut joints = *from;
    for (joint, to) in joints.iter_mut().zip(to) {
        *joint += (*to - *joint) * share;
    }
    joints
}
