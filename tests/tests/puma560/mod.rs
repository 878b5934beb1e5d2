//! The tables of `hil-fixtures/data/puma560` and of the whole set they were taken from.
#![allow(dead_code, reason = "each test file uses its part")]

use nalgebra::{Matrix3, Vector3};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use tetrad_core::arm::puma560::{Fixed, Joints, Passages, Policy, Puma560};
use tetrad_core::config::PumaConfig;
use tetrad_core::geometry::Pose;
use tetrad_core::real::Real;

/// A table with named columns.
pub(crate) struct Table {
    pub(crate) columns: HashMap<String, usize>,
    pub(crate) rows: Vec<Vec<String>>,
}

/// One row of it.
pub(crate) struct Row<'a> {
    table: &'a Table,
    cells: &'a [String],
}

impl Table {
    pub(crate) fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut rows = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let head = rows.next().unwrap_or_else(|| panic!("{}: empty", path.display()));
        let columns = head.into_iter().enumerate().map(|(i, name)| (name, i)).collect();
        Self { columns, rows: rows.collect() }
    }

    pub(crate) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|cells| Row { table: self, cells })
    }
}

impl Row<'_> {
    pub(crate) fn text(&self, column: &str) -> &str {
        &self.cells[self.table.columns[column]]
    }

    pub(crate) fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap_or_else(|_| panic!("{column}: {:?}", self.text(column)))
    }

    pub(crate) fn joints(&self, prefix: &str) -> Joints<f64> {
        std::array::from_fn(|i| self.number(&format!("{prefix}q{}", i + 1)))
    }

    pub(crate) fn matrix(&self, prefix: &str) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.number(&format!("{prefix}{}{}", i + 1, j + 1)))
    }

    pub(crate) fn pose(&self) -> Pose<f64> {
        let translation = Vector3::from_fn(|i, _| self.number(&format!("T{}4", i + 1)));
        Pose { rotation: self.matrix("T"), translation }
    }

    pub(crate) fn name(&self) -> String {
        format!("row {} ({} {})", self.text("id"), self.text("kind"), self.text("tag"))
    }

    pub(crate) fn is(&self, kind: &str) -> bool {
        self.text("kind") == kind
    }

    /// Whether a factor of det J is 0, as exactly as it was computed.
    pub(crate) fn is_singular(&self) -> bool {
        self.is("singular") && !self.text("tag").contains("near")
            || self.is("named")
                && ["f_wrist", "f_elbow", "f_shoulder"].iter().any(|f| self.number(f).abs() < 1e-9)
    }
}

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
