//! Any numbers whatever are taken or refused, never anything else.

use super::simulated::{demo, pair};
use super::tally::after;
use crate::geometry::ImagePoint;
use crate::hand::synthetic::number;
use crate::hand::view::{CameraModel, HandView};
use crate::observation::{ImageCovariance, Observation, ObservationState};
use proptest::prelude::*;
use std::vec::Vec;

proptest! {
    #[test]
    fn is_taken_or_refused(
        values in prop::collection::vec(number(), 6 * 24),
        states in prop::collection::vec(0_u8..4, 24),
        focal_px in number(),
    ) {
        let eyes = pair(30.0);
        let (mut tracker, _) = after(&eyes, demo, 3);
        for (frame, (values, states)) in values.chunks(48).zip(states.chunks(8)).enumerate() {
            let views: Vec<HandView> = values
                .chunks(24)
                .zip(states.chunks(4))
                .map(|(values, states)| HandView {
                    balls: core::array::from_fn(|i| {
                        let v = &values[6 * i..];
                        Observation {
                            state: [ObservationState::Visible, ObservationState::Occluded,
                                ObservationState::Visible, ObservationState::Lost][usize::from(states[i])],
                            centre: ImagePoint::new(v[0], v[1]),
                            diameter: v[2],
                            covariance: ImageCovariance { uu: v[3], uv: v[4], vv: v[5] },
                            visible: 1.0,
                        }
                    }),
                    camera: CameraModel { width: 640, height: 480, focal_px },
                })
                .collect();
            let report = tracker.update(&views, (frame as u64 + 3) * 33_333);
            if let Some(pose) = report.pose {
                prop_assert!(pose.translation.iter().chain(pose.rotation.iter()).all(|x| x.is_finite()));
                prop_assert!(report.covariance.unwrap().iter().all(|x| x.is_finite()));
            }
            tracker.engage();
        }
    }
}
