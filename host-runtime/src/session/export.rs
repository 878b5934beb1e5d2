//! The recorded channels as CSV, as they are in the file: nothing is computed anew.

use super::convert;
use super::error::SessionError;
use super::reader::{Entry, Reader};
use super::schema::foxglove::Log;
use super::schema::tetrad as msg;
use super::topic::Topic;
use crate::balls::BallSet;
use crate::output::{CsvFile, ObservationsCsv, OutputError, PoseCsv, Row, UncertaintyCsv};
use std::path::{Path, PathBuf};

/// The recorded channels on their way into a folder; a file is made where there is something for it.
pub struct Export {
    dir: PathBuf,
    names: Vec<String>,
    balls: BallSet,
    seen: Option<(ObservationsCsv, UncertaintyCsv)>,
    hand: Option<(PoseCsv, PoseCsv)>,
    command: Option<CsvFile>,
    buttons: Option<CsvFile>,
    arm: Option<CsvFile>,
    delays: Option<CsvFile>,
    log: Option<CsvFile>,
}

/// Why a session cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// It cannot be read.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Writes what is in the session into `dir`, which must be there: observations.csv, uncertainty.csv,
/// pose.csv, filtered.csv, command.csv, buttons.csv, arm.csv, delays.csv and log.csv, those of them that
/// there is something for.
///
/// # Errors
/// [`ExportError`].
pub fn export(reader: &mut Reader, dir: &Path) -> Result<(), ExportError> {
    let mut export = Export::new(reader, dir);
    while let Some(entry) = reader.next_entry()? {
        export.take(reader, &entry)?;
    }
    Ok(())
}

fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

/// `n` columns called `name1`, `name2` ...
fn numbered(name: &str, n: usize) -> String {
    (1..=n).map(|at| format!(",{name}{at}")).collect()
}

/// So many numbers, empty where they are missing.
fn numbers(row: &mut Row<'_>, values: &[f32], n: usize) {
    for at in 0..n {
        row.number(values.get(at).copied().unwrap_or(f32::NAN));
    }
}

/// Words in a field: without what would end it.
fn words(text: &str) -> String {
    text.replace([',', '\n', '\r', '"'], ";")
}

const POSE: &str = "x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33";

impl Export {
    /// Into `dir`, which must be there.
    #[must_use]
    pub fn new(reader: &Reader, dir: &Path) -> Self {
        Self {
            dir: dir.to_owned(),
            names: reader.names().to_vec(),
            balls: reader.beginning().balls(),
            seen: None,
            hand: None,
            command: None,
            buttons: None,
            arm: None,
            delays: None,
            log: None,
        }
    }

    /// Writes the next message.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn take(&mut self, reader: &Reader, entry: &Entry) -> Result<(), ExportError> {
        let t_s = seconds(entry.time_us);
        match entry.topic {
            Topic::Observations(camera) => {
                let seen: msg::Observations = reader.decode(entry)?;
                if self.seen.is_none() {
                    let both = (ObservationsCsv::create(&self.dir)?, UncertaintyCsv::create(&self.dir)?);
                    self.seen = Some(both);
                }
                let name = self.names.get(camera).map_or("camera", String::as_str);
                let balls = convert::observations(&seen.balls);
                if let Some((observations, uncertainty)) = &mut self.seen {
                    observations.write((seen.frame, t_s), name, self.balls, &balls)?;
                    uncertainty.write((seen.frame, t_s), name, self.balls, &balls)?;
                }
            }
            Topic::Hand => {
                let hand: msg::Hand = reader.decode(entry)?;
                if self.hand.is_none() {
                    self.hand = Some((PoseCsv::create(&self.dir)?, PoseCsv::create_filtered(&self.dir)?));
                }
                let state = convert::pose_state(hand.state);
                let [pose, smooth] =
                    [&hand.pose, &hand.filtered].map(|pose| pose.as_ref().and_then(convert::pose));
                if let Some((measured, filtered)) = &mut self.hand {
                    measured.write((hand.frame, t_s), pose.as_ref(), state)?;
                    filtered.write((hand.frame, t_s), smooth.as_ref(), state)?;
                }
            }
            Topic::Command => {
                let command: msg::Command = reader.decode(entry)?;
                let header = format!("sequence,t,engaged,state,{POSE}");
                let csv = made(&mut self.command, &self.dir, "command.csv", &header)?;
                let pose = command.motion.and_then(|motion| motion.since_engage).unwrap_or_default();
                csv.row(|row| {
                    row.field(command.sequence).time(t_s).field(u8::from(command.engaged));
                    row.field(convert::pose_state(command.state).name());
                    numbers(row, &pose.translation, 3);
                    numbers(row, &pose.rotation, 9);
                })?;
            }
            Topic::Buttons => {
                let buttons: msg::Buttons = reader.decode(entry)?;
                let columns = "t,pressed,stop,resets,home,scale_percent";
                let csv = made(&mut self.buttons, &self.dir, "buttons.csv", columns)?;
                csv.row(|row| {
                    row.time(t_s).field(u8::from(buttons.pressed)).field(u8::from(buttons.stop));
                    row.field(buttons.resets).field(u8::from(buttons.home)).field(buttons.scale_percent);
                })?;
            }
            Topic::Arm => self.arm(t_s, &reader.decode(entry)?)?,
            Topic::Delays => {
                let delays: msg::Delays = reader.decode(entry)?;
                let csv =
                    made(&mut self.delays, &self.dir, "delays.csv", "t,stage,count,p50_us,p99_us,max_us")?;
                for stage in &delays.stages {
                    csv.row(|row| {
                        row.time(t_s).field(words(&stage.name)).field(stage.count);
                        row.field(stage.p50_us).field(stage.p99_us).field(stage.max_us);
                    })?;
                }
            }
            Topic::Log => {
                let log: Log = reader.decode(entry)?;
                let csv = made(&mut self.log, &self.dir, "log.csv", "t,message")?;
                csv.row(|row| {
                    row.time(t_s).field(words(&log.message));
                })?;
            }
            _ => {}
        }
        Ok(())
    }

    fn arm(&mut self, t_s: f64, arm: &msg::Arm) -> Result<(), OutputError> {
        let joints = numbered("s", 6) + &numbered("q", 6);
        let header =
            format!("t,slave_t,sequence,state,standing,limits,share,age_ms{joints},{POSE},slowed,scale");
        let csv = made(&mut self.arm, &self.dir, "arm.csv", &header)?;
        csv.row(|row| {
            row.time(t_s).time(seconds(arm.slave_us)).field(arm.sequence);
            row.field(words(&arm.state)).field(words(&arm.standing)).field(words(&arm.limits.join(" ")));
            row.number(arm.speed_share);
            match arm.command_age_us {
                Some(us) => row.field(us as f64 / 1e3),
                None => row.empty(),
            };
            numbers(row, &arm.set_point, 6);
            numbers(row, &arm.measured, 6);
            let tool = arm.tool.clone().unwrap_or_default();
            numbers(row, &tool.translation, 3);
            numbers(row, &tool.rotation, 9);
            // the words have semicolons of their own
            row.field(words(&arm.slowed.join(" / "))).number(arm.scale);
        })
    }
}

/// The file, made when it is first needed.
fn made<'a>(
    slot: &'a mut Option<CsvFile>,
    dir: &Path,
    name: &str,
    header: &str,
) -> Result<&'a mut CsvFile, OutputError> {
    match slot {
        Some(csv) => Ok(csv),
        None => Ok(slot.insert(CsvFile::create(dir, name, header)?)),
    }
}
