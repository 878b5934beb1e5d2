//! `pose.csv`, `filtered.csv`, `pose_covariance.csv` and `motion.csv`: where the hand is, as measured
//! and as filtered, how well that is known, and how it moved, one row a frame.

use super::csv::{CsvFile, OutputError, Row};
use nalgebra::Matrix3;
use std::path::Path;
use tetrad_core::geometry::Pose;
use tetrad_core::hand::motion::Motion;
use tetrad_core::hand::state::{PoseCovariance, PoseState};

/// `frame,t,x,y,z,r11..r33,state`: metres, in the feature frame of the first complete frame; empty
/// while there has been none.
#[derive(Debug)]
pub struct PoseCsv(CsvFile);

impl PoseCsv {
    /// Creates the file in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        Self::named(dir, "pose.csv")
    }

    /// Creates filtered.csv, which has the same columns: the pose smoothed and carried on.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created.
    pub fn create_filtered(dir: &Path) -> Result<Self, OutputError> {
        Self::named(dir, "filtered.csv")
    }

    fn named(dir: &Path, name: &str) -> Result<Self, OutputError> {
        CsvFile::create(dir, name, "frame,t,x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33,state").map(Self)
    }

    /// Adds one frame: the pose, and how it is known.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn write(
        &mut self,
        (frame, t_s): (u64, f64),
        pose: Option<&Pose>,
        state: PoseState,
    ) -> Result<(), OutputError> {
        self.0.row(|row| {
            row.field(frame).time(t_s);
            twelve(row, pose.map(|pose| (pose.translation.as_ref(), &pose.rotation)));
            row.field(state.name());
        })
    }
}

/// `frame,t,residual_px,c11..c66`: how well the pose is known: the root mean square of measured minus
/// projected in px, and the upper triangle of its covariance row by row ([`PoseCovariance`]: metres,
/// then radians); empty where nothing is said about it.
#[derive(Debug)]
pub struct PoseCovarianceCsv(CsvFile);

impl PoseCovarianceCsv {
    /// Creates the file in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        let places = upper_triangle().map(|(i, j)| format!(",c{}{}", i + 1, j + 1));
        let header = format!("frame,t,residual_px{}", places.collect::<String>());
        CsvFile::create(dir, "pose_covariance.csv", &header).map(Self)
    }

    /// Adds one frame.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn write(
        &mut self,
        (frame, t_s): (u64, f64),
        residual_px: Option<f32>,
        covariance: Option<&PoseCovariance>,
    ) -> Result<(), OutputError> {
        self.0.row(|row| {
            row.field(frame).time(t_s).number(residual_px.unwrap_or(f32::NAN));
            for place in upper_triangle() {
                row.number(covariance.map_or(f32::NAN, |covariance| covariance[place]));
            }
        })
    }
}

fn upper_triangle() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|i| (i..6).map(move |j| (i, j)))
}

/// `frame,t,a1,a2,a3,phi11..phi33`: the paper's differential alpha in metres and Phi, since the last
/// complete frame; empty where the frame gave no motion.
#[derive(Debug)]
pub struct MotionCsv(CsvFile);

impl MotionCsv {
    /// Creates the file in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        let header = "frame,t,a1,a2,a3,phi11,phi12,phi13,phi21,phi22,phi23,phi31,phi32,phi33";
        CsvFile::create(dir, "motion.csv", header).map(Self)
    }

    /// Adds one frame.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn write(&mut self, (frame, t_s): (u64, f64), motion: Option<&Motion>) -> Result<(), OutputError> {
        self.0.row(|row| {
            row.field(frame).time(t_s);
            twelve(row, motion.map(|motion| (motion.alpha.as_ref(), &motion.phi)));
        })
    }
}

/// Three of a vector and nine of a matrix row by row, or as many empty fields.
fn twelve(row: &mut Row<'_>, values: Option<(&[f32; 3], &Matrix3<f32>)>) {
    match values {
        Some((vector, matrix)) => {
            // nalgebra iterates column by column: of the transpose that is row by row
            for &value in vector.iter().chain(matrix.transpose().iter()) {
                row.number(value);
            }
        }
        None => (0..12).for_each(|_| {
            row.empty();
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_pose_is_written_row_by_row_and_an_unknown_one_left_empty() {
        let dir = tempfile::tempdir().unwrap();
        let mut csv = PoseCsv::create(dir.path()).unwrap();
        let pose = Pose {
            rotation: Matrix3::new(11.0, 12.0, 13.0, 21.0, 22.0, 23.0, 31.0, 32.0, 33.0),
            translation: Vector3::new(0.1, -0.2, 0.3),
        };
        csv.write((0, 0.0), None, PoseState::Lost).unwrap();
        csv.write((1, 0.1), Some(&pose), PoseState::Both).unwrap();
        assert_eq!(
            std::fs::read_to_string(dir.path().join("pose.csv")).unwrap(),
            "frame,t,x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33,state\n\
             0,0.000000,,,,,,,,,,,,,lost\n\
             1,0.100000,0.1,-0.2,0.3,11,12,13,21,22,23,31,32,33,both\n"
        );
    }

    #[test]
    fn a_covariance_is_its_upper_triangle_and_one_that_is_not_told_is_left_empty() {
        let dir = tempfile::tempdir().unwrap();
        let mut csv = PoseCovarianceCsv::create(dir.path()).unwrap();
        let mut covariance = PoseCovariance::zeros();
        covariance[(0, 5)] = 0.25;
        covariance[(5, 5)] = 4.0;
        csv.write((1, 0.5), Some(0.125), Some(&covariance)).unwrap();
        csv.write((2, 1.0), None, None).unwrap();
        let text = std::fs::read_to_string(dir.path().join("pose_covariance.csv")).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("frame,t,residual_px,c11,c12,") && lines[0].ends_with(",c55,c56,c66"));
        assert!(lines[1].starts_with("1,0.500000,0.125,0,0,0,0,0,0.25,0,") && lines[1].ends_with(",0,4"));
        assert_eq!(lines[2], format!("2,1.000000{}", ",".repeat(22)));
        assert!(lines.iter().all(|line| line.split(',').count() == 24));
    }

    #[test]
    fn motion_has_fourteen_columns_known_or_not() {
        let dir = tempfile::tempdir().unwrap();
        let mut csv = MotionCsv::create(dir.path()).unwrap();
        let motion = Motion {
            alpha: Vector3::new(1e-3, 0.0, -2e-9),
            phi: Matrix3::identity(),
            since_engage: Pose::identity(),
            engagements: 0,
            residual_px: 0.1,
            spans: 1,
        };
        csv.write((4, 2.0), Some(&motion)).unwrap();
        csv.write((5, 2.5), None).unwrap();
        let text = std::fs::read_to_string(dir.path().join("motion.csv")).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "4,2.000000,0.001,0,-0.000000002,1,0,0,0,1,0,0,0,1");
        assert_eq!(lines[2], "5,2.500000,,,,,,,,,,,,");
        assert!(lines.iter().all(|line| line.split(',').count() == 14));
    }
}
