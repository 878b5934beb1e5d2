//! `tetrad camera`: one camera, tracked where it is; observations to every peer.

use super::interrupt::Interrupt;
use super::memory::Memory;
use super::{note, say, tell_aside};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::link::{Carrier as _, Link, Peer, Picture};
use crate::precedence::Tracking;
use crate::robot::clock::Clock;
use crate::settings::station::{NetworkSettings, StationSettings};
use crate::station::camera::Step;
use crate::station::camera::Windows;
use crate::station::{CameraSink, CameraStation, Label, Marks, Preview};
use anyhow::Context as _;
use clap::Args;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tetrad_core::vision::frame::FrameView;
use tetrad_core::wire::ObservationPacket;

pub(super) const EXAMPLES: &str = "\
Examples:
  tetrad check  --config tetrad.toml
  tetrad camera --config tetrad.toml
It runs until Ctrl-C. A camera that goes away is opened again as soon as it is back; what happens is told
on standard error, and at the end what was seen and how long it took.";

/// A camera station has one camera.
const CAMERA: u8 = 0;

/// The longest run that can be asked for: a day.
const MAX_SECONDS: f64 = 86_400.0;

/// The flags of `tetrad camera`.
#[derive(Args, Clone, Debug)]
pub(super) struct CameraArgs {
    /// The station's file, with [station] and [camera]
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// End after so many seconds [default: at Ctrl-C]
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
}

/// Runs `tetrad camera`.
pub(super) fn run(args: &CameraArgs) -> Result<(), Failure> {
    let longest = match args.seconds {
        Some(s) if !(s > 0.0 && s <= MAX_SECONDS) => {
            return Err(Failure::bad_arguments(format!(
                "--seconds {s}: a number above 0 and up to {MAX_SECONDS} is needed"
            )));
        }
        seconds => seconds.map(Duration::from_secs_f64),
    };
    let settings = StationSettings::load(&args.config).or_exit(Exit::BadArguments)?;
    let missing = |table: &str| {
        let file = settings.file.display();
        Failure::bad_arguments(format!("{file}: there is no {table}, and a camera station needs it"))
            .help("docs/stations.md has a whole file for each station")
    };
    let network = settings.network.as_ref().ok_or_else(|| missing("[station]"))?;
    let camera = settings.camera.as_ref().ok_or_else(|| missing("[camera]"))?;
    let interrupt = Interrupt::listen()?;
    tell_aside()?;
    let clock = Clock::wall();
    let link = start(network, &clock)?;
    let label = Label { camera: CAMERA, session: link.session() };
    let mut station = CameraStation::open(&camera.camera, label, clock)?;
    let mut sink = Peers::new(&link, camera.preview_fps)?;
    note(format_args!("{}: {} is tracked", network.name, camera.camera.source));
    let mut memory = Memory::begin();
    let ended = work(&mut station, &mut sink, &link, &mut memory, (longest, &interrupt));
    tell(&mut station, &link);
    station.counts().lines().iter().for_each(say);
    report(&link);
    memory.report();
    ended
}

fn start(network: &NetworkSettings, clock: &Clock) -> Result<Link, Failure> {
    let identity = network.identity()?;
    network.start(&identity, clock.clone())
}

/// Picture after picture, until somebody or something ends it.
fn work(
    station: &mut CameraStation,
    sink: &mut Peers,
    link: &Link,
    memory: &mut Memory,
    (longest, interrupt): (Option<Duration>, &Interrupt),
) -> Result<(), Failure> {
    let mut tracking = Tracking::begin();
    let began = Instant::now();
    while !interrupt.asked() {
        if longest.is_some_and(|longest| began.elapsed() >= longest) {
            return if station.is_open() { Ok(()) } else { Err(lost()) };
        }
        match station.step(sink)? {
            Step::Observed => {}
            Step::Lost(wait) => std::thread::sleep(wait),
            Step::Ended => return Ok(()),
        }
        tracking.look();
        tell(station, link);
        memory.look();
    }
    Ok(())
}

fn lost() -> Failure {
    Failure::new(Exit::DeviceLost, anyhow::anyhow!("the camera was lost and did not come back in time"))
        .help("check its cable; `tetrad devices` lists the cameras there are")
}

fn tell(station: &mut CameraStation, link: &Link) {
    station.take_notices().iter().for_each(note);
    link.events().iter().for_each(note);
}

fn report(link: &Link) {
    for peer in link.peers() {
        let stats = peer.stats();
        say(format_args!(
            "{:<15} connected {} times, {} observations sent, {} overtaken, {} pictures sent",
            peer.name().as_str(),
            stats.connected,
            stats.sent.sent,
            stats.sent.overtaken,
            stats.pictures_sent.sent
        ));
    }
}

/// Every peer gets everything.
struct Peers {
    peers: Vec<Peer>,
    preview: Option<Preview>,
}

impl Peers {
    fn new(link: &Link, preview_fps: f64) -> Result<Self, Failure> {
        let peers: Vec<Peer> = link.peers().collect();
        let lookers = peers.clone();
        let send = move |picture: Picture, _: &ObservationPacket, _: &Windows| {
            for peer in &lookers {
                // one that is too large is one that nobody sees; the next may not be
                let _ = peer.send_picture(&picture);
            }
        };
        let preview =
            (preview_fps > 0.0).then(|| Preview::start(preview_fps, Marks::Drawn, send)).transpose();
        let preview = preview.context("the preview's thread cannot be started").or_exit(Exit::Failed)?;
        Ok(Self { peers, preview })
    }
}

impl CameraSink for Peers {
    fn observed(&mut self, packet: &ObservationPacket) {
        let packet = (*packet).into();
        for peer in &self.peers {
            // the tracker's numbers are finite; if they were not, the packet is as good as lost
            let _ = peer.send(&packet);
        }
    }

    fn pictured(&mut self, picture: &FrameView<'_>, packet: &ObservationPacket, windows: &Windows) {
        if let Some(preview) = &mut self.preview {
            preview.offer(picture, packet, windows);
        }
    }
}
