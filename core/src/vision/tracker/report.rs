//! What is said of each ball after a frame, how well it is known, and what is remembered for the next.

use super::{CameraTracker, StepReport};
use crate::config::CentreMode;
use crate::observation::{ImageCovariance, Observation, ObservationState};
use crate::vision::locate::{Find, Finds, places};
use crate::vision::reacquire::{Places, suggested};
use crate::vision::track::Mode;

/// The standard deviation of a row-edge centre along each axis, px: section 5 reports a mean error
/// of 0.1 px in even light. The measure itself says nothing about the light.
const PAPER_SIGMA_PX: f32 = 0.1;

/// That of a whole ball whose rim was refused, in diameters: the row edges of a ball lit from one side
/// are off by a tenth.
const UNREFINED_SIGMA: f32 = 0.1;

/// That of a ball seen in part whose rim was refused.
const UNREFINED_PART_SIGMA: f32 = 0.25;

/// That of a predicted place, in diameters.
const PREDICTED_SIGMA: f32 = 0.5;

impl CameraTracker {
    #[inline(never)]
    pub(super) fn remember(&mut self, t_us: u64, finds: &Finds, predicted: &Places, report: &mut StepReport) {
        let places = places(finds);
        let predict_us = self.config.occlusion.predict_us;
        let rigid = self.config.rigid;
        let refined = self.config.centre.mode == CentreMode::Refined;
        let outputs = report.observations.iter_mut().zip(&mut report.modes).zip(&mut report.scores);
        for (k, ((((observation, mode), score), track), find)) in
            outputs.zip(&mut self.tracks).zip(finds).enumerate()
        {
            let Some(track) = track else { continue };
            if let Some(find) = find {
                let seen = (find.blob.area / track.clean.area.max(1.0)).min(1.0);
                let (covariance, visible) = match (find.rim, refined) {
                    (Some(rim), _) => (rim.covariance, rim.visible),
                    (None, true) => (unrefined(find, track.diameter()), seen),
                    (None, false) => (ImageCovariance::isotropic(PAPER_SIGMA_PX), seen),
                };
                let variance = (covariance.uu + covariance.vv) * 0.5;
                if find.mode != Mode::Global && refined {
                    let expected = predicted.get(k).copied().flatten();
                    let carried = suggested(track, &places).map(|(place, _)| place);
                    track.judge_prediction(t_us, find.centre, variance, (expected, carried));
                } else {
                    track.forecast.interrupted();
                }
                let moves = find.mode != Mode::Global && find.score >= self.config.shape.doubtful_score;
                track.measured(t_us, find.centre, moves);
                track.settle(find.attempt, find.score);
                track.companions = places;
                if let Some(own) = track.companions.get_mut(k) {
                    *own = None;
                }
                *mode = find.mode;
                *score = find.score;
                track.known_to(libm::sqrtf(variance));
                *observation = Observation {
                    state: if find.whole { ObservationState::Visible } else { ObservationState::Occluded },
                    centre: find.centre,
                    diameter: track.diameter(),
                    covariance,
                    visible,
                };
                continue;
            }
            track.missing();
            *mode = Mode::Lost;
            let carried = if rigid { suggested(track, &places).map(|(p, _)| p) } else { None };
            let place = carried.or_else(|| predicted.get(k).copied().flatten());
            match (place, track.absent_us(t_us)) {
                (Some(centre), Some(absent)) if absent <= predict_us => {
                    *observation = Observation {
                        state: ObservationState::Predicted,
                        centre,
                        diameter: track.diameter(),
                        covariance: ImageCovariance::isotropic(match (refined, carried) {
                            (true, Some(_)) => track.carried_to(absent),
                            (true, None) => track.predicted_to(absent),
                            (false, _) => PREDICTED_SIGMA * track.clean.diameter,
                        }),
                        visible: 0.0,
                    };
                }
                (_, Some(_)) if !rigid => track.forget(),
                _ => {}
            }
        }
    }
}

/// How well a row-edge centre is known where the rim was refused.
fn unrefined(find: &Find, diameter: f32) -> ImageCovariance {
    let share = if find.whole { UNREFINED_SIGMA } else { UNREFINED_PART_SIGMA };
    ImageCovariance::isotropic(PAPER_SIGMA_PX + share * diameter)
}
