//! The hand's pose in either mode, from any observations of any number of views at any time: latched,
//! followed, predicted, engaged anew.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::config::HandConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::tracker::{HandMode, HandTracker};
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::{ImageCovariance, Observation, ObservationState};

tetrad_no_panic::program!({
    if let Ok(arms) = Arms::new(black_box([0.08, 0.08, 0.08])) {
        let mode = black_box(HandMode::Refined);
        let mut hand = HandTracker::new(mode, arms, black_box(HandConfig::default()));
        let ball = Observation {
            state: ObservationState::Visible,
            centre: ImagePoint { u: 1.0, v: 2.0 },
            diameter: 9.0,
            covariance: ImageCovariance { uu: 1.0, uv: 0.0, vv: 1.0 },
            visible: 1.0,
        };
        let camera = CameraModel { width: 640, height: 480, focal_px: 800.0 };
        let three = [HandView { balls: [ball; 4], camera }; 3];
        let views: &[HandView] = black_box(&three);
        let _ = black_box(hand.update(views, black_box(1)));
        hand.engage();
        let _ = black_box(hand.update(black_box(views), black_box(2)));
        black_box(hand.predict(black_box(1), black_box(3)));
        hand.restart();
    }
});
