//! `observations.csv` and `uncertainty.csv`: one row a ball, camera and frame.

use super::csv::{CsvFile, OutputError};
use crate::balls::BallSet;
use std::path::Path;
use tetrad_core::observation::{ObservationState, Observations};

/// `frame,t,camera,ball,u,v,diameter,state`: pixels; `u`, `v` and `diameter` empty when lost.
#[derive(Debug)]
pub struct ObservationsCsv(CsvFile);

impl ObservationsCsv {
    /// Creates the file in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        CsvFile::create(dir, "observations.csv", "frame,t,camera,ball,u,v,diameter,state").map(Self)
    }

    /// Adds one picture's rows: the tracked balls in the paper's order.
    ///
    /// # Errors
    /// [`OutputError`] when they cannot be written.
    pub fn write(
        &mut self,
        (frame, t_s): (u64, f64),
        camera: &str,
        balls: BallSet,
        observations: &Observations,
    ) -> Result<(), OutputError> {
        for ball in balls.iter() {
            let seen = &observations[ball.index()];
            self.0.row(|row| {
                row.field(frame).time(t_s).field(camera).field(ball.name());
                if seen.state == ObservationState::Lost {
                    row.empty().empty().empty();
                } else {
                    row.number(seen.centre.u).number(seen.centre.v).number(seen.diameter);
                }
                row.field(seen.state.name());
            })?;
        }
        Ok(())
    }
}

/// `frame,t,camera,ball,uu,uv,vv,visible`: the covariance of the centre in px^2 and the share of the rim
/// that was seen; the covariance empty when lost.
#[derive(Debug)]
pub struct UncertaintyCsv(CsvFile);

impl UncertaintyCsv {
    /// Creates the file in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        CsvFile::create(dir, "uncertainty.csv", "frame,t,camera,ball,uu,uv,vv,visible").map(Self)
    }

    /// Adds one picture's rows: the tracked balls in the paper's order.
    ///
    /// # Errors
    /// [`OutputError`] when they cannot be written.
    pub fn write(
        &mut self,
        (frame, t_s): (u64, f64),
        camera: &str,
        balls: BallSet,
        observations: &Observations,
    ) -> Result<(), OutputError> {
        for ball in balls.iter() {
            let seen = &observations[ball.index()];
            self.0.row(|row| {
                row.field(frame).time(t_s).field(camera).field(ball.name());
                if seen.state == ObservationState::Lost {
                    row.empty().empty().empty();
                } else {
                    let covariance = seen.covariance;
                    row.number(covariance.uu).number(covariance.uv).number(covariance.vv);
                }
                row.number(seen.visible);
            })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::geometry::ImagePoint;
    use tetrad_core::observation::{ImageCovariance, Observation};

    #[test]
    fn a_lost_ball_has_no_place_and_an_untracked_ball_no_row() {
        let dir = tempfile::tempdir().unwrap();
        let mut csv = ObservationsCsv::create(dir.path()).unwrap();
        let mut seen = Observations::default();
        seen[0] = Observation {
            state: ObservationState::Visible,
            centre: ImagePoint::new(12.25, 7.0),
            diameter: 16.5,
            covariance: ImageCovariance { uu: 0.25, uv: -0.125, vv: 0.5 },
            visible: 0.75,
        };
        seen[3].centre = ImagePoint::new(5.0, 5.0);
        let balls: BallSet = "red,yellow".parse().unwrap();
        csv.write((7, 0.25), "left", balls, &seen).unwrap();
        UncertaintyCsv::create(dir.path()).unwrap().write((7, 0.25), "left", balls, &seen).unwrap();
        assert_eq!(
            std::fs::read_to_string(dir.path().join("uncertainty.csv")).unwrap(),
            "frame,t,camera,ball,uu,uv,vv,visible\n\
             7,0.250000,left,red,0.25,-0.125,0.5,0.75\n\
             7,0.250000,left,yellow,,,,0\n"
        );
        assert_eq!(
            std::fs::read_to_string(dir.path().join("observations.csv")).unwrap(),
            "frame,t,camera,ball,u,v,diameter,state\n\
             7,0.250000,left,red,12.25,7,16.5,visible\n\
             7,0.250000,left,yellow,,,,lost\n"
        );
    }
}
