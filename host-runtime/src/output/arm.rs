//! `arm.csv`: what the arm was told, what it did and why, one row a cycle.

use super::aside::Aside;
use super::csv::{CsvFile, OutputError, Row};
use crate::station::Cycle;
use std::path::Path;
use tetrad_core::geometry::Pose;

/// `t,state,change,limits,share,age_ms,s1..s6,q1..q6,x,y,z,r11..r33,mx,my,mz`: seconds; the law's state; how
/// the arm stood and stands now where that changed; the names of what limits the arm with a space between them (a joint's number behind it); the share of
/// its speed that it may use; the age of the newest command; set-points and measured joints in
/// radians; the tool as it was sent, and where it was measured to be, metres in the robot's base.
/// What is not known is empty.
#[derive(Debug)]
pub struct ArmCsv(CsvFile);

impl ArmCsv {
    /// Creates the file in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        let header = "t,state,change,limits,share,age_ms,s1,s2,s3,s4,s5,s6,q1,q2,q3,q4,q5,q6,x,y,z,\
                      r11,r12,r13,r21,r22,r23,r31,r32,r33,mx,my,mz";
        CsvFile::create(dir, "arm.csv", header).map(Self)
    }

    /// Adds one cycle.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn write(&mut self, t_s: f64, cycle: &Cycle) -> Result<(), OutputError> {
        let step = &cycle.step;
        let governed = step.governed.as_ref();
        self.0.row(|row| {
            row.time(t_s).field(step.decision.status.state().name());
            let change = governed.and_then(|governed| governed.change);
            match change {
                Some(change) => row.field(format_args!("{} {}", change.from.code(), change.to.code())),
                None => row.empty(),
            };
            let limits = governed.map(|governed| governed.limits).unwrap_or_default();
            let names = limits.iter().map(|limit| match limit.joint() {
                Some(joint) => format!("{}_{joint}", limit.name()),
                None => limit.name().to_owned(),
            });
            row.field(names.collect::<Vec<_>>().join(" "));
            numbers(row, governed.map(|governed| [governed.speed_share]));
            numbers(row, step.decision.command_age_us.map(|us| [us as f64 / 1e3]));
            numbers(row, governed.map(|governed| governed.set_point));
            numbers(row, cycle.reading.joints.map(|reading| reading.joints));
            numbers(row, governed.map(|governed| twelve(&governed.pose)));
            numbers(row, step.measured.map(|pose| pose.translation.into()));
        })
    }
}

/// So many cycles wait for the disk at most: ten seconds at the usual rate.
const WAITING: usize = 1_024;

/// [`ArmCsv`] on a thread of its own, for an arm that cannot wait for a disk.
#[derive(Debug)]
pub struct ArmRecord(Aside<(f64, Cycle)>);

impl ArmRecord {
    /// Creates the file in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created, or the system has no thread left.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        let mut csv = ArmCsv::create(dir)?;
        let aside = Aside::start(WAITING, move |(t_s, cycle): &(f64, Cycle)| csv.write(*t_s, cycle));
        aside.map(Self).map_err(|cause| OutputError { path: dir.join("arm.csv"), cause })
    }

    /// Hands one cycle over; never waits.
    ///
    /// # Errors
    /// [`OutputError`] when one before could not be written: there will be no more.
    pub fn write(&mut self, t_s: f64, cycle: &Cycle) -> Result<(), OutputError> {
        self.0.put((t_s, *cycle))
    }

    /// Waits until all is written; a line where not all of it is there.
    pub fn end(&mut self) -> Option<String> {
        match self.0.end() {
            Ok(0) => None,
            Ok(lost) => Some(format!("arm.csv lacks {lost} cycles: the disk was too slow")),
            Err(error) => Some(format!("{:#}", anyhow::Error::new(error))),
        }
    }
}

/// x, y, z, then the rotation row by row.
fn twelve(pose: &Pose<f64>) -> [f64; 12] {
    let (x, r) = (&pose.translation, &pose.rotation);
    [x.x, x.y, x.z, r.m11, r.m12, r.m13, r.m21, r.m22, r.m23, r.m31, r.m32, r.m33]
}

/// So many numbers, or so many empty fields.
fn numbers<const N: usize>(row: &mut Row<'_>, values: Option<[f64; N]>) {
    for at in 0..N {
        match values.as_ref().and_then(|values| values.get(at)) {
            // -0 is written as 0
            Some(value) if value.is_finite() => row.field(value + 0.0),
            _ => row.empty(),
        };
    }
}
