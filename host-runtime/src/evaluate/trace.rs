//! What a run leaves behind: every observation and pose beside its truth, small enough to keep.

use super::run::{RunError, Seen, Variant, run};
use super::sensor::Sensor;
use crate::comparison::relative;
use crate::pipeline::{CameraStep, HandStep};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::time::Duration;
use tetrad_core::hand::state::{PoseCovariance, PoseState};
use tetrad_core::observation::{BALLS, Observation};
use tetrad_fixtures::golden::Fnv1a;
use tetrad_fixtures::{BallTruth, HandTruth, Scene};

/// A scene to be tracked.
#[derive(Clone, Debug)]
pub struct Case {
    /// Tells it from every other case; the scene's seed depends on it.
    pub label: String,
    /// What is seen.
    pub scene: Scene,
    /// How many frames of it.
    pub frames: usize,
    /// What takes the pictures.
    pub sensor: Sensor,
    /// How it is tracked.
    pub variants: Vec<Variant>,
}

impl Case {
    /// A case of all frames of a scene. The scene's seed is made of `seed` and the label, so that no
    /// two cases share their noise and none changes when another is added.
    #[must_use]
    pub fn new(label: String, mut scene: Scene, seed: u64, variants: &[Variant]) -> Self {
        let mut hash = Fnv1a::default();
        hash.write(&seed.to_le_bytes());
        hash.write(label.as_bytes());
        scene.seed = hash.finish();
        let (frames, sensor) = (scene.frames(), Sensor::default());
        Self { label, frames, scene, sensor, variants: variants.to_vec() }
    }

    /// Pictures that have to be rendered.
    #[must_use]
    pub fn pictures(&self) -> usize {
        let cameras = self.variants.iter().map(|variant| variant.cameras).max().unwrap_or(0);
        self.frames * cameras.min(self.scene.cameras())
    }

    /// Runs it; `each` is called after every frame.
    ///
    /// # Errors
    /// As [`run`].
    pub fn trace(&self, mut each: impl FnMut()) -> Result<Vec<Trace>, RunError> {
        let mut traces: Vec<Trace> = self.variants.iter().map(|&variant| Trace::new(variant)).collect();
        run(&self.scene, self.frames, self.sensor, &self.variants, |seen| {
            for (index, trace) in traces.iter_mut().enumerate() {
                trace.add(index, seen);
            }
            each();
        })?;
        Ok(traces)
    }
}

/// One variant's results of a whole run.
#[derive(Clone, Debug)]
pub struct Trace {
    /// How it was tracked.
    pub variant: Variant,
    /// Every frame, in order.
    pub frames: Vec<TraceFrame>,
    /// The hand when its first pose was given: what poses are told from.
    engaged: Option<HandTruth>,
    /// The last frame with a motion.
    last: Option<HandTruth>,
}

/// One frame of a [`Trace`].
#[derive(Clone, Debug)]
pub struct TraceFrame {
    /// Seconds.
    pub t_s: f64,
    /// Each camera's balls.
    pub cameras: Vec<[BallTrace; BALLS]>,
    /// The hand; `None` when no hand was solved for.
    pub hand: Option<HandTrace>,
    /// How long rendering, each camera's tracker, and the hand took.
    pub times: Times,
}

/// One ball in one picture.
#[derive(Clone, Copy, Debug)]
pub struct BallTrace {
    /// What is true.
    pub truth: BallTruth,
    /// What was seen.
    pub seen: Observation,
}

impl BallTrace {
    /// Seen less true centre of the outline, pixels right and down.
    #[must_use]
    pub fn error_uv(&self) -> (f64, f64) {
        let (u, v) = self.truth.outline_centre;
        (f64::from(self.seen.centre.u) - u, f64::from(self.seen.centre.v) - v)
    }

    /// Its length, pixels.
    #[must_use]
    pub fn error_px(&self) -> f64 {
        let (u, v) = self.error_uv();
        u.hypot(v)
    }
}

/// The hand in one frame, all in the feature frame at engage.
#[derive(Clone, Copy, Debug)]
pub struct HandTrace {
    /// How the pose is known.
    pub state: PoseState,
    /// Where the red ball is, metres; before engage, nowhere.
    pub truth_m: Vector3<f64>,
    /// The pose's error; `None` without a pose.
    pub error: Option<PoseError>,
    /// The error of this frame's increment alpha, metres; `None` without a motion.
    pub step_error_m: Option<f64>,
}

impl HandTrace {
    /// The error of a pose that was measured in this frame: none that is carried on or held.
    #[must_use]
    pub fn measured(&self) -> Option<&PoseError> {
        self.error.as_ref().filter(|_| self.state.is_measured())
    }
}

/// Measured against true.
#[derive(Clone, Copy, Debug)]
pub struct PoseError {
    /// Measured less true place, metres.
    pub translation_m: Vector3<f64>,
    /// w of R_measured = exp(w) R_true, radians.
    pub rotation_rad: Vector3<f64>,
    /// What the tracker says of both.
    pub covariance: Option<PoseCovariance>,
}

/// How long the stages of one frame took.
#[derive(Clone, Debug)]
pub struct Times {
    /// Rendering all pictures.
    pub rendering: Duration,
    /// Each camera's tracker.
    pub tracking: Vec<Duration>,
    /// Solving for the hand.
    pub hand: Duration,
}

impl Trace {
    pub(super) const fn new(variant: Variant) -> Self {
        Self { variant, frames: Vec::new(), engaged: None, last: None }
    }

    fn add(&mut self, index: usize, seen: &Seen<'_>) {
        let step = &seen.steps[index];
        let camera = |(step, truths): (&CameraStep, &[BallTruth; BALLS])| {
            let mut seen = step.report.observations.iter();
            truths.map(|truth| BallTrace { truth, seen: seen.next().copied().unwrap_or_default() })
        };
        let hand = step.hand.as_ref().map(|hand| self.hand(hand, seen.hand));
        self.frames.push(TraceFrame {
            t_s: seen.t_s,
            cameras: step.cameras.iter().zip(seen.balls).map(camera).collect(),
            hand,
            times: Times {
                rendering: seen.rendering,
                tracking: step.cameras.iter().map(|camera| camera.tracking).collect(),
                hand: step.hand.map_or(Duration::ZERO, |hand| hand.solving),
            },
        });
    }

    fn hand(&mut self, step: &HandStep, now: &HandTruth) -> HandTrace {
        let report = &step.report;
        let mut trace = HandTrace {
            state: report.state,
            truth_m: Vector3::repeat(f64::NAN),
            error: None,
            step_error_m: None,
        };
        if let Some(pose) = &report.pose {
            let engaged = *self.engaged.get_or_insert(*now);
            let (rotation, translation) = relative(&engaged, now);
            let turn = pose.rotation.cast::<f64>() * rotation.transpose();
            trace.error = Some(PoseError {
                translation_m: pose.translation.cast::<f64>() - translation,
                rotation_rad: rotation_vector(&turn),
                covariance: report.covariance,
            });
        }
        if let Some(engaged) = &self.engaged {
            trace.truth_m = relative(engaged, now).1;
        }
        if let Ok(motion) = &report.motion
            && let Some(last) = self.last.replace(*now)
        {
            let (_, alpha) = relative(&last, now);
            trace.step_error_m = Some((motion.alpha.cast::<f64>() - alpha).norm());
        }
        trace
    }
}

/// The rotation vector of a matrix that is nearly a rotation.
fn rotation_vector(turn: &Matrix3<f64>) -> Vector3<f64> {
    Rotation3::from_matrix_eps(turn, 1e-12, 100, Rotation3::identity()).scaled_axis()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_seed_or_label_is_other_noise_and_the_same_is_the_same() {
        let seed = |label: &str, seed| {
            let scene = crate::evaluate::scenes::named("static-16px");
            Case::new(label.to_owned(), scene, seed, &[]).scene.seed
        };
        assert_eq!(seed("a", 3), seed("a", 3));
        assert_ne!(seed("a", 3), seed("a", 4));
        assert_ne!(seed("a", 3), seed("b", 3));
    }
}
