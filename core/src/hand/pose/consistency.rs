//! Solving a frame without what contradicts the rest: a wrong ball, a camera that was moved, a leap
//! that only half-hidden balls show.

use super::PoseTracker;
use super::sightings::complete;
use super::solve::{self, Fit, Seen, solve};
use crate::geometry::Pose;
use crate::hand::perspective::posit::posit;
use crate::observation::BALLS;
use nalgebra::{Cholesky, Matrix6};

/// How many of the balls of a frame may be left out as wrong before a whole view is doubted.
const MAX_WRONG: usize = 2;

/// Equations less unknowns from which on a ball that is not where it should be shows: seven balls.
const REDUNDANT: f32 = 8.0;

/// Of two views that contradict each other the one is believed that is nearer to where the hand was
/// expected by so many times, variances.
const PLAINLY: f32 = 4.0;

/// A frame that was solved.
pub(super) struct Solved {
    pub fit: Fit,
    /// What of the views it was solved from.
    pub seen: Seen,
    /// The view that was left out.
    pub excluded: Option<usize>,
}

/// Where the hand is expected by the movement before.
struct Expected {
    pose: Pose,
    covariance: Matrix6<f32>,
    /// It has not been unseen for long.
    recent: bool,
}

impl Expected {
    /// How far a pose is from there, in variances of both.
    fn surprise(&self, fit: &Fit) -> Option<f32> {
        let leap = solve::difference(&fit.pose, &self.pose);
        let factor = Cholesky::new(fit.covariance + self.covariance)?;
        Some(leap.dot(&factor.solve(&leap))).filter(|square| square.is_finite())
    }

    /// Whether a pose may follow from the movement before it. After a while unseen any may, if there
    /// are balls enough for a wrong one to show.
    fn allows(&self, fit: &Fit, leap_sigmas: f32) -> bool {
        if !self.recent {
            return is_redundant(fit);
        }
        self.surprise(fit).is_some_and(|square| square < 6.0 * leap_sigmas * leap_sigmas)
    }
}

impl PoseTracker {
    /// Solves a frame from the cameras as they are known; what does not fit is left out.
    #[inline(never)]
    pub(super) fn measure(&self, seen: &Seen, t_us: u64) -> Option<Solved> {
        let (course, config) = (self.course.as_ref()?, self.pose_config());
        let expected = Expected {
            pose: course.pose_at(t_us, config),
            covariance: course.covariance_at(t_us, config),
            recent: course.age_us(t_us) <= config.predict_us,
        };
        let cameras = self.calibration.cameras();
        // cameras not latched yet, or not trusted, take no part
        let mut known = *seen;
        for (view, (sightings, camera)) in known.iter_mut().zip(cameras).enumerate() {
            if camera.is_none() || !self.is_trusted(view) {
                *sightings = [None; BALLS];
            }
        }
        // one place for what is solved: it is too large to be handed on again and again
        let mut solved = self.consistent(&known, &expected.pose, &expected);
        if solved.is_none() {
            // the hand is not where it was expected: from where each complete view sees it
            let mut starts = cameras.iter().zip(&known).filter_map(|(camera, sightings)| {
                let camera = camera.as_ref()?;
                let hand = posit(&complete(sightings)?, camera.focal_px(), self.arms)?;
                Some(camera.places(&hand))
            });
            solved = starts.find_map(|start| self.consistent(&known, &start, &expected));
        }
        let Some(Solved { fit, seen: fitted, .. }) = &solved else { return solved };
        if expected.allows(fit, config.leap_sigmas) {
            return solved;
        }
        // a leap is believed where balls seen whole show it; those half hidden may have feigned it
        let mut clear = known;
        for ((sightings, hidden), fitted) in clear.iter_mut().zip(&self.hidden).zip(fitted) {
            for ((sighting, hidden), fitted) in sightings.iter_mut().zip(hidden).zip(fitted) {
                if *hidden || fitted.is_none() {
                    *sighting = None;
                }
            }
        }
        // and where views contradict each other, only if what is left agrees among itself
        let agrees = *fitted == known || is_redundant(fit);
        if clear != *fitted {
            solved = self.consistent(&clear, &expected.pose, &expected);
        } else if !agrees {
            solved = None;
        }
        solved
    }

    /// The pose from a start, without the balls or the view that contradict the others.
    fn consistent(&self, seen: &Seen, start: &Pose, expected: &Expected) -> Option<Solved> {
        let mut rest = *seen;
        let mut from = *start;
        for _ in 0..=MAX_WRONG {
            let Some(fit) = self.fit(&from, &rest) else { break };
            if is_sound(&fit) {
                return Some(Solved { fit, seen: rest, excluded: None });
            }
            // without the ball that is farthest off: it draws others after it
            let Some((view, ball)) = fit.worst else { break };
            if let Some(sighting) = rest.get_mut(view).and_then(|sightings| sightings.get_mut(ball)) {
                *sighting = None;
            }
            from = fit.pose;
        }
        self.without_a_view(seen, start, expected)
    }

    /// One camera contradicts the others: that without which they agree, or without which the hand is
    /// where it was expected; but none that has been trusted longer than all others.
    #[cold]
    #[inline(never)]
    fn without_a_view(&self, seen: &Seen, start: &Pose, expected: &Expected) -> Option<Solved> {
        let mut best: Option<(f32, Solved)> = None;
        let mut second = f32::INFINITY;
        for (view, sightings) in seen.iter().enumerate() {
            if sightings.iter().all(Option::is_none) || !self.may_leave_out(view, seen) {
                continue;
            }
            let mut rest = *seen;
            if let Some(sightings) = rest.get_mut(view) {
                *sightings = [None; BALLS];
            }
            let Some(fit) = self.fit(start, &rest).filter(is_sound) else { continue };
            if !is_redundant(&fit) && !expected.allows(&fit, self.config.pose.leap_sigmas) {
                continue;
            }
            let Some(surprise) = expected.surprise(&fit) else { continue };
            match &best {
                Some((least, _)) if surprise >= *least => second = second.min(surprise),
                _ => {
                    second = best.map_or(second, |(least, _)| least);
                    best = Some((surprise, Solved { fit, seen: rest, excluded: Some(view) }));
                }
            }
        }
        // two that are as likely: nobody knows which is right
        best.filter(|(least, _)| second > PLAINLY * least).map(|(_, solved)| solved)
    }

    pub(super) fn fit(&self, start: &Pose, seen: &Seen) -> Option<Fit> {
        let config = self.pose_config();
        solve(start, self.calibration.cameras(), seen, self.arms, self.noise, config)
    }
}

/// Whether there are so many balls that a wrong one would show.
fn is_redundant(fit: &Fit) -> bool {
    fit.freedom >= REDUNDANT
}

/// Whether a fit came to an end with every ball near where it should be.
pub(super) fn is_sound(fit: &Fit) -> bool {
    fit.settled && fit.wrong == 0
}
