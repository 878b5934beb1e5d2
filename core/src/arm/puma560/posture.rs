//! How the arm stands: the three choices that a pose leaves open, and how far the arm is from where
//! they meet.
//!
//! The determinant of the Jacobian is the product of four lengths that never cancel each other:
//! `det J = a2 * sin(q5) * (d4 cos(q3) + a3 sin(q3)) * (a2 cos(q2) + a3 cos(q2 + q3) - d4 sin(q2 + q3))`.
//! Each factor is 0 at one kind of singularity, and its sign tells one of the three choices.

use super::model::{Joints, Puma560};
use crate::real::Real;

/// Roots of the unit of rounding by which the elbow's and the shoulder's factor may be off, metres:
/// 0.06 micrometres in f64, 1.4 mm in f32. Lengths err by about one unit, the factor by one root of
/// that; four leave some room.
const ROOTS: f64 = 4.0;

/// On which side of the shoulder the arm is, seen along the upper arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Shoulder {
    /// A right arm: the shoulder's factor is positive.
    Right,
    /// A left arm.
    Left,
}

/// Whether the elbow is above or below the line from shoulder to wrist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Elbow {
    /// Above.
    Up,
    /// Below.
    Down,
}

/// Which of the two ways the wrist is bent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Wrist {
    /// sin(q5) is negative.
    NoFlip,
    /// sin(q5) is positive.
    Flip,
}

/// One of the eight postures that bring the tool to one pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Configuration {
    /// Right or left.
    pub shoulder: Shoulder,
    /// Up or down.
    pub elbow: Elbow,
    /// No-flip or flip.
    pub wrist: Wrist,
}

/// A place where two postures meet and the tool cannot move in some direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Singularity {
    /// The axes of joints 4 and 6 are in line: only the sum of both angles counts.
    Wrist,
    /// The arm is stretched or folded.
    Elbow,
    /// The wrist centre is beside the first axis, as near as the shoulder's offset allows.
    Shoulder,
}

/// How far the arm is from each singularity: the factors of det J. Signs tell the posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularities<T> {
    /// sin(q5), from -1 to 1.
    pub wrist: T,
    /// d4 cos(q3) + a3 sin(q3): how far the wrist centre is from the upper arm's line, metres.
    pub elbow_m: T,
    /// a2 cos(q2) + a3 cos(q2 + q3) - d4 sin(q2 + q3): how far the wrist centre is from the plane
    /// through the first two axes, metres.
    pub shoulder_m: T,
}

/// The signs of the three factors: true is positive.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Signs {
    pub(super) wrist: bool,
    pub(super) elbow: bool,
    pub(super) shoulder: bool,
}

impl Configuration {
    /// All eight, in the order of [`super::Solutions`].
    pub const ALL: [Self; 8] = {
        use {Elbow::*, Shoulder::*, Wrist::*};
        const fn of(shoulder: Shoulder, elbow: Elbow, wrist: Wrist) -> Configuration {
            Configuration { shoulder, elbow, wrist }
        }
        [
            of(Right, Up, NoFlip),
            of(Right, Up, Flip),
            of(Right, Down, NoFlip),
            of(Right, Down, Flip),
            of(Left, Up, NoFlip),
            of(Left, Up, Flip),
            of(Left, Down, NoFlip),
            of(Left, Down, Flip),
        ]
    };

    /// Three letters as the Robotics Toolbox writes them: `run` is right, up, no-flip.
    #[must_use]
    pub const fn code(self) -> &'static str {
        match (self.shoulder, self.elbow, self.wrist) {
            (Shoulder::Right, Elbow::Up, Wrist::NoFlip) => "run",
            (Shoulder::Right, Elbow::Up, Wrist::Flip) => "ruf",
            (Shoulder::Right, Elbow::Down, Wrist::NoFlip) => "rdn",
            (Shoulder::Right, Elbow::Down, Wrist::Flip) => "rdf",
            (Shoulder::Left, Elbow::Up, Wrist::NoFlip) => "lun",
            (Shoulder::Left, Elbow::Up, Wrist::Flip) => "luf",
            (Shoulder::Left, Elbow::Down, Wrist::NoFlip) => "ldn",
            (Shoulder::Left, Elbow::Down, Wrist::Flip) => "ldf",
        }
    }

    pub(super) fn of_signs(signs: Signs) -> Self {
        Self {
            shoulder: if signs.shoulder { Shoulder::Right } else { Shoulder::Left },
            // a left arm is a right arm turned over
            elbow: if signs.elbow == signs.shoulder { Elbow::Down } else { Elbow::Up },
            wrist: if signs.wrist { Wrist::Flip } else { Wrist::NoFlip },
        }
    }

    pub(super) fn signs(self) -> Signs {
        let shoulder = self.shoulder == Shoulder::Right;
        Signs { wrist: self.wrist == Wrist::Flip, elbow: (self.elbow == Elbow::Down) == shoulder, shoulder }
    }
}

impl<T: Real> Singularities<T> {
    /// The posture they tell. A factor that rounding cannot tell from 0 tells nothing: there the arm
    /// stands as it did `before`.
    ///
    /// Solved from a pose, the wrist's factor is as exact as the pose. The elbow's and the shoulder's
    /// are square roots of what is left of a length: at the singularity itself they are as large as
    /// the root of its rounding.
    #[must_use]
    pub fn configuration(&self, before: Configuration) -> Configuration {
        let root = T::EPSILON.sqrt() * T::of(ROOTS);
        let before = before.signs();
        let positive = |factor: T, slack: T, before: bool| {
            if factor.abs() <= slack { before } else { factor > T::zero() }
        };
        Configuration::of_signs(Signs {
            wrist: positive(self.wrist, T::SLACK, before.wrist),
            elbow: positive(self.elbow_m, root, before.elbow),
            shoulder: positive(self.shoulder_m, root, before.shoulder),
        })
    }
}

impl<T: Real> Puma560<T> {
    /// How far the arm is from each singularity.
    #[must_use]
    pub fn singularities(&self, joints: &Joints<T>) -> Singularities<T> {
        let [_, q2, q3, _, q5, _] = *joints;
        let of = &self.geometry;
        let (s3, c3) = q3.sin_cos();
        let (s23, c23) = (q2 + q3).sin_cos();
        Singularities {
            wrist: q5.sin(),
            elbow_m: of.forearm * c3 + of.elbow * s3,
            shoulder_m: of.upper_arm * q2.cos() + of.elbow * c23 - of.forearm * s23,
        }
    }

    /// det J, m^3: how far the arm is from any singularity.
    #[must_use]
    pub fn determinant(&self, at: &Singularities<T>) -> T {
        self.geometry.upper_arm * at.wrist * at.elbow_m * at.shoulder_m
    }

    /// The singularity that is nearest, and how near: each factor's size as a share of the largest
    /// it can have, so 0 is at the singularity and 1 farthest from it.
    #[must_use]
    pub fn nearest_singularity(&self, at: &Singularities<T>) -> (Singularity, T) {
        let wrist = (Singularity::Wrist, at.wrist.abs());
        let elbow = (Singularity::Elbow, at.elbow_m.abs() / self.geometry.lower_arm);
        let shoulder = (Singularity::Shoulder, at.shoulder_m.abs() / self.reach());
        let nearer = |a: (Singularity, T), b: (Singularity, T)| if b.1 < a.1 { b } else { a };
        nearer(nearer(wrist, elbow), shoulder)
    }

    /// How the arm stands; at an exact singularity as right, up or no-flip.
    #[must_use]
    pub fn configuration(&self, joints: &Joints<T>) -> Configuration {
        let [first, ..] = Configuration::ALL;
        self.singularities(joints).configuration(first)
    }
}
