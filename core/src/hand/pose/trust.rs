//! Which views are trusted: one that contradicted the others stays out until it has agreed with them
//! over a movement, and one that stands still while the others see motion is stale.
//!
//! A frozen camera agrees with any hand that comes by, and with any hand that it has pulled to itself.
//! So agreement counts only while the view's own balls move, and trust has inertia: a view that was
//! left out is not asked again, nor does one trusted for a short time outvote one trusted longer.

use super::PoseTracker;
use super::consistency::is_sound;
use super::solve::{Fit, Seen};
use crate::config::MAX_VIEWS;
use crate::geometry::Pose;
use crate::hand::perspective::{Sightings, picture};
use crate::observation::BALLS;

/// A ball has moved when it is so many standard deviations from where it last was.
const MOVED_SIGMAS: f32 = 6.0;

/// So far must a view's ball have moved while it agreed, or contradicted, for that to count, px. It is
/// beyond what a view may be off and still agree.
const MOVED_PX: f32 = 3.0;

/// Frames in a row in which a view that was left out must agree to be trusted again.
const PROBATION_FRAMES: u32 = 6;

/// Frames after which a view is trusted as much as it can be.
const LONG_TRUSTED: u32 = 90;

/// What is known of the trust in one view.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Trust {
    /// What it saw in the last frame.
    last: Sightings,
    /// Where its balls were when they last moved by more than noise.
    stood: Sightings,
    /// Where the hand was then, if the other views could tell.
    stood_at: Option<Pose>,
    /// Its balls have not moved while the other views saw motion.
    stale: bool,
    /// It was left out and has not yet proved itself.
    suspended: bool,
    /// Frames in a row in which it agreed with the others, or contradicted them, while suspended.
    agreed: u32,
    contradicted: u32,
    /// How far its balls have moved since, px.
    travel_px: f32,
    /// Frames in which it helped to measure since it was last taken in.
    trusted: u32,
}

impl Trust {
    /// Left out from here on, until it has proved itself.
    fn suspend(&mut self) {
        if !self.suspended {
            *self = Self { suspended: true, agreed: 0, contradicted: 0, travel_px: 0.0, trusted: 0, ..*self };
        }
    }

    /// Whether it may take part in a fit.
    pub(super) const fn takes_part(&self) -> bool {
        !self.suspended
    }

    pub(super) const fn is_stale(&self) -> bool {
        self.stale
    }

    /// How long it has been trusted, frames.
    pub(super) const fn seniority(&self) -> u32 {
        if self.trusted < LONG_TRUSTED { self.trusted } else { LONG_TRUSTED }
    }

    /// In a new world all views that are not stale begin alike.
    pub(super) const fn begin_anew(self) -> Self {
        Self {
            stood_at: None,
            suspended: self.stale,
            agreed: 0,
            contradicted: 0,
            travel_px: 0.0,
            trusted: 0,
            ..self
        }
    }

    /// Where the hand stood is told in another world from here on.
    pub(super) const fn change_world(&mut self) {
        self.stood_at = None;
    }

    /// Takes what it sees; tells whether the hand moved in it by more than noise: three balls did.
    fn look(&mut self, sightings: &Sightings, noise: f32) -> bool {
        let (mut count, mut sum_px) = (0_u8, 0.0);
        let least = MOVED_SIGMAS * noise;
        for (now, stood) in sightings.iter().zip(&mut self.stood) {
            let Some(now) = now else { continue };
            let by_px = now.x_px - stood.get_or_insert(*now).x_px;
            if now.whiten(by_px).norm_squared() > least * least {
                count = count.saturating_add(1);
                sum_px += by_px.norm();
            }
        }
        let moved = usize::from(count) + 1 >= BALLS;
        if moved {
            self.travel_px += sum_px / f32::from(count);
            for (now, stood) in sightings.iter().zip(&mut self.stood) {
                *stood = now.or(*stood);
            }
            (self.stale, self.stood_at) = (false, None);
        }
        moved
    }

    /// Takes one more frame in which it agreed with the others or contradicted them.
    fn prove(&mut self, agrees: bool) {
        let turned = if agrees { self.contradicted > 0 } else { self.agreed > 0 };
        if turned {
            (self.agreed, self.contradicted, self.travel_px) = (0, 0, 0.0);
        }
        let count = if agrees { &mut self.agreed } else { &mut self.contradicted };
        *count = count.saturating_add(1);
        if self.agreed >= PROBATION_FRAMES && self.has_proof() {
            (self.suspended, self.trusted) = (false, 0);
        }
    }

    /// Whether it has seen the hand move since it began to agree, or to contradict.
    fn has_proof(&self) -> bool {
        !self.stale && self.travel_px > MOVED_PX
    }
}

impl PoseTracker {
    /// Looks which views see motion. One that shows the very same as in the last frame while another
    /// sees the hand move is frozen.
    pub(super) fn watch(&mut self, seen: &Seen) {
        let noise = self.noise;
        let mut same = [false; MAX_VIEWS];
        let mut any_moved = false;
        for ((trust, sightings), same) in self.trust.iter_mut().zip(seen).zip(&mut same) {
            *same = trust.last == *sightings && sightings.iter().any(Option::is_some);
            trust.last = *sightings;
            any_moved |= trust.look(sightings, noise);
        }
        for (trust, same) in self.trust.iter_mut().zip(same) {
            if same && any_moved {
                trust.stale = true;
                trust.suspend();
            }
        }
    }

    /// What a solved frame tells of the trust in the views.
    pub(super) fn trust_follows(&mut self, fit: &Fit, seen: &Seen, used: &Seen, excluded: Option<usize>) {
        for (view, sightings) in seen.iter().enumerate() {
            let Some(trust) = self.trust.get_mut(view) else { continue };
            if fit.views.get(view).is_some_and(|fit| fit.balls > 0) {
                trust.trusted = trust.trusted.saturating_add(1);
            }
            if excluded == Some(view) {
                trust.suspend();
            }
            let shown = sightings.iter().flatten().count() + 1 >= BALLS;
            if trust.suspended && shown {
                self.is_proving_itself(view, fit, sightings, used);
            }
        }
    }

    /// Whether a view that was left out would have agreed with the others.
    #[cold]
    #[inline(never)]
    fn is_proving_itself(&mut self, view: usize, fit: &Fit, sightings: &Sightings, used: &Seen) {
        let (Some(mut trust), Some(camera)) = (self.trust.get(view).copied(), self.calibration.camera(view))
        else {
            return;
        };
        let focal_px = camera.focal_px();
        let picture_at = |pose: &Pose| picture(&camera.sees(pose), focal_px, self.arms);
        let stood_at = *trust.stood_at.get_or_insert(fit.pose);
        // the hand moved, and its balls did not
        trust.stale |= picture_at(&stood_at).iter().zip(&picture_at(&fit.pose)).any(|(then, now)| {
            matches!((then, now), (Some(then), Some(now)) if (now - then).norm() > 2.0 * MOVED_PX)
        });
        let mut with = *used;
        if let Some(its) = with.get_mut(view) {
            *its = *sightings;
        }
        trust.prove(self.fit(&fit.pose, &with).is_some_and(|fit| is_sound(&fit)));
        if let Some(of_view) = self.trust.get_mut(view) {
            *of_view = trust;
        }
    }

    /// A camera that has contradicted the others for long, and sees the hand move: it was moved. From
    /// here on it must prove itself anew.
    pub(super) fn take_moved(&mut self) -> Option<usize> {
        // what it takes to prove itself counts among the frames that it may be left out
        let patience = self.config.pose.relatch_frames.saturating_sub(PROBATION_FRAMES);
        let (view, trust) = self
            .trust
            .iter_mut()
            .enumerate()
            .find(|(_, trust)| trust.suspended && trust.contradicted >= patience && trust.has_proof())?;
        (trust.agreed, trust.contradicted, trust.travel_px) = (0, 0, 0.0);
        Some(view)
    }

    /// Whether a view takes part in measuring.
    pub(super) fn is_trusted(&self, view: usize) -> bool {
        self.trust.get(view).is_some_and(Trust::takes_part)
    }

    /// Whether a view shows the same for ever.
    pub(super) fn is_stale(&self, view: usize) -> bool {
        self.trust.get(view).is_some_and(Trust::is_stale)
    }

    /// Whether the others may outvote this view: one of them at least has been trusted as long.
    pub(super) fn may_leave_out(&self, view: usize, seen: &Seen) -> bool {
        let seniority = |view: usize| self.trust.get(view).map_or(0, Trust::seniority);
        let others = seen
            .iter()
            .enumerate()
            .filter(|(other, sightings)| *other != view && sightings.iter().any(Option::is_some));
        others.map(|(other, _)| seniority(other)).max().is_some_and(|most| most >= seniority(view))
    }
}
