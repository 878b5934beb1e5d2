//! What a slave's file says beside the arm: whose motion counts, and the cameras of its scene.

use super::camera::{ViewToml, located};
use super::within;
use crate::link::StationName;
use crate::robot::RobotKind;
use crate::robot::simulated::SimulatedArm;
use crate::robot::start::excluded;
use crate::settings::arm::ArmSettings;
use crate::settings::file::{FileToml, Problem};
use crate::source::{Options, View, check_live};
use serde::Deserialize;
use std::path::Path;
use tetrad_core::arm::port::RobotPort as _;
use tetrad_core::arm::puma560::Puma560;

/// Cameras of the slave's scene: the paper's pair.
const MAX_CAMERAS: usize = 2;

/// A command has to last so many cycles: one in which it comes, one that the stop is begun ahead of time,
/// and one at least in between.
const CYCLES_A_COMMAND: u32 = 3;

/// Pictures a second of the scene, where nothing else is said.
const DEFAULT_FPS: f64 = 15.0;

/// The best quality its JPEG may have, where nothing else is said.
const DEFAULT_QUALITY: u8 = 80;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::settings) struct SceneCameraToml {
    source: String,
    view: Option<ViewToml>,
    fps: Option<f64>,
    size: Option<[u16; 2]>,
    quality: Option<f64>,
}

/// A slave station.
#[derive(Clone, Debug, PartialEq)]
pub struct SlaveSettings {
    /// The arm, the law, the limits, the port.
    pub arm: ArmSettings,
    /// The peer whose motion and buttons count; `None` where they do not come over the link.
    pub operator: Option<StationName>,
    /// The cameras of its scene, at most two.
    pub cameras: Vec<SceneCameraSettings>,
}

/// One camera of the slave's scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCameraSettings {
    /// What it is.
    pub place: SceneCamera,
    /// Its side, size and rate.
    pub options: Options,
    /// Pictures a second that are sent.
    pub fps: f64,
    /// The best JPEG quality, 1 to 100; less is sent where the link has not the room.
    pub quality: u8,
}

/// What looks at the slave's scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SceneCamera {
    /// `sim:arm`: a picture of the arm is drawn.
    SimulatedArm,
    /// A source of pictures.
    Source(String),
}

impl SlaveSettings {
    pub(super) fn checked(toml: &FileToml, dir: &Path) -> Result<Self, Problem> {
        let arm = ArmSettings::checked(toml)?;
        starts_within(&arm)?;
        outlasts_a_cycle(&arm)?;
        let Some(slave) = &toml.slave else { return Ok(Self { arm, operator: None, cameras: Vec::new() }) };
        let operator = slave.operator.as_deref().map(str::parse).transpose();
        let operator = operator.map_err(|error| ("[slave] operator".to_owned(), format!("{error}")))?;
        if slave.camera.len() > MAX_CAMERAS {
            let mend =
                format!("at most {MAX_CAMERAS} cameras, for two eyes: there are {}", slave.camera.len());
            return Err(("[[slave.camera]]".to_owned(), mend));
        }
        let cameras = slave.camera.iter().enumerate();
        let cameras = cameras
            .map(|(index, camera)| camera.checked(&format!("[[slave.camera]] {}", index + 1), index, dir));
        Ok(Self { operator, cameras: cameras.collect::<Result<_, _>>()?, arm })
    }
}

impl SceneCameraToml {
    fn checked(&self, key: &str, index: usize, dir: &Path) -> Result<SceneCameraSettings, Problem> {
        let at = |name: &str| format!("{key} {name}");
        if self.source.starts_with("node:") {
            let mend = "a camera of this computer is needed, or sim:arm".to_owned();
            return Err((at("source"), mend));
        }
        let fps = within(&at("fps"), self.fps, 1.0..=60.0, " pictures/s")?.unwrap_or(DEFAULT_FPS);
        let quality = within(&at("quality"), self.quality, 10.0..=100.0, "")?;
        let size = match self.size {
            Some([width, height]) if width == 0 || height == 0 => {
                return Err((
                    at("size"),
                    "a width and a height above 0 are needed, as [640, 480]".to_owned(),
                ));
            }
            size => size.map(|[width, height]| (width, height)),
        };
        let view = match self.view {
            Some(ViewToml::Left) => View::Left,
            Some(ViewToml::Right) => View::Right,
            // the first is the left one
            None if index == 0 => View::Left,
            None => View::Right,
        };
        let options = Options { view, fps: Some(fps), size, scene_s: None };
        let place = match self.source.as_str() {
            "sim:arm" => SceneCamera::SimulatedArm,
            source => {
                let source = located(source, dir);
                check_live(&source, &options).map_err(|error| (at("source"), error.to_string()))?;
                SceneCamera::Source(source)
            }
        };
        let quality = quality.map_or(DEFAULT_QUALITY, |quality| quality as u8);
        Ok(SceneCameraSettings { place, options, fps, quality })
    }
}

/// Refuses commands that are old before the next cycle sees them: the arm would never move.
fn outlasts_a_cycle(arm: &ArmSettings) -> Result<(), Problem> {
    let (timeout_us, cycle_us) = (arm.slave.teleop.command_timeout_us, arm.slave.governor.cycle_us);
    if timeout_us >= CYCLES_A_COMMAND.saturating_mul(cycle_us) {
        return Ok(());
    }
    let problem = format!(
        "a command that is old after {} ms does not last {CYCLES_A_COMMAND} cycles of {} ms: take shorter \
         cycles ([governor] cycle_ms) or a longer time",
        f64::from(timeout_us) / 1e3,
        f64::from(cycle_us) / 1e3
    );
    Err(("[teleop] command_timeout_ms".to_owned(), problem))
}

/// Refuses a workspace in which a simulated arm does not stand at its start. Where a real one stands is
/// known when it is asked, and it may always come back in.
fn starts_within(arm: &ArmSettings) -> Result<(), Problem> {
    let address = arm.port.clone().unwrap_or_default();
    let RobotKind::Simulated(options) = address.kind() else { return Ok(()) };
    let wrong = |error: String| ("[slave] port".to_owned(), format!("{address}: {error}"));
    if let Some((joint, degrees)) = excluded(&arm.slave.puma).filter(|_| options.start.is_none()) {
        let problem = format!(
            "joint {joint} of the simulated arm starts at {degrees} degrees, outside its range: take a range \
             around that, or say where it starts, as in sim:?start_deg=30,45,-180,0,45,0"
        );
        return Err(("[arm] min_deg, max_deg".to_owned(), problem));
    }
    let mut port = SimulatedArm::new(&arm.slave.puma, options).map_err(|error| wrong(error.to_string()))?;
    let reading = port.read_joints().map_err(|error| wrong(error.to_string()))?;
    let puma = Puma560::new(&arm.slave.puma).map_err(|error| wrong(error.to_string()))?;
    let tool = puma.forward(&reading.joints).translation;
    let workspace = arm.slave.teleop.workspace;
    let outside = (0..3).any(|axis| tool[axis] < workspace.min_m[axis] || tool[axis] > workspace.max_m[axis]);
    if outside {
        let [x, y, z] = [tool.x, tool.y, tool.z].map(|m| m * 1000.0);
        let problem = format!(
            "the arm starts with its tool at {x:.0}, {y:.0}, {z:.0} mm, outside the box: take the box around \
             it, or another start (start_deg behind sim:?)"
        );
        return Err(("[workspace] min_mm, max_mm".to_owned(), problem));
    }
    Ok(())
}
