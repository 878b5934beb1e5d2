//! What the tracker's promises share: a scene is rendered, its balls are taught from the first frame,
//! and every frame is tracked beside its truth.
#![allow(dead_code, reason = "each test file uses its part")]

use tetrad_core::config::TrackerConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball, Observation, ObservationState};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::{Primary, Reference};
use tetrad_core::vision::frame::{FrameView, PixelFormat, Rgb};
use tetrad_core::vision::tracker::{CameraTracker, StepReport};
use tetrad_fixtures::{BallTruth, Scene};

/// A scene by name.
pub(crate) fn scene(name: &str) -> Scene {
    Scene::named(name).unwrap_or_else(|| panic!("there is no scene {name}"))
}

/// One frame of one camera as it was tracked, beside what is true.
pub(crate) struct Tracked {
    /// The number of the frame.
    pub(crate) frame: usize,
    /// Where the balls are.
    pub(crate) truth: [BallTruth; BALLS],
    /// What the tracker says.
    pub(crate) report: StepReport,
}

impl Tracked {
    /// What is true of a ball, and what was seen of it.
    pub(crate) fn ball(&self, ball: Ball) -> (&BallTruth, &Observation) {
        (&self.truth[ball.index()], &self.report.observations[ball.index()])
    }

    /// The distance of a ball's observation from the centre of its outline, pixels.
    pub(crate) fn error_px(&self, ball: Ball) -> f64 {
        self.distance_px(ball, ball)
    }

    /// The distance of a ball's observation from the outline of another, pixels.
    pub(crate) fn distance_px(&self, ball: Ball, other: Ball) -> f64 {
        let (u, v) = self.truth[other.index()].outline_centre;
        let seen = self.report.observations[ball.index()].centre;
        (f64::from(seen.u) - u).hypot(f64::from(seen.v) - v)
    }

    /// Whether a ball is measured, and measured where it is: within a quarter of its diameter, or
    /// 2 px where that is more; within half of it where a part of the ball is hidden.
    pub(crate) fn holds(&self, ball: Ball) -> bool {
        let (truth, seen) = self.ball(ball);
        let share = if seen.state == ObservationState::Visible { 4.0 } else { 2.0 };
        seen.state.is_measured() && self.error_px(ball) <= (truth.diameter / share).max(2.0)
    }
}

/// Tracks every frame of one camera, in order.
pub(crate) fn track(scene: &Scene, camera: usize, mut each: impl FnMut(&Tracked)) {
    let mut rgb = Vec::new();
    scene.render_rgb(0, camera, &mut rgb);
    let mut tracker = taught(&view(scene, &rgb), &scene.truth(0, camera));
    for frame in 0..scene.frames() {
        scene.render_rgb(frame, camera, &mut rgb);
        let report = tracker.step(&view(scene, &rgb), time_us(scene, frame), &[None; BALLS]);
        each(&Tracked { frame, truth: scene.truth(frame, camera), report });
    }
}

/// A rendered picture as the tracker takes it.
pub(crate) fn view<'a>(scene: &Scene, rgb: &'a [u8]) -> FrameView<'a> {
    FrameView::packed(rgb, scene.width, scene.height, PixelFormat::Rgb888).expect("a rendered frame is whole")
}

/// The time of a frame, microseconds.
pub(crate) fn time_us(scene: &Scene, frame: usize) -> u64 {
    (scene.time_s(frame) * 1e6).round() as u64
}

/// A tracker that has been taught the four balls where they are in the first frame.
pub(crate) fn taught(view: &FrameView<'_>, first: &[BallTruth; BALLS]) -> CameraTracker {
    let balls = Ball::ALL.map(|ball| Some(learnt(view, ball, &first[ball.index()])));
    let config = TrackerConfig::default();
    let mut tracker = CameraTracker::new(config, balls).expect("the balls of a scene can be tracked");
    for (ball, truth) in Ball::ALL.into_iter().zip(first) {
        tracker.place(ball, centre(truth));
    }
    tracker
}

/// The centre of a ball's outline.
pub(crate) fn centre(truth: &BallTruth) -> ImagePoint {
    ImagePoint::new(truth.outline_centre.0 as f32, truth.outline_centre.1 as f32)
}

/// A ball's colours as the mean of its inner half and of the ring around it.
fn learnt(view: &FrameView<'_>, ball: Ball, truth: &BallTruth) -> LearntBall {
    let ball_colour = mean_colour(view, truth, 0.0, 0.6);
    let reference = Reference {
        primary: Primary::of(ball),
        reference: ball_colour,
        typical: ball_colour,
        background: mean_colour(view, truth, 1.5, 2.0),
    };
    LearntBall { reference, diameter: truth.diameter as f32, aspect: 1.0 }
}

/// The mean colour of the pixels between two distances from a ball's centre, in its radii.
fn mean_colour(view: &FrameView<'_>, truth: &BallTruth, from: f64, to: f64) -> Rgb {
    let (u, v) = truth.outline_centre;
    let radius = truth.diameter / 2.0;
    let reach = (to * radius).ceil() as i32 + 1;
    let mut sum = [0_u64; 3];
    let mut count = 0;
    for y in v as i32 - reach..=v as i32 + reach {
        for x in u as i32 - reach..=u as i32 + reach {
            let distance = (f64::from(x) - u).hypot(f64::from(y) - v) / radius;
            if (from..=to).contains(&distance)
                && let Some(p) = view.pixel(x, y)
            {
                sum.iter_mut().zip([p.r, p.g, p.b]).for_each(|(s, c)| *s += u64::from(c));
                count += 1;
            }
        }
    }
    let [r, g, b] = sum.map(|s| (s / count) as u8);
    Rgb::new(r, g, b)
}
