//! From flags and files to checked settings: after this, nothing about `tetrad track` is in doubt but
//! the pictures themselves.

use crate::balls::BallSet;
use crate::colours::Colours;
use crate::exit::{Exit, Failure, OrExit as _};
use crate::pipeline::PipelineConfig;
use crate::scene_file::{SceneFile, Seeds};
use crate::text_file;
use anyhow::Context as _;
use clap::{ArgGroup, Args, ValueEnum};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use tetrad_core::config::{FilterConfig, MAX_ARM_M, MIN_ARM_M};

pub mod arm;
mod file;
pub mod smart_camera;
pub mod station;

mod filter;

pub use file::SettingsError;
pub use filter::{FilterArgs, PredictionFlag, SmoothingFlag};

/// The focal lengths that can be given, px: from a fisheye on a small picture to a long lens on the
/// largest.
const FOCAL_PX: RangeInclusive<f32> = 50.0..=50_000.0;

/// How centres and poses are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// The paper's: row-edge centres (eq. 2), frame-to-frame affine motion.
    Paper,
    /// Sub-pixel centres, and a latched pose with perspective terms.
    Refined,
}

impl Mode {
    /// The word on the command line and in summary.json.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Refined => "refined",
        }
    }

    /// How everything is computed in this mode.
    #[must_use]
    pub fn pipeline(self) -> PipelineConfig {
        match self {
            Self::Paper => PipelineConfig::paper(),
            Self::Refined => PipelineConfig::refined(),
        }
    }
}

/// The flags that say what is tracked and how, of `tetrad track` and `tetrad record`.
#[derive(Args, Clone, Debug)]
#[command(group(ArgGroup::new("taught").required(true).args(["colours_left", "scene"])))]
pub struct InputArgs {
    /// The left (or only) camera: /dev/videoN, a folder of numbered frames, a .y4m or .mcap file or sim:NAME;
    /// for `track` also node:serial:DEVICE, a smart camera alone
    #[arg(long, value_name = "SRC")]
    pub left: String,
    /// The right camera; without it one camera is tracked and there is no pose
    #[arg(long, value_name = "SRC")]
    pub right: Option<String>,
    /// The left camera's colours, from `tetrad learn`
    #[arg(long, value_name = "FILE")]
    pub colours_left: Option<PathBuf>,
    /// The right camera's colours, from `tetrad learn`
    #[arg(long, value_name = "FILE", requires = "right", conflicts_with = "scene")]
    pub colours_right: Option<PathBuf>,
    /// A scene.json: colours are learnt where it says the balls are in the first frame
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Length of the feature frame's arms E1, E2, E3 in millimetres, 5 to 2000 [default: the scene's]
    #[arg(long, value_name = "MM")]
    pub arm_mm: Option<f32>,
    /// How centres and poses are computed
    #[arg(long, value_enum, default_value_t = Mode::Refined)]
    pub mode: Mode,
    /// The left camera's focal length in pixels, as far as anybody knows [default: 1.25 picture widths]
    #[arg(long, value_name = "PX")]
    pub focal_left: Option<f32>,
    /// The right camera's
    #[arg(long, value_name = "PX", requires = "right")]
    pub focal_right: Option<f32>,
    /// Solve for the pose with the left camera alone (refined mode)
    #[arg(long, conflicts_with = "right")]
    pub one_camera_pose: bool,
    /// How the pose is filtered
    #[command(flatten)]
    pub filter: FilterArgs,
    /// Track only these balls [default: the scene's, or all four]
    #[arg(long, value_name = "BALLS")]
    pub balls: Option<BallSet>,
}

/// The flags of `tetrad track`.
#[derive(Args, Clone, Debug)]
pub struct TrackArgs {
    /// What is tracked and how.
    #[command(flatten)]
    pub input: InputArgs,
    /// Where the results go: observations.csv, pose.csv, filtered.csv, motion.csv, summary.json ...; made if missing
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Send the hand's motion as packets for `tetrad slave`, to this file or - for standard output
    #[arg(long, value_name = "FILE")]
    pub packets: Option<PathBuf>,
}

/// How a camera's balls are first known.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// Their colours are known, their places are searched for.
    Colours(Colours),
    /// Their places in the first frame are known, their colours are learnt there.
    Seeds {
        /// Where the balls are.
        seeds: Seeds,
        /// The scene file, for messages.
        file: String,
    },
}

/// One camera of `tetrad track`.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSettings {
    /// `left` or `right`.
    pub name: &'static str,
    /// Where its pictures come from.
    pub source: String,
    /// How its balls are first known: exactly [`InputSettings::balls`].
    pub start: Start,
    /// Its nominal focal length in pixels, where one was given.
    pub focal_px: Option<f32>,
}

/// What is tracked and how, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct InputSettings {
    /// The left (or only) camera, then the right one.
    pub cameras: Vec<CameraSettings>,
    /// The balls to track.
    pub balls: BallSet,
    /// Whether they are one rigid frame.
    pub rigid: bool,
    /// How centres and poses are computed.
    pub mode: Mode,
    /// The arms' length in metres; there is one whenever there is a pose.
    pub arm_m: Option<f32>,
    /// Whether a pose is wanted although there is one camera.
    pub one_camera_pose: bool,
    /// How the pose is filtered.
    pub filter: FilterConfig,
    /// Frames per second where a source has no times.
    pub fps: Option<f64>,
}

/// `tetrad track`, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackSettings {
    /// What is tracked and how.
    pub input: InputSettings,
    /// Where results go.
    pub out: PathBuf,
    /// Where the hand's motion is sent, `-` for standard output.
    pub packets: Option<PathBuf>,
}

impl TrackSettings {
    /// Reads and checks everything the flags name but the sources.
    ///
    /// # Errors
    /// [`Failure`] with [`Exit::BadArguments`] that names the flag, or the file and its key.
    pub fn new(args: TrackArgs) -> Result<Self, Failure> {
        let TrackArgs { input, out, packets } = args;
        let input = InputSettings::new(&input)?;
        if packets.is_some() && !input.has_pose() {
            return Err(Failure::bad_arguments("--packets: there is no hand whose motion could be sent")
                .help("give two cameras (or --one-camera-pose) and all four balls"));
        }
        Ok(Self { input, out, packets })
    }
}

impl InputSettings {
    /// Reads and checks everything the flags name but the sources.
    ///
    /// # Errors
    /// [`Failure`] with [`Exit::BadArguments`] that names the flag, or the file and its key.
    pub fn new(args: &InputArgs) -> Result<Self, Failure> {
        if let Some(mm) = args.arm_mm
            && !(MIN_ARM_M..=MAX_ARM_M).contains(&metres(mm))
        {
            let [least, most] = [MIN_ARM_M, MAX_ARM_M].map(|m| (m * 1000.0).round());
            return Err(Failure::bad_arguments(format!(
                "--arm-mm {mm}: a length from {least} to {most} mm is needed"
            )));
        }
        for (flag, focal_px) in [("--focal-left", args.focal_left), ("--focal-right", args.focal_right)] {
            if let Some(px) = focal_px
                && !FOCAL_PX.contains(&px)
            {
                let (least, most) = FOCAL_PX.into_inner();
                return Err(Failure::bad_arguments(format!(
                    "{flag} {px}: a focal length from {least} to {most} px is needed"
                ))
                .help("a lens that sees 44 degrees from side to side has 1.25 picture widths"));
            }
        }
        if args.one_camera_pose && args.mode == Mode::Paper {
            return Err(Failure::bad_arguments("--one-camera-pose: the paper's method needs two cameras")
                .help("leave --mode paper out, or give --right"));
        }
        let settings = match &args.scene {
            Some(scene) => Self::from_scene(scene, args)?,
            None => Self::from_colours(args)?,
        };
        if settings.one_camera_pose && !settings.balls.is_all() {
            let message =
                format!("--one-camera-pose needs all four balls, and only {} are tracked", settings.balls);
            return Err(Failure::bad_arguments(message).help("leave it out, or track all four"));
        }
        if settings.one_camera_pose && !settings.rigid {
            let file = args.scene.as_deref().map_or_else(String::new, |file| format!("{}: ", file.display()));
            let message =
                format!("--one-camera-pose: {file}rigid is false, and only a rigid frame has a pose");
            return Err(Failure::bad_arguments(message).help("leave it out, or take rigid out of the scene"));
        }
        if settings.has_pose() && settings.arm_m.is_none() {
            return Err(Failure::bad_arguments("the arms' length is not known, and a pose needs it")
                .help("give --arm-mm, or arm_m in the scene file"));
        }
        Ok(settings)
    }

    /// Whether there is a hand to solve for: all four balls of one rigid frame in two cameras, or in
    /// one where that was asked for.
    #[must_use]
    pub fn has_pose(&self) -> bool {
        let enough = self.cameras.len() >= 2 || self.one_camera_pose;
        enough && self.balls.is_all() && self.rigid
    }

    fn from_colours(args: &InputArgs) -> Result<Self, Failure> {
        let balls = args.balls.unwrap_or(BallSet::ALL);
        let mut cameras = Vec::new();
        for (name, source, file, focal_px) in [
            ("left", Some(&args.left), &args.colours_left, args.focal_left),
            ("right", args.right.as_ref(), &args.colours_right, args.focal_right),
        ] {
            let Some(source) = source else { continue };
            let Some(file) = file else {
                return Err(Failure::bad_arguments(format!("--{name} is given without --colours-{name}"))
                    .help(format!("teach that camera with `tetrad learn --source {source} ...`")));
            };
            let label = file.display().to_string();
            let colours = Colours::parse(&read(file)?, &label)
                .and_then(|colours| colours.select(balls, &label))
                .or_exit(Exit::BadArguments)?;
            let start = Start::Colours(colours);
            cameras.push(CameraSettings { name, source: source.clone(), start, focal_px });
        }
        let arm_m = args.arm_mm.map(metres);
        Ok(Self {
            cameras,
            balls,
            rigid: balls.is_all(),
            arm_m,
            mode: args.mode,
            one_camera_pose: args.one_camera_pose,
            filter: args.filter.config(),
            fps: None,
        })
    }

    fn from_scene(file: &Path, args: &InputArgs) -> Result<Self, Failure> {
        let label = file.display().to_string();
        let scene = SceneFile::parse(&read(file)?, &label).or_exit(Exit::BadArguments)?;
        let balls = args.balls.unwrap_or_else(|| scene.balls());
        if let Some(absent) = balls.iter().find(|&ball| !scene.balls().contains(ball)) {
            let name = absent.name();
            return Err(Failure::bad_arguments(format!("--balls {balls}: {label} has no seed for {name}"))
                .help(format!("add seeds.left.{name}, or leave {name} out of --balls")));
        }
        let start = |mut seeds: Seeds| {
            for ball in tetrad_core::observation::Ball::ALL {
                seeds[ball.index()] = seeds[ball.index()].filter(|_| balls.contains(ball));
            }
            Start::Seeds { seeds, file: label.clone() }
        };
        let mut cameras = vec![CameraSettings {
            name: "left",
            source: args.left.clone(),
            start: start(scene.left),
            focal_px: args.focal_left,
        }];
        if let Some(source) = &args.right {
            let Some(seeds) = scene.right else {
                return Err(Failure::bad_arguments(format!("{label}: seeds.right is missing"))
                    .help("--right needs the places of the balls in the right camera's first frame"));
            };
            cameras.push(CameraSettings {
                name: "right",
                source: source.clone(),
                start: start(seeds),
                focal_px: args.focal_right,
            });
        }
        Ok(Self {
            cameras,
            balls,
            rigid: scene.rigid.unwrap_or(balls.is_all()),
            mode: args.mode,
            one_camera_pose: args.one_camera_pose,
            filter: args.filter.config(),
            arm_m: args.arm_mm.map(metres).or(scene.arm_m),
            fps: scene.fps,
        })
    }
}

fn metres(millimetres: f32) -> f32 {
    millimetres / 1000.0
}

fn read(file: &Path) -> Result<String, Failure> {
    text_file::read(file)
        .with_context(|| format!("cannot read {}", file.display()))
        .or_exit(Exit::BadArguments)
}

#[cfg(test)]
mod tests;
