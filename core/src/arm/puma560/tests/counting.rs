//! Joints as counts.

use super::super::{BeyondCounts, Drives};
use super::joints;
use crate::config::DrivesConfig;
use proptest::prelude::*;
use std::string::ToString;

fn drives() -> Drives {
    Drives::new(&DrivesConfig::default()).expect("the default")
}

proptest! {
    /// Half a count of the joint's own encoder, and what the coupling carries of half a count of each
    /// earlier one.
    #[test]
    fn counts_give_back_the_joints(joints in joints()) {
        let drives = drives();
        let half = drives.resolution::<f64>().map(|count| count / 2.0);
        let read = drives.joints::<f64>(&drives.counts(&joints).unwrap());
        for (i, (read, joint)) in read.iter().zip(&joints).enumerate() {
            let row = drives.config().coupling[i];
            let bound = half[i] + row.iter().zip(&half).map(|(c, h)| c.abs() * h).sum::<f64>();
            prop_assert!((read - joint).abs() <= bound * 1.000_001, "joint {}", i + 1);
        }
    }

    #[test]
    fn every_count_is_met_exactly(counts in proptest::array::uniform6(-100_000..100_000i32)) {
        let drives = drives();
        prop_assert_eq!(drives.counts(&drives.joints::<f64>(&counts)), Ok(counts));
    }

    #[test]
    fn single_precision_is_within_a_count(joints in joints()) {
        let drives = drives();
        let fine = drives.counts(&joints).unwrap();
        let coarse = drives.counts(&joints.map(|angle| angle as f32)).unwrap();
        prop_assert!(fine.iter().zip(&coarse).all(|(a, b)| (a - b).abs() <= 1), "{fine:?} {coarse:?}");
    }
}

/// The public driver's lines: q5 -= 0.0139037 q4m; q6 -= -0.0130401 q4m + 0.180556 q5m.
#[test]
fn the_wrist_is_coupled_as_on_a_real_arm() {
    let drives = drives();
    let turned = drives.joints::<f64>(&[0, 0, 0, 121_016, 0, 0]);
    for (got, want) in turned.iter().zip([0.0, 0.0, 0.0, 10.0, -0.139_037, 0.130_401]) {
        assert!((got - want).abs() < 1e-12, "{turned:?}");
    }
    let turned = drives.joints::<f64>(&[0, 0, 0, 0, 114_469, 0]);
    for (got, want) in turned.iter().zip([0.0, 0.0, 0.0, 0.0, 10.0, -1.805_56]) {
        assert!((got - want).abs() < 1e-5, "{turned:?}");
    }
}

#[test]
fn zero_and_sense_are_configuration() {
    let mut config = DrivesConfig::default();
    config.drives[1].zero_counts = 5_000;
    config.drives[1].counts_per_rad = -1_000.0;
    let drives = Drives::new(&config).unwrap();
    assert_eq!(drives.counts(&[0.0; 6]), Ok([0, 5_000, 0, 0, 0, 0]));
    assert_eq!(drives.counts(&[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]), Ok([0, 4_000, 0, 0, 0, 0]));
    assert_eq!(drives.joints::<f64>(&[0, 3_000, 0, 0, 0, 0])[1], 2.0);
}

#[test]
fn what_no_encoder_shows_is_refused_by_joint() {
    let drives = drives();
    for (at, angle) in [(0, f64::NAN), (2, f64::INFINITY), (3, 1e9), (5, -1e300)] {
        let mut joints = [0.0; 6];
        joints[at] = angle;
        assert_eq!(drives.counts(&joints), Err(BeyondCounts(at as u8 + 1)));
    }
    let text = "joint 3: no 32-bit count stands for this angle; check the counts a radian";
    assert_eq!(BeyondCounts(3).to_string(), text);
}
