//! The tables of `hil-fixtures/data/puma560` and of the whole set they were taken from.
#![allow(dead_code, reason = "each test file uses its part")]

use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tetrad_core::arm::puma560::{Fixed, Joints, Passages, Policy, Puma560};
use tetrad_core::config::PumaConfig;
use tetrad_core::geometry::Pose;
use tetrad_core::real::Real;
use tetrad_fixtures::puma560::Table;

/// The folders that can be compared with: the repository's own, and the whole set if it is there.
pub(crate) fn folders(test: &str) -> Vec<PathBuf> {
    let mut folders = vec![tetrad_fixtures::golden::data("puma560")];
    match tetrad_tests::shared() {
        Some(shared) => folders.push(shared.join("data/puma560")),
        None => tetrad_tests::skip(
            &format!("{test} (all rows)"),
            "no shared data; name its folder in TETRAD_SHARED",
        ),
    }
    folders
}

pub(crate) fn tables(test: &str, file: &str) -> Vec<Table> {
    folders(test).iter().map(|folder| Table::read(&folder.join(file))).collect()
}

/// The arm of the data has no tool.
pub(crate) fn arm<T: Real>() -> Puma560<T> {
    Puma560::new(&PumaConfig::bare()).expect("the default")
}

/// The largest difference, metres and entries of the rotation.
pub(crate) fn apart(a: &Pose<f64>, b: &Pose<f64>) -> f64 {
    (a.rotation - b.rotation).amax().max((a.translation - b.translation).amax())
}

/// The largest difference, whole turns aside, radians.
pub(crate) fn turned(a: &Joints<f64>, b: &Joints<f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).sin().atan2((a - b).cos()).abs()).fold(0.0, f64::max)
}

pub(crate) fn single(pose: &Pose<f64>) -> Pose<f32> {
    Pose { rotation: pose.rotation.cast(), translation: pose.translation.cast() }
}

/// One step of a track: the pose it leads to and the joints.
pub(crate) type Step = (Pose<f64>, Joints<f64>);

/// The tracks of a folder by name. The poses are added up from the increments: X + alpha, M Phi.
pub(crate) fn tracks(folder: &Path) -> BTreeMap<String, Vec<Step>> {
    let mut tracks: BTreeMap<String, Vec<Step>> = BTreeMap::new();
    for row in Table::read(&folder.join("tracks.csv")).rows() {
        let track = tracks.entry(format!("{} {}", row.text("track"), row.text("tag"))).or_default();
        let joints = row.joints("");
        let pose = match track.last() {
            None => arm::<f64>().forward(&joints),
            Some((last, _)) => Pose {
                rotation: last.rotation * row.matrix("P"),
                translation: last.translation + Vector3::from_fn(|i, _| row.number(&format!("a{}", i + 1))),
            },
        };
        track.push((pose, joints));
    }
    tracks
}

pub(crate) const ALL_PASSAGES: Policy = Policy {
    fixed: Fixed { shoulder: None, elbow: None, wrist: None },
    passages: Passages::ALL,
    jump: false,
};
