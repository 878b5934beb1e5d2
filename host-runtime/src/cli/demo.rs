//! `tetrad demo`: simulated cameras and hand, learnt and tracked as real ones are, and a simulated PUMA 560
//! that follows.
//!
//! In real time it is the operator's own run with the console ([`live`]). With `--headless` it goes as fast
//! as it can, by the scene's clock, and all of it is compared with the truth.

mod arm;
mod live;

use super::interrupt::Interrupt;
use super::operator::longest;
use super::{make_results_dir, note, progress, say};
use crate::balls::BallSet;
use crate::comparison::{self, BallCounts, Comparison};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::learning;
use crate::output::{CameraSummary, Canvas, RecordedCamera, Recorder, Spread, Stamp, TruthCsv};
use crate::pipeline::{CameraStep, Pipeline};
use crate::settings::{FilterArgs, Mode};
use crate::source::View;
use anyhow::Context as _;
use arm::{ArmSummary, DemoArm};
use clap::Args;
use std::path::PathBuf;
use tetrad_core::arm::teleop::State;
use tetrad_core::config::{LearnConfig, ProposeConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::vision::learn::propose::propose;
use tetrad_fixtures::Scene;

pub(super) const EXAMPLES: &str = "\
Examples:
  In real time, in the console that it names, until Ctrl-C: hold the space bar there to move the arm
    tetrad demo
  The same, and kept for `tetrad replay` and the console's replay page
    tetrad demo --record demo.mcap
  As fast as it goes over ten simulated seconds, for scripts:
    tetrad demo --headless --seconds 10 --out demo-out

With --headless DIR gets the files of `tetrad track`, the truth (truth.csv, truth_pose.csv), arm.csv and
seen.png: a frame from the middle of the run with search windows and centres drawn over it. Else it gets
those of `tetrad operator`.";

/// Simulated seconds of a headless run that does not say.
const HEADLESS_SECONDS: f64 = 10.0;

/// The picture with what was seen drawn over it.
const PICTURE: &str = "seen.png";

/// The cameras' names, in the scene's order.
const CAMERAS: [View; 2] = [View::Left, View::Right];

/// The flags of `tetrad demo`.
#[derive(Args, Clone, Debug)]
pub(super) struct DemoArgs {
    /// Seconds, with --headless simulated ones [default: 10 with --headless, else until Ctrl-C]
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
    /// As fast as it goes, without the console, compared with the truth: for scripts
    #[arg(long)]
    headless: bool,
    /// Where results go; made if missing
    #[arg(long, value_name = "DIR", default_value = "demo-out")]
    out: PathBuf,
    /// The simulated scene
    #[arg(long, value_name = "NAME", default_value = "demo")]
    scene: String,
    /// How centres are computed, and with --headless poses too
    #[arg(long, value_enum, default_value_t = Mode::Refined)]
    mode: Mode,
    #[command(flatten)]
    filter: FilterArgs,
    /// Keep everything in this session, for `tetrad replay` and the console; an older one of that name is lost
    #[arg(long, value_name = "FILE.mcap", conflicts_with = "headless")]
    record: Option<PathBuf>,
}

/// Runs `tetrad demo`.
pub(super) fn run(args: &DemoArgs) -> Result<(), Failure> {
    if !args.headless {
        return live::run(args);
    }
    let scene = scene(&args.scene)?;
    let frames = frames(args, scene.fps)?;
    make_results_dir(&args.out)?;
    let interrupt = Interrupt::listen()?;
    let mut cameras = Cameras::new(&scene);
    cameras.render(0);
    let pipeline = learn(&scene, &cameras, args.mode)?;
    let pipeline = pipeline.with_filter(PoseFilter::new(args.filter.config()).or_exit(Exit::BadArguments)?);
    let mut demo = Demo::new(args, &scene, pipeline)?;
    let outcome = demo.run(&mut cameras, frames, &interrupt);
    let stopped_by = outcome.as_ref().err().map(|failure| format!("{:#}", failure.cause));
    let Demo { recorder, comparison, arm, .. } = demo;
    let first = scene.hand(0);
    let arm = arm.summary(|t_s| comparison::relative(&first, &scene.hand_at(t_s)));
    let summary = recorder.finish(stopped_by).or_exit(Exit::Failed);
    outcome?;
    report(&comparison, &summary?.cameras, &arm, args);
    Ok(())
}

fn scene(name: &str) -> Result<Scene, Failure> {
    let scene = Scene::named(name).ok_or_else(|| {
        let names: Vec<String> = Scene::names().into_iter().map(|(name, _)| name).collect();
        Failure::bad_arguments(format!("there is no scene `{name}`"))
            .help(format!("the scenes are {}", names.join(", ")))
    })?;
    if scene.cameras() < CAMERAS.len() {
        return Err(Failure::bad_arguments(format!("the scene `{name}` has not two cameras")));
    }
    Ok(scene)
}

/// How many frames to run.
fn frames(args: &DemoArgs, fps: f64) -> Result<u64, Failure> {
    let seconds = args.seconds.unwrap_or(HEADLESS_SECONDS);
    longest(Some(seconds))?;
    Ok((seconds * fps).ceil() as u64)
}

/// The simulated cameras, with the pictures they gave last.
struct Cameras<'a> {
    scene: &'a Scene,
    rgb: [Vec<u8>; CAMERAS.len()],
}

impl<'a> Cameras<'a> {
    fn new(scene: &'a Scene) -> Self {
        Self { scene, rgb: [Vec::new(), Vec::new()] }
    }

    /// Takes the pictures of a frame, both at once.
    fn render(&mut self, frame: usize) {
        let scene = self.scene;
        std::thread::scope(|threads| {
            for (camera, rgb) in self.rgb.iter_mut().enumerate() {
                threads.spawn(move || scene.render_rgb(frame, camera, rgb));
            }
        });
    }

    fn views(&self) -> Result<Vec<FrameView<'_>>, Failure> {
        let view = |rgb| FrameView::packed(rgb, self.scene.width, self.scene.height, PixelFormat::Rgb888);
        self.rgb.iter().map(|rgb| view(rgb)).collect::<Result<_, _>>().or_exit(Exit::Failed)
    }
}

/// Colours as an operator teaches them: the balls that are proposed in the first pictures or, where
/// none are, those pointed at.
fn learn(scene: &Scene, cameras: &Cameras<'_>, mode: Mode) -> Result<Pipeline, Failure> {
    let frames = cameras.views()?;
    let proposal = propose(&frames, &ProposeConfig::default());
    let mut starts = Vec::new();
    for ((view, frame), proposed) in CAMERAS.iter().zip(&frames).zip(&proposal.views) {
        let name = view.name();
        let taught = match proposed.balls {
            Ok(balls) => balls.map(Some),
            Err(reason) => {
                note(format_args!("{name}: {reason}; the demo points at them"));
                let points = scene.truth(0, view.index()).map(|ball| {
                    let (u, v) = ball.outline_centre;
                    Some(ImagePoint::new(u.round() as f32, v.round() as f32))
                });
                learning::learn_at(frame, &points, &LearnConfig::default())
                    .with_context(|| format!("nothing learnt from the first picture of the {name} camera"))
                    .or_exit(Exit::Failed)?
            }
        };
        starts.push(learning::start_with(&taught));
    }
    let arms = Arms::equal(scene.arm_m as f32).or_exit(Exit::Failed)?;
    Pipeline::new(&starts, mode.pipeline(), Some(arms))
        .map_err(|(_, error)| Failure::new(Exit::Failed, error))
}

/// A run of the demo.
struct Demo<'a> {
    args: &'a DemoArgs,
    scene: &'a Scene,
    pipeline: Pipeline,
    recorder: Recorder,
    truth: TruthCsv,
    comparison: Comparison,
    arm: DemoArm,
    /// The frame of which a picture is saved; `None` once it is.
    picture_at: Option<u64>,
}

impl<'a> Demo<'a> {
    fn new(args: &'a DemoArgs, scene: &'a Scene, pipeline: Pipeline) -> Result<Self, Failure> {
        let cameras = CAMERAS.map(|view| RecordedCamera {
            name: view.name(),
            source: format!("sim:{}", scene.name),
            size: (scene.width, scene.height),
        });
        Ok(Self {
            args,
            scene,
            pipeline,
            recorder: Recorder::create(&args.out, args.mode.name(), cameras.into(), BallSet::ALL)
                .or_exit(Exit::Failed)?,
            truth: TruthCsv::create(&args.out).or_exit(Exit::Failed)?,
            comparison: Comparison::default(),
            arm: DemoArm::new(&args.out)?,
            picture_at: None,
        })
    }

    fn run(&mut self, cameras: &mut Cameras<'_>, frames: u64, interrupt: &Interrupt) -> Result<(), Failure> {
        self.picture_at = Some(frames / 2);
        let bar = progress::frames(Some(frames));
        let mut frame = 0;
        loop {
            cameras.render(frame as usize);
            self.step(frame, &cameras.views()?)?;
            frame += 1;
            bar.set_position(frame);
            if frame >= frames || interrupt.asked() {
                bar.finish_and_clear();
                return Ok(());
            }
        }
    }

    fn step(&mut self, frame: u64, views: &[FrameView<'_>]) -> Result<(), Failure> {
        let index = frame as usize;
        let t_s = self.scene.time_s(index);
        let stamp = (frame, t_s);
        let t_us = (t_s * 1e6).round() as u64;
        let timed: Vec<_> = views.iter().map(|view| (*view, t_us)).collect();
        let step = self.pipeline.step(&timed);
        self.arm.frame(t_us, &step)?;
        self.recorder.step(&[Stamp { frame, t_s, missed: 0 }; CAMERAS.len()], &step).or_exit(Exit::Failed)?;

        let hand = self.scene.hand(index);
        let balls = CAMERAS.map(|view| self.scene.truth(index, view.index()));
        for (view, truths) in CAMERAS.iter().zip(&balls) {
            self.truth.balls(stamp, view.name(), truths).or_exit(Exit::Failed)?;
        }
        let first = self.scene.hand(0);
        self.truth.pose(stamp, &comparison::relative(&first, &hand)).or_exit(Exit::Failed)?;
        self.comparison.add(&step, &balls, hand);

        if self.picture_at.take_if(|at| frame >= *at).is_some() {
            let mut canvas = Canvas::side_by_side(views);
            for (view, CameraStep { report, .. }) in CAMERAS.iter().zip(&step.cameras) {
                canvas.draw(i32::from(self.scene.width) * view.index() as i32, report);
            }
            canvas.save(&self.args.out.join(PICTURE)).or_exit(Exit::Failed)?;
        }
        Ok(())
    }
}

fn report(
    comparison: &Comparison,
    cameras: &[(&'static str, CameraSummary)],
    arm: &ArmSummary,
    args: &DemoArgs,
) {
    let range = |spread: Option<Spread>, unit: &str| {
        spread.map_or_else(
            || "none".to_owned(),
            |s| format!("mean {:.2} {unit}, max {:.2} {unit}", s.mean, s.max),
        )
    };
    let BallCounts { in_sight, found, false_detections } = comparison.balls();
    say(format_args!("frames          {} tracked of {}", comparison.tracked(), comparison.frames()));
    say(format_args!("balls           {found} found of {in_sight} in sight, {false_detections} false"));
    say(format_args!("centre error    {}", range(comparison.centre_px(), "px")));
    say(format_args!(
        "pose error      {}; {}",
        range(comparison.position_mm(), "mm"),
        range(comparison.angle_deg(), "deg")
    ));
    say(format_args!("error a step    {}", range(comparison.step_mm(), "mm")));
    for (name, camera) in cameras {
        if let (Some(tested), Some(time)) = (camera.pixels_tested(), camera.tracking_us()) {
            say(format_args!(
                "{name:<15} {:.0} pixels tested a frame; {:.0} us a frame (p99 {:.0})",
                tested.mean, time.p50, time.p99
            ));
        }
    }
    report_arm(arm);
    say(format_args!("results         {}", args.out.display()));
}

/// How closely the arm followed, on the scene's clock: what a computer needs for tracking is not in it.
fn report_arm(arm: &ArmSummary) {
    match &arm.closeness {
        Some(close) => {
            say(format_args!(
                "arm             {:.0} ms behind the hand ({:.1} mm rms on the way); beside that {:.2} mm rms, max {:.2} mm, {:.2} deg rms",
                close.delay_s * 1e3,
                close.behind_rms_m * 1e3,
                close.rms_m * 1e3,
                close.max_m * 1e3,
                close.turn_rms_rad.to_degrees()
            ));
        }
        None => say("arm             never followed the hand"),
    }
    let (engaged, limited) = (arm.engaged * 100.0, arm.limited * 100.0);
    say(format_args!(
        "                engaged {engaged:.0} % of the time, {limited:.0} % of that at a limit"
    ));
    if let Some(status) = arm.status.filter(|status| status.state() != State::Engaged) {
        say(format_args!("                in the end {status}"));
    }
}
