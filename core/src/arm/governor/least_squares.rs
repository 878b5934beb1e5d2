//! Damped least squares: towards a pose that the arm cannot quite reach.
//!
//! `dq = D J^T (J D J^T + damping^2)^-1 e`: without bounds near a singularity, where the plain inverse
//! has none. D leaves out the joints that are at an end of their range and would go beyond.

use super::axis::Span;
use super::goal::Left;
use crate::arm::puma560::{Jacobian, Joints};
use crate::config::JOINTS;
use crate::real::Real;
use nalgebra::{Cholesky, Matrix6, Vector6};

/// How many metres off the place weigh as much as one radian off the orientation: about the length
/// that swings with the forearm.
const METRES_PER_RADIAN: f64 = 0.3;

/// Relative to joints that move the tool by about a metre a radian: a direction in which they move it
/// by less than this is given up.
const DAMPING: f64 = 0.05;

/// What is left is taken in portions of at most so many metres.
const PORTION_M: f64 = 0.1;

/// How often joints at an end are left out anew. Each time one more at least.
const ROUNDS: usize = 3;

/// The way of the joints that lessens what is left most, within their spans.
pub(super) fn approach<T: Real>(
    jacobian: &Jacobian<T>,
    left: &Left<T>,
    joints: &Joints<T>,
    spans: &[Span<T>; JOINTS],
) -> Joints<T> {
    let weight = T::of(METRES_PER_RADIAN);
    let mut weighted = *jacobian;
    for mut column in weighted.column_iter_mut() {
        for turn in column.iter_mut().skip(3) {
            *turn *= weight;
        }
    }
    let (place, turn) = (left.place, left.turn * weight);
    let mut error = Vector6::new(place.x, place.y, place.z, turn.x, turn.y, turn.z);
    let (size, portion) = (error.norm(), T::of(PORTION_M));
    if size > portion {
        error *= portion / size;
    }
    let mut free = [true; JOINTS];
    let mut way = [T::zero(); JOINTS];
    for _ in 0..ROUNDS {
        way = solve(&weighted, &error, &free);
        let mut all_inside = true;
        for (((free, way), angle), span) in free.iter_mut().zip(&way).zip(joints).zip(spans) {
            let beyond = *angle + *way > span.max && *angle >= span.max - T::SLACK
                || *angle + *way < span.min && *angle <= span.min + T::SLACK;
            if *free && beyond {
                *free = false;
                all_inside = false;
            }
        }
        if all_inside {
            break;
        }
    }
    for ((way, angle), span) in way.iter_mut().zip(joints).zip(spans) {
        *way = (*angle + *way).max(span.min).min(span.max) - *angle;
    }
    way
}

fn solve<T: Real>(jacobian: &Jacobian<T>, error: &Vector6<T>, free: &[bool; JOINTS]) -> Joints<T> {
    let mut j = *jacobian;
    for (mut column, free) in j.column_iter_mut().zip(free) {
        if !free {
            column.fill(T::zero());
        }
    }
    let damping = Matrix6::identity() * T::of(DAMPING * DAMPING);
    match Cholesky::new(j * j.transpose() + damping) {
        Some(inverse) => {
            let way = j.tr_mul(&inverse.solve(error));
            [way.x, way.y, way.z, way.w, way.a, way.b]
        }
        // a matrix with its damping is positive definite unless it is not finite
        None => [T::zero(); JOINTS],
    }
}
