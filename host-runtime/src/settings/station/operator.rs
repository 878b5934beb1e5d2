//! `[operator]` and `[[operator.camera]]`: the hand, the cameras that see it, and where the arm is.

use super::camera::{CameraToml, LocalCamera, colours_in};
use super::within;
use crate::colours::Colours;
use crate::link::StationName;
use crate::settings::FOCAL_PX;
use crate::settings::file::Problem;
use crate::settings::smart_camera::SerialPlace;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use tetrad_core::config::{FilterConfig, MAX_ARM_M, MAX_LEAD_US, MIN_ARM_M, Prediction, Smoothing};

/// Cameras of one hand: as many as core solves for.
const MAX_CAMERAS: usize = 8;

/// A smart camera shows a ball every so many pictures: three a second at 30 pictures a second, so that the newest is
/// not stale before the next has come, for 2 KB/s of the line.
const PREVIEW_EVERY: u16 = 10;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::settings) struct OperatorToml {
    arm_mm: f64,
    slave: Option<String>,
    #[serde(default)]
    camera: Vec<CameraToml>,
    filter: Option<FilterToml>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum SmoothingToml {
    OneEuro,
    Off,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum PredictionToml {
    Velocity,
    Acceleration,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FilterToml {
    smoothing: Option<SmoothingToml>,
    prediction: Option<PredictionToml>,
    lead_ms: Option<f64>,
}

/// An operator station.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatorSettings {
    /// Length of the feature frame's arms, metres.
    pub arm_m: f32,
    /// The cameras that see the hand, one to eight.
    pub cameras: Vec<HandCameraSettings>,
    /// Where the arm is.
    pub slave: SlavePlace,
    /// How the pose is filtered.
    pub filter: FilterConfig,
}

/// Where the arm is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SlavePlace {
    /// At this station, by the file's own tables.
    Here,
    /// At a peer.
    Station(StationName),
}

/// One camera that sees the hand.
#[derive(Clone, Debug, PartialEq)]
pub struct HandCameraSettings {
    /// SRC as it was given, for messages.
    pub source: String,
    /// Where it is.
    pub place: HandCamera,
    /// The file that keeps its colours, where it is at no other station and has one.
    pub colours: Option<PathBuf>,
    /// Its nominal focal length, px, where one was given.
    pub focal_px: Option<f32>,
}

/// Where a camera of the hand is.
#[derive(Clone, Debug, PartialEq)]
pub enum HandCamera {
    /// At a peer, `node:NAME`.
    Station(StationName),
    /// A smart camera on a serial port, `node:serial:DEVICE?baud=N`.
    Serial {
        /// The port.
        device: PathBuf,
        /// Bits a second.
        baud: u32,
        /// What it is taught; without, it keeps what it was taught before.
        colours: Option<Box<Colours>>,
        /// It shows a ball to the console every so many pictures; 0 for never.
        preview_every: u16,
    },
    /// Plugged in here.
    Local(Box<LocalCamera>),
}

impl OperatorToml {
    pub(super) fn checked(&self, dir: &Path) -> Result<OperatorSettings, Problem> {
        let wrong = |key: &str, problem: String| (format!("[operator] {key}"), problem);
        let millimetres = f64::from(MIN_ARM_M) * 1000.0..=f64::from(MAX_ARM_M) * 1000.0;
        // as f32 knows them, the bounds have digits that nobody wrote
        let (least, most) = (millimetres.start().round(), millimetres.end().round());
        within("[operator] arm_mm", Some(self.arm_mm), least..=most, " mm")?;
        let slave = match self.slave.as_deref() {
            None => return Err(wrong("slave", "name the peer where the arm is, or \"here\"".to_owned())),
            Some("here") => SlavePlace::Here,
            Some(name) => {
                SlavePlace::Station(name.parse().map_err(|error| wrong("slave", format!("{error}")))?)
            }
        };
        if self.camera.is_empty() || self.camera.len() > MAX_CAMERAS {
            let mend = format!(
                "one to {MAX_CAMERAS} [[operator.camera]] tables are needed, there are {}",
                self.camera.len()
            );
            return Err(wrong("camera", mend));
        }
        let cameras = self.camera.iter().enumerate();
        let cameras =
            cameras.map(|(index, camera)| camera.of_hand(&format!("[[operator.camera]] {}", index + 1), dir));
        let cameras: Vec<_> = cameras.collect::<Result<_, _>>()?;
        for (index, camera) in cameras.iter().enumerate() {
            let same = |other: &HandCameraSettings| match (&camera.place, &other.place) {
                // one scene has several views
                (HandCamera::Local(a), HandCamera::Local(b)) => {
                    a.source == b.source && a.options.view == b.options.view
                }
                (HandCamera::Serial { device: a, .. }, HandCamera::Serial { device: b, .. }) => a == b,
                (a, b) => a == b,
            };
            if cameras.iter().take(index).any(same) {
                let mend = format!("{} is given twice: each camera once", camera.source);
                return Err((format!("[[operator.camera]] {} source", index + 1), mend));
            }
        }
        let filter = self.filter.as_ref().map_or(Ok(FilterConfig::default()), FilterToml::config)?;
        Ok(OperatorSettings { arm_m: (self.arm_mm / 1000.0) as f32, cameras, slave, filter })
    }
}

impl FilterToml {
    fn config(&self) -> Result<FilterConfig, Problem> {
        let mut filter = FilterConfig::default();
        if let Some(SmoothingToml::Off) = self.smoothing {
            filter.smoothing = Smoothing::Off;
        }
        match self.prediction {
            Some(PredictionToml::Velocity) => filter.prediction = Prediction::Velocity,
            Some(PredictionToml::Acceleration) => filter.prediction = Prediction::Acceleration,
            None => {}
        }
        let most = f64::from(MAX_LEAD_US) / 1000.0;
        if let Some(ms) = within("[operator.filter] lead_ms", self.lead_ms, 0.0..=most, " ms")? {
            filter.lead_us = (ms * 1000.0).round() as u32;
        }
        Ok(filter)
    }
}

impl CameraToml {
    fn of_hand(&self, key: &str, dir: &Path) -> Result<HandCameraSettings, Problem> {
        let wrong = |problem: String| (format!("{key} source"), problem);
        let Some(node) = self.source().strip_prefix("node:") else {
            if self.of_a_local_camera().next() == Some("preview_fps") {
                let mend = "a camera of this station is looked at here: leave it out".to_owned();
                return Err((format!("{key} preview_fps"), mend));
            }
            let camera = self.local(key, dir)?;
            let focal_px = camera.focal_px;
            let source = self.source().to_owned();
            let colours = self.colours(dir);
            return Ok(HandCameraSettings {
                source,
                place: HandCamera::Local(Box::new(camera)),
                colours,
                focal_px,
            });
        };
        let serial = SerialPlace::of(self.source());
        // a smart camera has no file to keep its colours in
        let takes = |key: &str| key == "colours" && serial.is_some();
        if let Some(extra) = self.of_a_local_camera().find(|key| !takes(key)) {
            let mend = format!("{} knows that itself: set it there, and leave it out here", self.source());
            return Err((format!("{key} {extra}"), mend));
        }
        let file = self.colours(dir);
        let place = match serial {
            Some(place) => {
                let SerialPlace { device, baud } = place.map_err(wrong)?;
                let colours = file.as_deref().map(colours_in).transpose();
                let colours = colours.map_err(|problem| (format!("{key} colours"), problem))?.map(Box::new);
                let preview_every = self.preview_every().unwrap_or(PREVIEW_EVERY);
                HandCamera::Serial { device, baud, colours, preview_every }
            }
            None if self.preview_every().is_some() => {
                let mend = format!("{} has preview_fps, at that station: leave it out here", self.source());
                return Err((format!("{key} preview_every"), mend));
            }
            None => HandCamera::Station(node.parse().map_err(|error| wrong(format!("{error}")))?),
        };
        let focal = f64::from(*FOCAL_PX.start())..=f64::from(*FOCAL_PX.end());
        let focal_px = within(&format!("{key} focal_px"), self.focal_px(), focal, " px")?;
        Ok(HandCameraSettings {
            source: self.source().to_owned(),
            place,
            colours: file,
            focal_px: focal_px.map(|px| px as f32),
        })
    }
}
