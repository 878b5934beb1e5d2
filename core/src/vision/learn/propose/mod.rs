//! Learning without a click: the four balls are proposed, the operator only confirms.
//!
//! In each view, pixels that stand out by the chroma of a primary are seeds (`seeds`); learning at
//! each of them gives candidates, up to eight a colour; of all their combinations the best that may
//! be one feature frame is proposed (`quartet`), and with several views one whose arm, measured in
//! ball diameters, is the same in all of them.
//!
//! V alone ranks a dark grey above a pale red (V of black is 2/3), so what is searched for is V with
//! the grey part taken out: the chroma.

mod quartet;
mod seeds;

use super::probe::{Probe, brightness, chroma};
use super::{Learnt, learn_with};
use crate::config::{MAX_VIEWS, ProposeConfig};
use crate::observation::{BALLS, Ball};
use crate::vision::centre::Blob;
use crate::vision::colour::Primary;
use crate::vision::frame::FrameView;
use core::fmt;
use heapless::Vec;
use quartet::{Candidate, Candidates, MAX_QUARTETS, Quartet};

/// What was found in all views.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// One entry a view, in the order the frames were given; at most [`MAX_VIEWS`].
    pub views: Vec<ViewProposal, MAX_VIEWS>,
    /// Pixels read in all views.
    pub pixels_tested: u32,
}

impl Proposal {
    /// Whether all four balls are proposed in every view.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        !self.views.is_empty() && self.views.iter().all(|view| view.balls.is_ok())
    }
}

/// What was found in one view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewProposal {
    /// The four balls in the order of [`Ball::ALL`], or why there are none.
    pub balls: Result<[Learnt; BALLS], ProposeError>,
    /// How many candidates each colour had, in the same order.
    pub candidates: [u8; BALLS],
    /// How good a feature frame the four are, 0 to 1; 0 without them.
    pub score: f32,
    /// The score of the next best four, 0 where there are none.
    pub runner_up: f32,
}

/// Why no four balls are proposed in a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProposeError {
    /// Colours of which nothing round was found, in the order of [`Ball::ALL`].
    Missing([bool; BALLS]),
    /// Every colour has candidates, and no four of them can be one feature frame.
    NoFrame,
    /// Another ball of this colour fits as well.
    Ambiguous(Ball),
    /// The four do not agree with what the other views show.
    ViewsDisagree,
}

impl fmt::Display for ProposeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(missing) => {
                f.write_str("no ball found of colour")?;
                for (ball, _) in Ball::ALL.iter().zip(missing).filter(|(_, missing)| **missing) {
                    write!(f, " {}", ball.name())?;
                }
                f.write_str("; show all four to the camera or point at them")
            }
            Self::NoFrame => f.write_str("no four balls look like one frame; point at them"),
            Self::Ambiguous(ball) => {
                write!(f, "two {} balls fit; remove one or point at the right one", ball.name())
            }
            Self::ViewsDisagree => {
                f.write_str("the balls found here and in the other views are not one frame; point at them")
            }
        }
    }
}

impl core::error::Error for ProposeError {}

/// Proposes the four balls in each of the frames, one a view. Frames beyond [`MAX_VIEWS`] are left
/// out.
///
/// Worst case in each view: the grid (41 pixels a sample) and 32 times learning.
#[must_use]
pub fn propose(frames: &[FrameView<'_>], config: &ProposeConfig) -> Proposal {
    let mut tested = 0u32;
    let mut found: Vec<Found, MAX_VIEWS> = Vec::new();
    for frame in frames.iter().take(MAX_VIEWS) {
        let candidates = candidates(frame, config, &mut tested);
        let counts = candidates.each_ref().map(|list| list.len() as u8);
        // Never full: as many as there are views.
        let _ = found.push(Found { quartets: quartet::best(&candidates, config), counts });
    }
    let arm = common_arm(&found, config);
    let mut views = Vec::new();
    for (frame, found) in frames.iter().zip(&found) {
        let _ = views.push(view(frame, found, arm, config, &mut tested));
    }
    Proposal { views, pixels_tested: tested }
}

/// What the search of one view found.
struct Found {
    quartets: Vec<Quartet, MAX_QUARTETS>,
    counts: [u8; BALLS],
}

/// Learns at every seed of a view.
fn candidates(frame: &FrameView<'_>, config: &ProposeConfig, tested: &mut u32) -> Candidates {
    let mut probe = Probe::new(frame);
    let seeds = seeds::find(&mut probe, config);
    let mut candidates = Candidates::default();
    for ((ball, seeds), list) in Ball::ALL.into_iter().zip(&seeds).zip(&mut candidates) {
        for seed in seeds {
            let at = seed.point();
            let Ok(learnt) = learn_with(&mut probe, Primary::of(ball), at, &config.learn) else {
                continue;
            };
            let quality = quality(&learnt);
            let candidate = Candidate { seed: at, centre: learnt.centre, diameter: learnt.diameter, quality };
            let same = |other: &&mut Candidate| {
                other.centre.distance(candidate.centre) < (other.diameter + candidate.diameter) / 4.0
            };
            if let Some(other) = list.iter_mut().find(same) {
                if candidate.quality > other.quality {
                    *other = candidate;
                }
            } else if quality >= config.least_quality {
                // Never full: no more candidates than seeds.
                let _ = list.push(candidate);
            }
        }
    }
    *tested = tested.saturating_add(probe.tested());
    candidates
}

/// How good a ball it is, 0 to 1: contrast at its rim, how well it is told from its surroundings,
/// how saturated it is, and how round what the tracker would see.
fn quality(learnt: &Learnt) -> f32 {
    let reference = learnt.reference.reference;
    let saturation = chroma(learnt.reference.primary, reference) as f32 / brightness(reference).max(1) as f32;
    let round = match &learnt.blob {
        Ok(blob) => roundness(blob),
        Err(_) => UNBOUNDED,
    };
    learnt.rim * learnt.separation * round * libm::sqrtf(saturation.max(0.0))
}

/// 1 for a disc, down to 0 for what is none: area / (width x height) against pi/4, and height against
/// width.
fn roundness(blob: &Blob) -> f32 {
    let (width, height) = (blob.diameter.max(1.0), blob.height.max(1.0));
    let fill = blob.area / (width * height) / core::f32::consts::FRAC_PI_4;
    let aspect = width.min(height) / width.max(height);
    (1.0 - 2.0 * (fill - 1.0).abs()).max(0.0) * aspect
}

/// What something touches so that its rows have no end keeps this much of its quality.
const UNBOUNDED: f32 = 0.4;

/// The length of an arm, in ball diameters, with which the best quartets of all views agree.
fn common_arm(found: &[Found], config: &ProposeConfig) -> Option<f32> {
    let agreeing = |arm: f32| -> f32 {
        let best = |view: &Found| {
            view.quartets.iter().find(|q| alike(q.arm_diameters, arm, config)).map_or(0.0, |q| q.score)
        };
        found.iter().map(best).sum()
    };
    let mut common: Option<(f32, f32)> = None;
    for quartet in found.iter().flat_map(|view| &view.quartets) {
        let total = agreeing(quartet.arm_diameters);
        if common.is_none_or(|(most, _)| total > most) {
            common = Some((total, quartet.arm_diameters));
        }
    }
    common.map(|(_, arm)| arm)
}

fn alike(a: f32, b: f32, config: &ProposeConfig) -> bool {
    a <= b * config.arm_ratio && b <= a * config.arm_ratio
}

/// What a view proposes, given the arm on which the views agree.
fn view(
    frame: &FrameView<'_>,
    found: &Found,
    arm: Option<f32>,
    config: &ProposeConfig,
    tested: &mut u32,
) -> ViewProposal {
    let Found { quartets, counts: candidates } = found;
    let candidates = *candidates;
    let none = |error| ViewProposal { balls: Err(error), candidates, score: 0.0, runner_up: 0.0 };
    if candidates.contains(&0) {
        return none(ProposeError::Missing(candidates.map(|count| count == 0)));
    }
    if quartets.is_empty() {
        return none(ProposeError::NoFrame);
    }
    let mut agreeing = quartets.iter().filter(|q| arm.is_some_and(|arm| alike(q.arm_diameters, arm, config)));
    let Some(best) = agreeing.next() else {
        return none(ProposeError::ViewsDisagree);
    };
    let second = agreeing.next();
    let runner_up = second.map_or(0.0, |q| q.score);
    if runner_up > best.score * config.ambiguity
        && let Some(second) = second
    {
        let other =
            Ball::ALL.into_iter().zip(best.balls.iter().zip(&second.balls)).find(|(_, (a, b))| a != b);
        if let Some((ball, _)) = other {
            return ViewProposal { score: best.score, runner_up, ..none(ProposeError::Ambiguous(ball)) };
        }
    }
    let mut probe = Probe::new(frame);
    let mut again = |ball: Ball| {
        let candidate = best.balls.get(ball.index())?;
        learn_with(&mut probe, Primary::of(ball), candidate.seed, &config.learn).ok()
    };
    let (red, green, blue, yellow) =
        (again(Ball::Red), again(Ball::Green), again(Ball::Blue), again(Ball::Yellow));
    *tested = tested.saturating_add(probe.tested());
    match (red, green, blue, yellow) {
        (Some(red), Some(green), Some(blue), Some(yellow)) => {
            ViewProposal { balls: Ok([red, green, blue, yellow]), candidates, score: best.score, runner_up }
        }
        // The same seeds in the same picture teach the same; only a picture that changes meanwhile
        // does not.
        _ => none(ProposeError::NoFrame),
    }
}

#[cfg(test)]
mod tests;
