//! `[camera]`, and the cameras of other tables that are plugged into this computer.

use super::within;
use crate::balls::BallSet;
use crate::colours::Colours;
use crate::scene_file::SceneFile;
use crate::settings::file::Problem;
use crate::settings::{FOCAL_PX, Mode, Start};
use crate::source::{MAX_FPS, Options, View, check_live};
use crate::text_file;
use serde::Deserialize;
use std::path::{Path, PathBuf};

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ViewToml {
    Left,
    Right,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum ModeToml {
    Paper,
    Refined,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::settings) struct CameraToml {
    source: String,
    view: Option<ViewToml>,
    colours: Option<PathBuf>,
    scene: Option<PathBuf>,
    focal_px: Option<f64>,
    fps: Option<f64>,
    size: Option<[u16; 2]>,
    mode: Option<ModeToml>,
    preview_fps: Option<f64>,
    preview_every: Option<u16>,
}

/// A camera station.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSettings {
    /// Its camera.
    pub camera: LocalCamera,
    /// The file of its colours, where it has one.
    pub colours: Option<PathBuf>,
    /// Pictures a second that go with the observations, to be looked at; 0 for none.
    pub preview_fps: f64,
}

/// A camera of this computer whose balls are tracked here.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalCamera {
    /// Where its pictures come from: SRC.
    pub source: String,
    /// What is asked of the source.
    pub options: Options,
    /// How its balls are first known.
    pub start: CameraStart,
    /// Its nominal focal length, px, where one was given.
    pub focal_px: Option<f32>,
    /// How centres are computed.
    pub mode: Mode,
}

/// How a camera's balls are first known.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraStart {
    /// By a file of colours, or the places in a scene's first frame.
    Given(Start),
    /// A simulated scene knows them.
    OfScene,
}

impl CameraToml {
    /// `key` is the table's, for messages; `dir` where the file lies.
    pub(super) fn checked(&self, key: &str, dir: &Path) -> Result<CameraSettings, Problem> {
        let preview = within(&format!("{key} preview_fps"), self.preview_fps, 0.0..=60.0, " pictures/s")?;
        let (camera, colours) = (self.local(key, dir)?, self.colours(dir));
        Ok(CameraSettings { camera, colours, preview_fps: preview.unwrap_or(0.0) })
    }

    /// The camera without what only a camera station has.
    pub(super) fn local(&self, key: &str, dir: &Path) -> Result<LocalCamera, Problem> {
        let at = |name: &str| format!("{key} {name}");
        if self.source.starts_with("node:") {
            let mend = format!("{} is another station: [[operator.camera]] takes it", self.source);
            return Err((at("source"), mend));
        }
        let fps = within(&at("fps"), self.fps, 1.0..=MAX_FPS, " frames/s")?;
        if self.preview_every.is_some() {
            let mend = "a smart camera on a serial port takes it: leave it out".to_owned();
            return Err((at("preview_every"), mend));
        }
        let focal = f64::from(*FOCAL_PX.start())..=f64::from(*FOCAL_PX.end());
        let focal_px = within(&at("focal_px"), self.focal_px, focal, " px")?.map(|px| px as f32);
        let view = match self.view {
            Some(ViewToml::Right) => View::Right,
            Some(ViewToml::Left) | None => View::Left,
        };
        let mode = match self.mode {
            Some(ModeToml::Paper) => Mode::Paper,
            Some(ModeToml::Refined) | None => Mode::Refined,
        };
        let size = match self.size {
            Some([width, height]) if width == 0 || height == 0 => {
                return Err((
                    at("size"),
                    "a width and a height above 0 are needed, as [640, 480]".to_owned(),
                ));
            }
            size => size.map(|[width, height]| (width, height)),
        };
        let options = Options { view, fps, size, scene_s: None };
        let source = located(&self.source, dir);
        check_live(&source, &options).map_err(|error| (at("source"), error.to_string()))?;
        let start = self.start(key, view, dir)?;
        Ok(LocalCamera { source, options, start, focal_px, mode })
    }

    /// The keys that were given of those that only a camera of this computer can have.
    pub(super) fn of_a_local_camera(&self) -> impl Iterator<Item = &'static str> {
        [
            ("view", self.view.is_some()),
            ("colours", self.colours.is_some()),
            ("scene", self.scene.is_some()),
            ("fps", self.fps.is_some()),
            ("size", self.size.is_some()),
            ("mode", self.mode.is_some()),
            ("preview_fps", self.preview_fps.is_some()),
        ]
        .into_iter()
        .filter_map(|(key, given)| given.then_some(key))
    }

    /// Of how many pictures one begins a smart camera's thumbnail, as it was given.
    pub(super) const fn preview_every(&self) -> Option<u16> {
        self.preview_every
    }

    /// The focal length as it was given.
    pub(super) const fn focal_px(&self) -> Option<f64> {
        self.focal_px
    }

    /// The file of its colours, where one is named.
    pub(super) fn colours(&self, dir: &Path) -> Option<PathBuf> {
        self.colours.as_ref().map(|file| dir.join(file))
    }

    /// Where its pictures come from, as it was given.
    pub(super) fn source(&self) -> &str {
        &self.source
    }

    fn start(&self, key: &str, view: View, dir: &Path) -> Result<CameraStart, Problem> {
        let at = |name: &str| format!("{key} {name}");
        match (&self.colours, &self.scene) {
            (Some(_), Some(_)) => {
                Err((at("colours, scene"), "the same said twice: leave one of both out".to_owned()))
            }
            (Some(file), None) => colours_in(&dir.join(file))
                .map(|colours| CameraStart::Given(Start::Colours(colours)))
                .map_err(|problem| (at("colours"), problem)),
            (None, Some(file)) => {
                let path = dir.join(file);
                let label = path.display().to_string();
                let scene = read(&path)
                    .and_then(|text| SceneFile::parse(&text, &label).map_err(|error| error.to_string()))
                    .map_err(|problem| (at("scene"), problem))?;
                let seeds = match view {
                    View::Left => Some(scene.left),
                    View::Right => scene.right,
                };
                let seeds = seeds
                    .ok_or_else(|| (at("scene"), format!("{label}: seeds.{} is missing", view.name())))?;
                Ok(CameraStart::Given(Start::Seeds { seeds, file: label }))
            }
            (None, None) if self.source.starts_with("sim:") => Ok(CameraStart::OfScene),
            (None, None) => {
                let source = &self.source;
                let mend = format!("give a file of colours; `tetrad learn --source {source} ...` makes one");
                Err((at("colours"), mend))
            }
        }
    }
}

/// SRC as this program finds it: a recording lies beside the file that names it.
pub(super) fn located(source: &str, dir: &Path) -> String {
    if source.starts_with("sim:") { source.to_owned() } else { dir.join(source).display().to_string() }
}

/// A file's colours, of all four balls.
pub(super) fn colours_in(path: &Path) -> Result<Colours, String> {
    let label = path.display().to_string();
    let colours = Colours::parse(&read(path)?, &label).map_err(|error| error.to_string())?;
    colours.select(BallSet::ALL, &label).map_err(|error| error.to_string())
}

fn read(path: &Path) -> Result<String, String> {
    text_file::read(path).map_err(|cause| format!("cannot read {}: {cause}", path.display()))
}
