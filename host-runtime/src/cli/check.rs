//! `tetrad check`: what a station's file means, before anything is opened or moves.

mod notes;

use super::{devices, say};
use crate::console::{Checklist, Files};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::link::MDNS;
use crate::settings::Start;
use crate::settings::station::{
    CameraSettings, CameraStart, ConsoleSettings, HandCamera, LocalCamera, NetworkSettings, OperatorSettings,
    SceneCamera, SlavePlace, SlaveSettings, StationSettings,
};
use anyhow::Context as _;
use clap::Args;
use std::fmt::Display;
use std::path::PathBuf;
use tetrad_core::config::Workspace;

pub(super) const EXAMPLES: &str = "\
Examples:
  tetrad check --config tetrad.toml
It reads the file, the colours, keys and secrets that it names, and says what each station that runs with it
would do. It opens no device and moves nothing. An error names the key and what would mend it; a note says
what is not as it should be on this computer at the moment, such as a camera that is not plugged in.
docs/stations.md lists the keys.";

/// The flags of `tetrad check`.
#[derive(Args, Clone, Debug)]
pub(super) struct CheckArgs {
    /// The station's file
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

/// Runs `tetrad check`.
pub(super) fn run(args: &CheckArgs) -> Result<(), Failure> {
    let settings = StationSettings::load(&args.config).or_exit(Exit::BadArguments)?;
    match &settings.network {
        Some(network) => {
            network.identity()?;
            tell_network(network);
        }
        None => row("station", "alone: without [station] it talks to nobody"),
    }
    if let Some(camera) = &settings.camera {
        tell_camera_station(camera);
    }
    if let Some(operator) = &settings.operator {
        tell_operator(operator);
    }
    if let Some(console) = &settings.console {
        let file = settings.file.display();
        Files::read(console)
            .with_context(|| format!("{file}: there would be no console"))
            .or_exit(Exit::BadArguments)?;
        tell_console(console);
    }
    let here = settings.operator.as_ref().is_some_and(|operator| operator.slave == SlavePlace::Here);
    if here || settings.slave.operator.is_some() || settings.slave.arm.port.is_some() {
        tell_slave(&settings.slave, here);
    }
    let ready = ready(&settings);
    if ready.is_empty() {
        return Err(Failure::bad_arguments(format!(
            "{}: it makes this no station: there is none of [camera], [operator] and [slave]",
            settings.file.display()
        ))
        .help("docs/stations.md has a whole file for each station"));
    }
    notes::notes(&settings).iter().for_each(|note| row("note", note));
    row("ready for", ready.join(", "));
    Ok(())
}

/// What the console's page shows of it: of a station's file, where there is one, and of this computer.
pub(super) fn checklist(station: Option<&StationSettings>) -> Checklist {
    Checklist {
        file: station.map(|station| station.file.display().to_string()),
        notes: station.map_or_else(Vec::new, notes::notes),
        devices: devices::listed(),
    }
}

/// The commands that the file is enough for.
fn ready(settings: &StationSettings) -> Vec<String> {
    let linked = settings.network.is_some();
    let commands = [
        ("camera", settings.camera.is_some() && linked),
        ("operator", settings.operator.is_some()),
        ("slave", settings.slave.operator.is_some() || settings.slave.arm.port.is_some()),
    ];
    let enough = commands.into_iter().filter(|(_, enough)| *enough);
    enough.map(|(name, _)| format!("tetrad {name} --config {}", settings.file.display())).collect()
}

fn row(label: &str, text: impl Display) {
    say(format_args!("{label:<15} {text}"));
}

fn tell_network(network: &NetworkSettings) {
    let NetworkSettings { name, keys, announce, link, file: _ } = network;
    row("station", format_args!("{name}, with its certificate and key in {}", keys.display()));
    match link.listen {
        Some(address) => row("listens", format_args!("on {address} (UDP)")),
        None => row("listens", "nowhere: it dials"),
    }
    if *announce {
        row("announced", "on the local network, by multicast DNS");
    }
    for peer in &link.peers {
        let name = &peer.name;
        match &peer.address {
            Some(address) if address == MDNS => {
                row("peer", format_args!("{name}, dialled where it announces itself on the local network"));
            }
            Some(address) => row("peer", format_args!("{name}, dialled at {address}")),
            None => row("peer", format_args!("{name}, which dials this station")),
        }
    }
    if link.peers.is_empty() {
        row("peer", "none: nobody gets in");
    }
    row("pictures", format_args!("at most {} kB/s to each peer", link.picture_bytes_per_s / 1000));
}

fn tell_camera_station(settings: &CameraSettings) {
    row("camera", camera(&settings.camera));
    let preview = settings.preview_fps;
    if preview > 0.0 {
        row("", format_args!("{preview} pictures a second go along, to be looked at"));
    }
}

fn camera(camera: &LocalCamera) -> String {
    let start = match &camera.start {
        CameraStart::OfScene => "colours as the scene has them".to_owned(),
        CameraStart::Given(Start::Colours(_)) => "colours from a file".to_owned(),
        CameraStart::Given(Start::Seeds { file, .. }) => format!("colours learnt where {file} says"),
    };
    let focal = camera.focal_px.map_or(String::new(), |px| format!(", focal length {px} px"));
    let fps = camera.options.fps.map_or(String::new(), |fps| format!(", {fps} frames/s"));
    format!(
        "{} ({} view), {start}{fps}{focal}, {} mode",
        camera.source,
        camera.options.view.name(),
        camera.mode.name()
    )
}

fn tell_operator(operator: &OperatorSettings) {
    row(
        "hand",
        format_args!("arms of {:.1} mm, seen by {}", operator.arm_m * 1000.0, operator.cameras.len()),
    );
    for (index, seen) in operator.cameras.iter().enumerate() {
        let focal = seen.focal_px.map_or(String::new(), |px| format!(", focal length {px} px"));
        let what = match &seen.place {
            HandCamera::Station(name) => format!("the station {name}{focal}"),
            HandCamera::Serial { device, baud, colours, preview_every } => {
                let taught = if colours.is_some() { ", taught from its file of colours" } else { "" };
                let shown = match preview_every {
                    0 => String::new(),
                    every => format!(", a ball shown every {every} pictures"),
                };
                format!("a smart camera on {}, {baud} bits/s{taught}{shown}{focal}", device.display())
            }
            HandCamera::Local(local) => camera(local),
        };
        row(&format!("  camera {}", index + 1), what);
    }
    match &operator.slave {
        SlavePlace::Here => row("arm", "at this station"),
        SlavePlace::Station(name) => row("arm", format_args!("at the station {name}")),
    }
}

fn tell_console(console: &ConsoleSettings) {
    let whom = if console.listen.ip().is_loopback() { "for this computer alone" } else { "over TLS" };
    let token = if console.token_file.is_some() { ", with a token" } else { "" };
    row("console", format_args!("at {}, {whom}{token}", console.listen));
    let mut known = vec!["its addresses".to_owned()];
    known.extend(console.names.iter().cloned());
    known.extend(console.tls.iter().map(|_| "what its certificate is made out to".to_owned()));
    if !console.listen.ip().is_loopback() {
        row("", format_args!("known as {}", known.join(", ")));
    }
}

fn tell_slave(slave: &SlaveSettings, here: bool) {
    let SlaveSettings { arm, operator, cameras } = slave;
    let address = arm.port.clone().unwrap_or_default();
    let moves = if address.moves_an_arm() { "moves a real arm" } else { "moves no real arm" };
    row("arm", format_args!("at {address}, {moves}"));
    match operator.as_ref().filter(|_| !here) {
        Some(name) => row("driven by", format_args!("the station {name} alone")),
        None if here => row("driven by", "this very station"),
        None => row("driven by", "packets of `tetrad track` from a pipe or a file"),
    }
    let config = &arm.slave;
    row("workspace", workspace(&config.teleop.workspace));
    let speed = config.governor.max_tool_speed_m_s;
    let (scale, timeout) = (config.teleop.scale, config.teleop.command_timeout_us / 1000);
    row("limits", format_args!("tool at most {:.0} mm/s, {scale} times the hand's way", speed * 1000.0));
    row("", format_args!("it stops {timeout} ms after the last command that is fresh"));
    for seen in cameras {
        let source = match &seen.place {
            SceneCamera::SimulatedArm => "a drawing of the arm",
            SceneCamera::Source(source) => source,
        };
        let (view, fps, quality) = (seen.options.view.name(), seen.fps, seen.quality);
        row("scene", format_args!("{source} ({view} eye), {fps} pictures/s, JPEG quality at most {quality}"));
    }
}

fn workspace(workspace: &Workspace) -> String {
    let mm = |m: f64| (m * 1000.0).round();
    let axes = ["x", "y", "z"].into_iter().zip(workspace.min_m.iter().zip(&workspace.max_m));
    let axes = axes.map(|(axis, (min, max))| format!("{axis} {} to {}", mm(*min), mm(*max)));
    format!("{} mm", axes.collect::<Vec<_>>().join(", "))
}
