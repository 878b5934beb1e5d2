//! `tetrad track`: footage or live cameras in, CSV files out.

mod node;

use super::interrupt::Interrupt;
use super::same_file::{self, Input};
use super::{make_results_dir, note, progress, say};
use crate::camera_start::{Named, camera_start};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::output::{RecordedCamera, Recorder, Stamp, Summary};
use crate::pipeline::Step;
use crate::pipeline::{CameraStart, Pipeline};
use crate::settings::{InputArgs, InputSettings, TrackArgs, TrackSettings};
use crate::source::{self, Frame, Gap, Options, View};
use crate::station::MotionSender;
use crate::streams::{End, Stream, Streams};
use anyhow::Context as _;
use std::fs::File;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;

pub(super) const EXAMPLES: &str = "\
Examples:
  Two cameras, colours taught with `tetrad learn`:
    tetrad track --left /dev/video0 --right /dev/video2 --colours-left left.toml \\
                 --colours-right right.toml --arm-mm 80 --out run1
  Footage with the places of the balls in the first frame:
    tetrad track --left clip/left --right clip/right --scene clip/scene.json --out run1
  A smart camera on a serial port, which learns the balls where the scene says they are:
    tetrad track --left node:serial:/dev/ttyACM0 --scene scene.json --out run1
  Two of the balls in one camera:
    tetrad track --left toss.y4m --colours-left toss.toml --balls red,yellow --out run1

DIR gets observations.csv, pose.csv, filtered.csv, motion.csv, summary.json and what is known of
the errors. Ctrl-C ends a live run.";

/// Runs `tetrad track`.
pub(super) fn run(args: TrackArgs) -> Result<(), Failure> {
    same_file::refuse_in("--out", &args.out, inputs(&args.input))?;
    if let Some(packets) = args.packets.as_deref().filter(|packets| !is_standard_output(packets)) {
        same_file::refuse("--packets", packets, inputs(&args.input))?;
    }
    let settings = TrackSettings::new(args)?;
    if let Some(place) = node::place(&settings.input)? {
        return node::run(&settings, &place);
    }
    let mut streams = open(&settings.input, None)?;
    make_results_dir(&settings.out)?;
    note_without_pose(&settings.input);
    let interrupt = Interrupt::listen()?;
    let mut session = None;
    let outcome = track(&settings, &mut streams, &mut session, &interrupt);
    finish(&settings, session.map(|session| session.recorder), outcome.map(drop))
}

/// Which files stay empty, and why.
fn note_without_pose(settings: &InputSettings) {
    if !settings.has_pose() {
        let reason = if settings.cameras.len() < 2 { "one camera" } else { "no rigid frame of four balls" };
        note(format_args!("{reason}: pose.csv, filtered.csv and motion.csv get no rows"));
    }
}

/// Writes the summary of what was begun, and prints it where the run ended well.
fn finish(
    settings: &TrackSettings,
    begun: Option<Recorder>,
    outcome: Result<(), Failure>,
) -> Result<(), Failure> {
    let Some(recorder) = begun else { return outcome };
    let stopped_by = outcome.as_ref().err().map(|failure| format!("{:#}", failure.cause));
    let written = recorder.finish(stopped_by).or_exit(Exit::Failed);
    outcome?;
    // standard output may be the packets'
    let to_packets = settings.packets.as_deref().is_some_and(is_standard_output);
    let print: fn(std::fmt::Arguments<'_>) = if to_packets { |line| note(line) } else { |line| say(line) };
    report(&written?, settings, print);
    Ok(())
}

/// The files that are read.
pub(super) fn inputs(args: &InputArgs) -> Vec<Input<'_>> {
    let sources = [("--left", Some(&args.left)), ("--right", args.right.as_ref())];
    let files = [
        ("--colours-left", &args.colours_left),
        ("--colours-right", &args.colours_right),
        ("--scene", &args.scene),
    ];
    let sources = sources.into_iter().filter_map(|(flag, spec)| Input::source(flag, spec?));
    sources
        .chain(files.into_iter().filter_map(|(flag, file)| Some(Input::new(flag, file.as_ref()?))))
        .collect()
}

/// What begins with the first frames.
struct Session {
    pipeline: Pipeline,
    recorder: Recorder,
    packets: Option<PacketsOut>,
}

/// Where the hand's motion is sent.
struct PacketsOut {
    sender: MotionSender,
    out: Box<dyn Write>,
    name: String,
}

fn is_standard_output(file: &Path) -> bool {
    file == Path::new("-")
}

impl PacketsOut {
    fn create(file: &Path) -> Result<Self, Failure> {
        let name = file.display().to_string();
        let (out, name): (Box<dyn Write>, String) = if is_standard_output(file) {
            (Box::new(io::stdout()), "standard output".to_owned())
        } else {
            let made = File::create(file).with_context(|| format!("cannot write {name}"));
            (Box::new(made.or_exit(Exit::BadArguments)?), name)
        };
        Ok(Self { sender: MotionSender::new(super::session()), out, name })
    }

    /// Sends one step. There is no operator here who could let go: engaged means that the hand is
    /// tracked, and it is the slave's hold-to-run that moves the arm.
    fn send(&mut self, step: &Step, capture_us: u64) -> Result<(), Failure> {
        let Some(packet) = self.sender.packet(step, capture_us, true) else { return Ok(()) };
        // the tracker's numbers are finite; if they were not, the packet is as good as lost
        let Ok(frame) = self.sender.frame(packet) else { return Ok(()) };
        let sent = self.out.write_all(frame).and_then(|()| self.out.flush());
        sent.with_context(|| format!("cannot send packets to {}", self.name)).or_exit(Exit::DeviceLost)
    }
}

/// Opens the cameras; a scene goes on for `scene_s` seconds, or for as long as it is.
pub(super) fn open(settings: &InputSettings, scene_s: Option<f64>) -> Result<Streams, Failure> {
    let mut opened = settings.cameras.iter().map(|camera| {
        let view = if camera.name == "right" { View::Right } else { View::Left };
        let options = Options { view, fps: settings.fps, scene_s, ..Options::default() };
        let mut source = source::open(&camera.source, &options)?;
        source.take_notices().iter().for_each(note);
        Ok::<_, Failure>(Stream { name: camera.name, source })
    });
    let left = opened.next().ok_or_else(|| Failure::bad_arguments("no camera is given"))??;
    let right = opened.next().transpose()?;
    Ok(Streams::new(left, right))
}

fn track(
    settings: &TrackSettings,
    streams: &mut Streams,
    session: &mut Option<Session>,
    interrupt: &Interrupt,
) -> Result<End, Failure> {
    let cameras: Vec<RecordedCamera> = streams
        .iter()
        .map(|stream| {
            let info = stream.source.info();
            RecordedCamera { name: stream.name, source: info.name.clone(), size: (info.width, info.height) }
        })
        .collect();
    let bar = progress::frames(streams.frames());
    let end = streams.run(|frames| {
        let Session { pipeline, recorder, packets } = match session {
            Some(session) => session,
            None => {
                let input = &settings.input;
                let pipeline = pipeline(input, &starts(input, frames)?)?;
                let recorder =
                    Recorder::create(&settings.out, input.mode.name(), cameras.clone(), input.balls)
                        .or_exit(Exit::Failed)?;
                let packets = settings.packets.as_deref().map(PacketsOut::create).transpose()?;
                session.insert(Session { pipeline, recorder, packets })
            }
        };
        let views: Vec<_> = frames.iter().map(|frame| (frame.view, micros(frame.t_s))).collect();
        let stamps: Vec<_> = frames.iter().map(stamp).collect();
        let step = pipeline.step(&views);
        recorder.step(&stamps, &step).or_exit(Exit::Failed)?;
        if let (Some(packets), Some((_, t_us))) = (packets, views.first()) {
            packets.send(&step, *t_us)?;
        }
        bar.inc(1);
        Ok(if interrupt.asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    });
    bar.finish_and_clear();
    streams.iter_mut().for_each(|stream| stream.source.take_notices().iter().for_each(note));
    end
}

/// What the first frames start with: colours from files, or learnt at the seeds.
pub(super) fn starts(settings: &InputSettings, frames: &[Frame<'_>]) -> Result<Vec<CameraStart>, Failure> {
    let mut cameras: Vec<CameraStart> = Vec::new();
    for (camera, frame) in settings.cameras.iter().zip(frames) {
        let named = Named { name: camera.name, source: &camera.source };
        let start = camera_start(named, &camera.start, &frame.view)?;
        cameras.push(CameraStart { focal_px: camera.focal_px, ..start });
    }
    Ok(cameras)
}

/// The pipeline that starts with them.
pub(super) fn pipeline(settings: &InputSettings, cameras: &[CameraStart]) -> Result<Pipeline, Failure> {
    let mut config = settings.mode.pipeline();
    config.tracker.rigid = settings.rigid;
    let arms = match settings.arm_m.filter(|_| settings.has_pose()) {
        Some(length_m) => Some(Arms::equal(length_m).or_exit(Exit::BadArguments)?),
        None => None,
    };
    let filter = PoseFilter::new(settings.filter).or_exit(Exit::BadArguments)?;
    let pipeline = Pipeline::new(cameras, config, arms).map_err(|(camera, error)| {
        let name = settings.cameras.get(camera).map_or("", |camera| camera.name);
        let cause = anyhow::Error::new(error).context(format!("the {name} camera cannot be tracked"));
        Failure::new(Exit::BadArguments, cause)
    })?;
    Ok(pipeline.with_filter(filter))
}

fn stamp(frame: &Frame<'_>) -> Stamp {
    let missed = match frame.gap {
        Gap::Missed(frames) => frames,
        // nobody knows how many
        Gap::None | Gap::Unknown => 0,
    };
    Stamp { frame: frame.number, t_s: frame.t_s, missed }
}

/// Seconds to whole microseconds; a time before the clock's zero is zero.
pub(super) fn micros(t_s: f64) -> u64 {
    (t_s * 1e6).round() as u64
}

fn report(summary: &Summary, settings: &TrackSettings, say: fn(std::fmt::Arguments<'_>)) {
    say(format_args!("{} frames tracked, results in {}", summary.frames, settings.out.display()));
    for (name, camera) in &summary.cameras {
        let seen: Vec<String> = camera
            .states()
            .iter()
            .map(|(ball, counts)| format!("{ball} {}", counts.visible + counts.occluded))
            .collect();
        say(format_args!("  {name}: frames in which each ball was seen: {}", seen.join(", ")));
        if camera.missed() > 0 {
            say(format_args!("  {name}: {} frames are missing in between", camera.missed()));
        }
        if let (Some(time), Some(tested)) = (camera.tracking_us(), camera.pixels_tested()) {
            say(format_args!(
                "  {name}: {:.0} us a frame (p99 {:.0}), {:.0} pixels tested",
                time.p50, time.p99, tested.mean
            ));
        }
    }
}
