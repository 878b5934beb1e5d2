//! The hand's motion and its prediction from any observations of any number of views; places and
//! orientation by themselves.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::config::HandConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::{AffineFrame, Arms};
use tetrad_core::hand::motion::MotionTracker;
use tetrad_core::observation::{ImageCovariance, Observation, ObservationState};

tetrad_no_panic::program!({
    if let Ok(arms) = Arms::new(black_box([0.08, 0.08, 0.08])) {
        let mut hand = MotionTracker::new(arms, black_box(HandConfig::default()));
        let views: &[[Observation; 4]] = black_box(
            &[[Observation {
                state: ObservationState::Visible,
                centre: ImagePoint { u: 1.0, v: 2.0 },
                diameter: 9.0,
                covariance: ImageCovariance { uu: 1.0, uv: 0.0, vv: 1.0 },
                visible: 1.0,
            }; 4]; 3],
        );
        let _ = black_box(hand.update(views));
        hand.engage();
        let _ = black_box(hand.update(black_box(views)));
        black_box(hand.predict(black_box(1)));
        hand.restart();

        let points: &[ImagePoint] = black_box(&[ImagePoint { u: 1.0, v: 2.0 }; 4]);
        let views: &[[ImagePoint; 4]] = black_box(&[[ImagePoint { u: 3.0, v: 4.0 }; 4]; 3]);
        if let Ok(frame) = AffineFrame::new(views, arms, black_box(&HandConfig::default())) {
            let _ = black_box(frame.locate(points));
        }
    }
});
