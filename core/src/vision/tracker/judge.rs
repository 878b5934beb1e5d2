//! Which finds are balls, which of them are whole, and which stand behind another (sections 3.4 and 3.5).

use super::CameraTracker;
use crate::observation::BALLS;
use crate::vision::frame::FrameView;
use crate::vision::locate::{Doubt, Doubts, Finds, places};
use crate::vision::occlusion::{Seen, centre_behind, centre_beyond_the_edge, is_hidden_by, touch};
use crate::vision::reacquire::{Places, stray};
use crate::vision::track::Mode;
use crate::vision::tracker::StepReport;
use crate::vision::validation::{geometric_mismatch, is_whole, shape_holds};

impl CameraTracker {
    /// Which finds look little like their balls: the larger window is searched for better ones, and the
    /// whole picture too when that has lasted.
    pub(super) fn doubts(&mut self, t_us: u64, predicted: &Places, finds: &Finds) -> Doubts {
        let shape = &self.config.shape;
        let mut doubts = [None; BALLS];
        let slots = finds.iter().zip(&mut doubts).zip(&mut self.tracks).zip(predicted);
        for (((find, doubt), track), expected) in slots {
            let (Some(found), Some(track)) = (find, track) else { continue };
            let doubtful = found.score < shape.doubtful_score && !found.blob.cut;
            let lasting = track.doubt(doubtful, t_us, shape.doubt_us);
            if doubtful {
                let reach = shape.doubtful_reach * track.clean.diameter.max(track.clean.height);
                let near = expected.is_some_and(|expected| found.centre.distance(expected) <= reach);
                *doubt = Some(Doubt { near, lasting });
            }
        }
        doubts
    }

    /// While nothing else of a rigid frame is seen, a thing that is not a whole ball is no ball.
    pub(super) fn drop_lone_part(&self, finds: &mut Finds) {
        let taught = self.tracks.iter().flatten().count();
        let mut found = finds.iter_mut().filter(|find| find.is_some());
        if let (Some(lone), None) = (found.next(), found.next())
            && self.config.rigid
            && taught > 1
            && lone.as_ref().is_some_and(|find| !find.whole)
        {
            *lone = None;
        }
    }

    /// A thing of a ball's colour far from the hand: neither found nor remembered.
    pub(super) fn drop_stray(&mut self, finds: &mut Finds) {
        if !self.config.rigid {
            return;
        }
        let mut diameters = [0.0; BALLS];
        for (diameter, track) in diameters.iter_mut().zip(&self.tracks) {
            *diameter = track.as_ref().map_or(0.0, |t| t.clean.diameter);
        }
        if let Some(k) = stray(&places(finds), &diameters)
            && let (Some(find), Some(Some(track))) = (finds.get_mut(k), self.tracks.get_mut(k))
        {
            *find = None;
            track.forget();
        }
    }

    pub(super) fn judge_whole(&mut self, finds: &mut Finds) {
        let Self { config: c, tracks } = self;
        for (find, track) in finds.iter_mut().zip(tracks) {
            if let (Some(find), Some(track)) = (find, track) {
                let aspect = track.appearance.learnt().aspect;
                find.whole = is_whole(&find.blob, &track.clean, aspect, &c.shape, &c.occlusion);
                let round = !find.blob.cut && shape_holds(&find.blob, aspect, &c.shape);
                // A ball that stays round has come nearer or gone away; it is not hidden.
                find.whole |= track.looks_round(round);
                find.whole &= find.score >= c.shape.whole_score;
            }
        }
    }

    /// Section 3.4: of two balls that touch, the one that lost more of its area is behind the other.
    pub(super) fn place_hidden(&self, frame: &FrameView<'_>, finds: &mut Finds, tested: &mut u32) {
        let c = &self.config.occlusion;
        let mut seen = [None; BALLS];
        for ((seen, find), track) in seen.iter_mut().zip(finds.iter()).zip(&self.tracks) {
            *seen = find.as_ref().zip(track.as_ref()).map(|(f, t)| Seen {
                centre: f.blob.centre,
                area_share: f.blob.area / t.clean.area.max(1.0),
                clean: t.clean,
            });
        }
        for (k, (find, x)) in finds.iter_mut().zip(&seen).enumerate() {
            let (Some(find), Some(x)) = (find, x) else { continue };
            let mut front: Option<Seen> = None;
            for (l, y) in seen.iter().enumerate() {
                let Some(y) = *y else { continue };
                if l == k || !touch(x.centre, &x.clean, y.centre, &y.clean, c) {
                    continue;
                }
                find.touching = true;
                if is_hidden_by(x, &y, c)
                    && front.is_none_or(|f| x.centre.distance(y.centre) < x.centre.distance(f.centre))
                {
                    front = Some(y);
                }
            }
            if let Some(y) = front {
                find.whole = false;
                find.centre =
                    centre_behind(frame, &find.matcher, &find.blob, &x.clean, y.centre, &y.clean, tested);
            } else if find.blob.cut {
                find.centre = centre_beyond_the_edge(frame, &find.blob, &x.clean);
            }
        }
    }

    /// Section 3.5. Colours are confirmed only when all tracked balls are whole and, for a rigid
    /// frame, stand to each other as predicted.
    pub(super) fn validate(&mut self, finds: &Finds, predicted: &Places, report: &mut StepReport) {
        report.mismatch = geometric_mismatch(&places(finds), predicted);
        let all_whole = finds.iter().zip(&self.tracks).all(|(find, track)| {
            track.is_none() || find.as_ref().is_some_and(|f| f.whole && f.mode == Mode::Tracking)
        });
        let stand_right =
            !self.config.rigid || report.mismatch.is_none_or(|m| m <= self.config.validation.max_mismatch);
        report.validated = all_whole && stand_right && self.tracks.iter().any(Option::is_some);
    }
}
