//! Solving a frame without what contradicts the rest: a wrong ball, a camera that was moved, a leap
//! that only half-hidden balls show.

use super::PoseTracker;
use super::course::Course;
use super::sightings::complete;
use super::solve::{self, Fit, Seen, solve};
use crate::geometry::Pose;
use crate::hand::perspective::posit::posit;
use crate::observation::BALLS;
use nalgebra::Cholesky;

/// How many of the balls of a frame may be left out as wrong before a whole view is doubted.
const MAX_WRONG: usize = 2;

/// Equations less unknowns from which on a ball that is not where it should be shows: seven balls.
const REDUNDANT: f32 = 8.0;

/// A frame that was solved.
pub(super) struct Solved {
    pub fit: Fit,
    /// What of the views it was solved from.
    pub seen: Seen,
    /// The view that was left out.
    pub excluded: Option<usize>,
}

impl PoseTracker {
    /// Solves a frame from the cameras as they are known; what does not fit is left out.
    pub(super) fn measure(&self, seen: &Seen, t_us: u64) -> Option<Solved> {
        let course = self.course.as_ref()?;
        let expected = course.pose_at(t_us, self.pose_config());
        let cameras = self.calibration.cameras();
        // cameras not latched yet take no part
        let mut known = *seen;
        for (sightings, camera) in known.iter_mut().zip(cameras) {
            if camera.is_none() {
                *sightings = [None; BALLS];
            }
        }
        let solved = self.consistent(&known, &expected, &expected).or_else(|| {
            // the hand is not where it was expected: from where each complete view sees it
            let mut starts = cameras.iter().zip(&known).filter_map(|(camera, sightings)| {
                let camera = camera.as_ref()?;
                let hand = posit(&complete(sightings)?, camera.focal_px(), self.arms)?;
                Some(camera.places(&hand))
            });
            starts.find_map(|start| self.consistent(&known, &start, &expected))
        })?;
        if self.is_likely(&solved.fit, course, t_us) {
            return Some(solved);
        }
        // a leap is believed where balls seen whole show it; those half hidden may have feigned it
        let mut clear = known;
        for ((sightings, hidden), fitted) in clear.iter_mut().zip(&self.hidden).zip(&solved.seen) {
            for ((sighting, hidden), fitted) in sightings.iter_mut().zip(hidden).zip(fitted) {
                if *hidden || fitted.is_none() {
                    *sighting = None;
                }
            }
        }
        if clear == solved.seen { Some(solved) } else { self.consistent(&clear, &expected, &expected) }
    }

    /// Whether a pose may follow from the movement before it. After a while unseen any may, if there
    /// are balls enough for a wrong one to show.
    fn is_likely(&self, fit: &Fit, course: &Course, t_us: u64) -> bool {
        let config = self.pose_config();
        if course.age_us(t_us) > config.predict_us {
            return fit.freedom >= REDUNDANT;
        }
        let leap = solve::difference(&fit.pose, &course.pose_at(t_us, config));
        let covariance = fit.covariance + course.covariance_at(t_us, config);
        let square = Cholesky::new(covariance).map_or(0.0, |factor| leap.dot(&factor.solve(&leap)));
        square < 6.0 * config.leap_sigmas * config.leap_sigmas
    }

    /// The pose from a start, without the balls or the view that contradict the others.
    fn consistent(&self, seen: &Seen, start: &Pose, expected: &Pose) -> Option<Solved> {
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
        // one camera contradicts the others: the one without which the hand is nearest to where it
        // was expected
        let mut best: Option<(f32, Solved)> = None;
        for (view, sightings) in seen.iter().enumerate() {
            if sightings.iter().all(Option::is_none) {
                continue;
            }
            let mut rest = *seen;
            if let Some(sightings) = rest.get_mut(view) {
                *sightings = [None; BALLS];
            }
            let Some(fit) = self.fit(start, &rest).filter(is_sound) else { continue };
            let off = self.unlikelihood(&fit.pose, expected);
            if best.as_ref().is_none_or(|(least, _)| off < *least) {
                best = Some((off, Solved { fit, seen: rest, excluded: Some(view) }));
            }
        }
        best.map(|(_, solved)| solved)
    }

    pub(super) fn fit(&self, start: &Pose, seen: &Seen) -> Option<Fit> {
        let config = self.pose_config();
        solve(start, self.calibration.cameras(), seen, self.arms, self.noise(), config)
    }

    /// How far a pose is from where it was expected, in what a prediction may be off.
    fn unlikelihood(&self, pose: &Pose, expected: &Pose) -> f32 {
        let config = self.pose_config();
        let [x, y, z, wx, wy, wz] = solve::difference(pose, expected).into();
        let shift = (x * x + y * y + z * z) / (config.prior_m * config.prior_m);
        shift + (wx * wx + wy * wy + wz * wz) / (config.prior_rad * config.prior_rad)
    }
}

/// Whether a fit came to an end with every ball near where it should be.
fn is_sound(fit: &Fit) -> bool {
    fit.settled && fit.wrong == 0
}
