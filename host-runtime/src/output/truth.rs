//! `truth.csv` and `truth_pose.csv`: what a simulated scene knows of itself.

use super::csv::{CsvFile, OutputError};
use nalgebra::{Matrix3, Vector3};
use std::path::Path;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_fixtures::BallTruth;

/// `truth.csv`: `frame,t,camera,ball,u,v,diameter,visible` (pixels; the outline's centre and
/// diameter, and the share of it in sight, 0 to 1). `truth_pose.csv`: the columns of pose.csv
/// without the state.
#[derive(Debug)]
pub struct TruthCsv {
    balls: CsvFile,
    pose: CsvFile,
}

impl TruthCsv {
    /// Creates the files in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] naming the file that cannot be created.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        let pose = "frame,t,x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33";
        Ok(Self {
            balls: CsvFile::create(dir, "truth.csv", "frame,t,camera,ball,u,v,diameter,visible")?,
            pose: CsvFile::create(dir, "truth_pose.csv", pose)?,
        })
    }

    /// Adds what is true of one camera's picture.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn balls(
        &mut self,
        (frame, t_s): (u64, f64),
        camera: &str,
        truths: &[BallTruth; BALLS],
    ) -> Result<(), OutputError> {
        for (ball, truth) in Ball::ALL.into_iter().zip(truths) {
            self.balls.row(|row| {
                row.field(frame).time(t_s).field(camera).field(ball.name());
                let (u, v) = truth.outline_centre;
                row.number(u as f32).number(v as f32).number(truth.diameter as f32);
                row.number(truth.visible_fraction as f32);
            })?;
        }
        Ok(())
    }

    /// Adds the hand's pose in the feature frame of the first frame.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn pose(
        &mut self,
        (frame, t_s): (u64, f64),
        (rotation, translation): &(Matrix3<f64>, Vector3<f64>),
    ) -> Result<(), OutputError> {
        self.pose.row(|row| {
            row.field(frame).time(t_s);
            for &value in translation.iter().chain(rotation.transpose().iter()) {
                row.number(value as f32);
            }
        })
    }
}
