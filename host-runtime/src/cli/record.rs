//! `tetrad record`: footage or live cameras in, one MCAP file out that `tetrad replay` runs again.

use super::interrupt::Interrupt;
use super::same_file;
use super::track::{inputs, micros, open, pipeline, starts};
use super::{note, progress, say};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::pipeline::{CameraStart, Pipeline};
use crate::session::schema::foxglove::Level;
use crate::session::schema::tetrad::Chain;
use crate::session::{Beginning, CameraBeginning, Pictures, SessionError, Steps, Tape};
use crate::settings::{InputArgs, InputSettings};
use crate::source::Frame;
use crate::streams::Streams;
use clap::Args;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

pub(super) const EXAMPLES: &str = "\
Examples:
  Two cameras for a minute, colours taught with `tetrad learn`:
    tetrad record --left /dev/video0 --right /dev/video2 --colours-left left.toml \\
                  --colours-right right.toml --arm-mm 80 --seconds 60 --out session.mcap
  Once more through the same pipeline, which must give the same bits:
    tetrad replay session.mcap --out replayed

The file holds the pictures as they were captured, what was seen in them, the hand, and all that the
tracker began with: 3.3 GB a minute for two cameras of 640x480 at 30 frames/s in RGB, 2.2 GB in YUYV. Foxglove and every
other reader of MCAP opens it; docs/sessions.md lists what is in it. Ctrl-C ends a live recording.";

/// The longest recording that can be asked for: a day.
const MAX_SECONDS: f64 = 86_400.0;

/// The flags of `tetrad record`.
#[derive(Args, Clone, Debug)]
pub(super) struct RecordArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The session's file; an older one of that name is lost
    #[arg(long, value_name = "FILE.mcap")]
    out: PathBuf,
    /// Ends after so many seconds by the pictures' clock [default: where the sources end, or with Ctrl-C]
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
}

/// What begins with the first frames.
struct Session {
    pipeline: Pipeline,
    tape: Tape,
    steps: Steps,
    began_us: u64,
    pairs: u64,
}

/// Runs `tetrad record`.
pub(super) fn run(args: &RecordArgs) -> Result<(), Failure> {
    if let Some(s) = args.seconds.filter(|s| !(*s > 0.0 && *s <= MAX_SECONDS)) {
        return Err(Failure::bad_arguments(format!(
            "--seconds {s}: a number above 0 and up to {MAX_SECONDS} is needed"
        )));
    }
    let settings = InputSettings::new(&args.input)?;
    same_file::refuse("--out", &args.out, inputs(&args.input))?;
    let mut streams = open(&settings, args.seconds)?;
    if !settings.has_pose() {
        note("there is no rigid frame of four balls in two cameras: no hand is solved for");
    }
    let interrupt = Interrupt::listen()?;
    let mut session = None;
    let outcome = record(args, &settings, &mut streams, &mut session, &interrupt);
    let Some(Session { tape, pairs, .. }) = session else { return outcome };
    let mut end = BTreeMap::from([("steps".to_owned(), pairs.to_string())]);
    if let Err(failure) = &outcome {
        end.insert("stopped by".to_owned(), format!("{:#}", failure.cause));
    }
    let recorded = tape.finish(end).map_err(|error| disk(error, pairs))?;
    outcome?;
    let megabytes = recorded.written.bytes as f64 / 1e6;
    say(format_args!(
        "{pairs} frames of each camera recorded in {}: {megabytes:.1} MB, {} messages",
        args.out.display(),
        recorded.written.messages
    ));
    Ok(())
}

fn disk(error: SessionError, pairs: u64) -> Failure {
    Failure::new(Exit::Failed, error)
        .help(format!("up to {pairs} frames were handed to it, and what reached the disk can be replayed: free some space, or give a --out elsewhere"))
}

fn record(
    args: &RecordArgs,
    settings: &InputSettings,
    streams: &mut Streams,
    session: &mut Option<Session>,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let bar = progress::frames(streams.frames());
    let cameras: Vec<Facts> = streams
        .iter()
        .map(|stream| Facts {
            fps: stream.source.info().fps,
            live: stream.source.info().live,
            now_s: stream.source.now_s(),
        })
        .collect();
    let unix_us = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_micros();
    let epoch_us = cameras.first().map_or(0, |facts| facts.epoch_us(unix_us as f64));
    let longest_us = args.seconds.map(|s| (s * 1e6).round() as u64);
    let end = streams.run(|frames| {
        let timed: Vec<(Frame<'_>, u64)> = frames.iter().map(|frame| (*frame, micros(frame.t_s))).collect();
        let t_us = timed.first().map_or(0, |(_, t_us)| *t_us);
        let Session { pipeline, tape, steps, began_us, pairs } = match session {
            Some(session) => session,
            None => {
                let starts = starts(settings, frames)?;
                let pipeline = pipeline(settings, &starts)?;
                let beginning = beginning(settings, &starts, frames, &cameras, epoch_us);
                let tape = Tape::start(&args.out, &beginning.message()).or_exit(Exit::BadArguments)?;
                let steps = Steps::new(tape.feed().clone(), beginning.names());
                session.insert(Session { pipeline, tape, steps, began_us: t_us, pairs: 0 })
            }
        };
        if longest_us.is_some_and(|longest_us| t_us.saturating_sub(*began_us) >= longest_us) {
            return Ok(ControlFlow::Break(()));
        }
        let views: Vec<_> = timed.iter().map(|(frame, t_us)| (frame.view, *t_us)).collect();
        let step = pipeline.step(&views);
        if !steps.step(&timed, &step) {
            // why is told when the tape is finished
            return Ok(ControlFlow::Break(()));
        }
        *pairs += 1;
        if *pairs == 1 {
            tape.feed().log(t_us, Level::Info, "recording begins");
        }
        bar.inc(1);
        Ok::<_, Failure>(if interrupt.asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    });
    bar.finish_and_clear();
    let notices: Vec<String> = streams.iter_mut().flat_map(|stream| stream.source.take_notices()).collect();
    notices.iter().for_each(note);
    end.map(drop)
}

/// What is known of a camera beside its pictures.
struct Facts {
    fps: Option<f64>,
    live: bool,
    now_s: Option<f64>,
}

impl Facts {
    /// The zero of its clock, Unix time; 0 where its times are of no clock.
    fn epoch_us(&self, unix_us: f64) -> u64 {
        match self.now_s.filter(|_| self.live) {
            Some(now_s) => (unix_us - now_s * 1e6).max(0.0) as u64,
            None => 0,
        }
    }
}

fn beginning(
    settings: &InputSettings,
    starts: &[CameraStart],
    frames: &[Frame<'_>],
    facts: &[Facts],
    epoch_us: u64,
) -> Beginning {
    let cameras = settings.cameras.iter().zip(starts).zip(frames).zip(facts);
    Beginning {
        chain: Chain::Pairs,
        mode: settings.mode,
        epoch_us,
        arm_m: settings.arm_m.filter(|_| settings.has_pose()),
        filter: settings.filter,
        cameras: cameras
            .map(|(((camera, start), frame), facts)| CameraBeginning {
                name: camera.name.to_owned(),
                source: camera.source.clone(),
                pictures: Some(Pictures {
                    size: (frame.view.width(), frame.view.height()),
                    format: frame.view.format(),
                    fps: facts.fps,
                }),
                start: *start,
                mode: settings.mode,
                rigid: settings.rigid,
            })
            .collect(),
    }
}
