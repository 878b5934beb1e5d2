//! `tetrad track --left node:serial:DEVICE`: a smart camera does the seeing, and is taught, started and
//! stopped from here.

use super::{PacketsOut, finish, note_without_pose};
use crate::camera_start::{Named, fits};
use crate::cli::interrupt::Interrupt;
use crate::cli::{make_results_dir, note, progress, session};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::output::{RecordedCamera, Recorder, Stamp};
use crate::pipeline::{CameraStep, HandStage, Step};
use crate::settings::smart_camera::SerialPlace;
use crate::settings::{CameraSettings, InputSettings, Start, TrackSettings};
use crate::station::node::Seen;
use crate::station::{SmartCamera, SmartCameraError};
use std::time::Duration;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::vision::tracker::StepReport;

/// The smart camera among the sources, if there is one.
///
/// # Errors
/// [`Exit::BadArguments`]: it is not the only camera, or its port makes no sense.
pub(super) fn place(settings: &InputSettings) -> Result<Option<SerialPlace>, Failure> {
    let mut places = settings.cameras.iter().map(|camera| (camera, SerialPlace::of(&camera.source)));
    let Some((camera, Some(place))) = places.find(|(_, place)| place.is_some()) else { return Ok(None) };
    let CameraSettings { name, source, .. } = camera;
    if settings.cameras.len() > 1 {
        return Err(Failure::bad_arguments(format!("--{name} {source}: a smart camera is tracked alone"))
            .help("leave the other camera out; an operator joins several, each an [[operator.camera]]"));
    }
    place.map(Some).map_err(|problem| Failure::bad_arguments(format!("--{name} {source}: {problem}")))
}

/// Tracks with it.
pub(super) fn run(settings: &TrackSettings, place: &SerialPlace) -> Result<(), Failure> {
    let Some(camera) = settings.input.cameras.first() else {
        return Err(Failure::bad_arguments("no camera is given"));
    };
    let mut hand = hand(&settings.input)?;
    make_results_dir(&settings.out)?;
    note_without_pose(&settings.input);
    let interrupt = Interrupt::listen()?;
    let opened = SmartCamera::open(&place.device, place.baud, session());
    let mut eye = opened.map_err(|error| error.of(&camera.source))?;
    prepare(&mut eye, camera)?;
    let mut begun: Option<Begun> = None;
    let outcome = follow(settings, camera, &mut eye, &mut hand, &mut begun, &interrupt);
    // one that went away is not told
    let is_gone = outcome.as_ref().is_err_and(|failure| failure.cause.is::<SmartCameraError>());
    if !is_gone && let Err(error) = eye.stop() {
        note(format_args!("{}: it was not stopped: {error}", camera.source));
    }
    eye.take_notices().iter().for_each(note);
    finish(settings, begun.map(|begun| begun.recorder), outcome)
}

/// What begins with the first observation.
struct Begun {
    recorder: Recorder,
    packets: Option<PacketsOut>,
}

/// Teaches it, and starts it.
fn prepare(eye: &mut SmartCamera, camera: &CameraSettings) -> Result<(), Failure> {
    let taught = match &camera.start {
        Start::Colours(colours) => eye.teach(&colours.learnt_balls()),
        Start::Seeds { seeds, .. } => eye.learn(seeds).map(drop),
    };
    taught.and_then(|()| eye.start()).map_err(|error| error.of(&camera.source))
}

/// The hand, where one camera is to tell its pose.
fn hand(settings: &InputSettings) -> Result<Option<HandStage>, Failure> {
    let Some(length_m) = settings.arm_m.filter(|_| settings.has_pose()) else { return Ok(None) };
    let arms = Arms::equal(length_m).or_exit(Exit::BadArguments)?;
    let filter = PoseFilter::new(settings.filter).or_exit(Exit::BadArguments)?;
    let config = settings.mode.pipeline();
    Ok(Some(HandStage::new(config.hand_mode, arms, config.hand, filter)))
}

fn follow(
    settings: &TrackSettings,
    camera: &CameraSettings,
    eye: &mut SmartCamera,
    hand: &mut Option<HandStage>,
    begun: &mut Option<Begun>,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let bar = progress::frames(None);
    loop {
        let next = eye.next(|| interrupt.asked()).map_err(|error| error.of(&camera.source))?;
        eye.take_notices().iter().for_each(note);
        let Some(seen) = next else { break };
        let Begun { recorder, packets } = match begun {
            Some(begun) => begun,
            None => begun.insert(begin(settings, camera, &seen)?),
        };
        let step = step(camera, hand.as_mut(), &seen);
        recorder.step(&[stamp(&seen)], &step).or_exit(Exit::Failed)?;
        if let Some(packets) = packets {
            packets.send(&step, seen.packet.capture_us)?;
        }
        bar.inc(1);
        if interrupt.asked() {
            break;
        }
    }
    bar.finish_and_clear();
    Ok(())
}

fn begin(settings: &TrackSettings, camera: &CameraSettings, seen: &Seen) -> Result<Begun, Failure> {
    let size = (seen.packet.width, seen.packet.height);
    let named = Named { name: camera.name, source: &camera.source };
    if let Start::Colours(colours) = &camera.start {
        fits(named, &colours.learnt_balls(), size)?;
    }
    let recorded = RecordedCamera { name: camera.name, source: camera.source.clone(), size };
    let (mode, balls) = (settings.input.mode.name(), settings.input.balls);
    let recorder = Recorder::create(&settings.out, mode, vec![recorded], balls).or_exit(Exit::Failed)?;
    let packets = settings.packets.as_deref().map(PacketsOut::create).transpose()?;
    Ok(Begun { recorder, packets })
}

/// The numbers and times are the camera's own: its first picture since it was switched on is 0.
fn stamp(Seen { packet, missed }: &Seen) -> Stamp {
    Stamp { frame: packet.sequence.into(), t_s: packet.capture_us as f64 / 1e6, missed: (*missed).into() }
}

fn step(camera: &CameraSettings, hand: Option<&mut HandStage>, Seen { packet, .. }: &Seen) -> Step {
    let report =
        StepReport { observations: packet.balls, tested: packet.pixels_tested, ..StepReport::default() };
    let tracking = Duration::from_micros(packet.observed_us.saturating_sub(packet.ready_us).into());
    let nominal = CameraModel::nominal(packet.width, packet.height);
    let model = CameraModel { focal_px: camera.focal_px.unwrap_or(nominal.focal_px), ..nominal };
    let view = HandView { balls: packet.balls, camera: model };
    let hand = hand.map(|hand| hand.step(&[view], packet.capture_us));
    Step { cameras: vec![CameraStep { report, tracking }], hand }
}
