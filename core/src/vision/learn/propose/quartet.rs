//! Four balls that may be one feature frame: sizes alike, near each other, arms at right angles.

use crate::config::ProposeConfig;
use crate::geometry::ImagePoint;
use crate::observation::BALLS;
use heapless::Vec;

/// Candidates kept of each colour.
pub(super) const MAX_CANDIDATES: usize = 8;

/// Hypotheses kept of each view.
pub(super) const MAX_QUARTETS: usize = 4;

/// A ball that was learnt at a seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// Where it was learnt from: learning there again gives the same.
    pub(super) seed: ImagePoint,
    pub(super) centre: ImagePoint,
    pub(super) diameter: f32,
    /// How good a ball it is, 0 to 1.
    pub(super) quality: f32,
}

/// The candidates of the four colours in one view.
pub(super) type Candidates = [Vec<Candidate, MAX_CANDIDATES>; BALLS];

/// One candidate of each colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quartet {
    pub(super) balls: [Candidate; BALLS],
    /// How good a feature frame it is, 0 to 1.
    pub(super) score: f32,
    /// Length of an arm that lies flat in the picture, in ball diameters: alike in every view.
    pub(super) arm_diameters: f32,
}

/// The best quartets of one view, best first. Tries at most 8^4 combinations.
pub(super) fn best(candidates: &Candidates, config: &ProposeConfig) -> Vec<Quartet, MAX_QUARTETS> {
    let mut best: Vec<Quartet, MAX_QUARTETS> = Vec::new();
    let [reds, greens, blues, yellows] = candidates;
    for red in reds {
        for green in greens {
            for blue in blues {
                for yellow in yellows {
                    if let Some(quartet) = judge([*red, *green, *blue, *yellow], config) {
                        insert(&mut best, quartet);
                    }
                }
            }
        }
    }
    best
}

fn insert(best: &mut Vec<Quartet, MAX_QUARTETS>, quartet: Quartet) {
    let at = best.iter().position(|b| quartet.score > b.score).unwrap_or(best.len());
    if best.is_full() && at < MAX_QUARTETS {
        best.pop();
    }
    // Refused only where it is worse than all of a full list.
    let _ = best.insert(at, quartet);
}

/// The rules that four balls of one frame keep in one picture, and how well they keep them.
///
/// Seen from afar, arms of equal length at right angles have projections z (as complex numbers) with
/// sum z^2 = 0, whatever the orientation (Gauss, the fundamental theorem of axonometry), and
/// sum |z|^2 = 2 (scale x length)^2. The first tells a frame from four scattered balls; the second
/// gives the arm in ball diameters, the same number in every view.
fn judge(balls: [Candidate; BALLS], config: &ProposeConfig) -> Option<Quartet> {
    let (mut smallest, mut largest, mut diameters, mut quality) = (f32::MAX, 0.0f32, 0.0, 0.0);
    for ball in &balls {
        smallest = smallest.min(ball.diameter);
        largest = largest.max(ball.diameter);
        diameters += ball.diameter;
        quality += ball.quality;
    }
    let diameter = diameters / BALLS as f32;
    let ratio = largest / smallest;
    if ratio > config.size_ratio {
        return None;
    }
    for (i, a) in balls.iter().enumerate() {
        for b in balls.iter().skip(i + 1) {
            // Two colours of one ball, or further apart than any frame.
            let distance = a.centre.distance(b.centre);
            if distance < LEAST_APART * (a.diameter + b.diameter) || distance > config.spread * diameter {
                return None;
            }
        }
    }
    let [origin, ends @ ..] = balls;
    let (mut real, mut imaginary, mut power) = (0.0, 0.0, 0.0);
    for (end, length) in ends.iter().zip(config.arms) {
        let z = (end.centre - origin.centre) * (1.0 / length);
        real += z.u * z.u - z.v * z.v;
        imaginary += 2.0 * z.u * z.v;
        power += z.u * z.u + z.v * z.v;
    }
    let skew = libm::sqrtf(real * real + imaginary * imaginary) / power;
    let arm_diameters = libm::sqrtf(power / 2.0) / diameter;
    // False for NaN too, which equal centres and arms of length 0 give.
    let fits = skew <= config.skew && arm_diameters <= config.spread;
    if !fits {
        return None;
    }
    let likeness = 1.0 - (ratio - 1.0) / config.size_ratio;
    let score = quality / BALLS as f32 * likeness * (1.0 - skew);
    Some(Quartet { balls, score, arm_diameters })
}

/// Balls may hide each other in part: nearer than this share of the sum of their diameters they are
/// taken for one.
const LEAST_APART: f32 = 0.3;
