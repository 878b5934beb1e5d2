//! What is not as it should be at the moment, though the file can be meant: what is not plugged in, or is
//! another computer's. Nothing is opened.

use crate::link::authority::KeyFiles;
use crate::precedence::may_step_forward;
use crate::robot::canopen::CanopenAddress;
use crate::robot::{RobotAddress, RobotKind, val2};
use crate::settings::station::{
    ConsoleSettings, HandCamera, LocalCamera, NetworkSettings, SceneCamera, SlavePlace, SlaveSettings,
    StationSettings,
};
use crate::text_file::may_replace;
use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::path::Path;

/// Pictures a second, so that there are two in the half second after which one is stale.
const LEAST_PREVIEW_FPS: f64 = 4.0;

/// All there are, each with its key and what would mend it.
pub(super) fn notes(settings: &StationSettings) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(network) = &settings.network {
        notes.extend(network.link.listen.and_then(elsewhere));
        notes.extend(nowhere_known(network));
        notes.extend(of_keys(network));
        if settings.camera.is_some() && network.link.peers.is_empty() {
            notes.push("[[peer]]: there is none, so nobody gets what the camera sees".to_owned());
        }
    }
    if let Some(camera) = &settings.camera {
        notes.extend(no_camera("[camera] source", &camera.camera));
    }
    notes.extend(settings.camera.as_ref().and_then(|camera| flickers(camera.preview_fps)));
    notes.extend(settings.console.iter().flat_map(of_console));
    if settings.console.is_some() {
        notes.extend(not_kept(settings, may_replace));
    }
    if let Some(operator) = &settings.operator {
        for (number, camera) in (1..).zip(&operator.cameras) {
            let key = format!("[[operator.camera]] {number} source");
            notes.extend(match &camera.place {
                HandCamera::Station(_) => None,
                HandCamera::Serial { device, .. } => no_device(&key, device, "lists the serial ports"),
                HandCamera::Local(local) => no_camera(&key, local),
            });
        }
    }
    let here = settings.operator.as_ref().is_some_and(|operator| operator.slave == SlavePlace::Here);
    notes.extend(of_slave(&settings.slave, here));
    notes.extend(gives_way(may_step_forward()));
    notes
}

/// Motion that waits for whatever else this computer does. Under other systems nothing would mend that.
fn gives_way(may_go_first: bool) -> Option<String> {
    (cfg!(target_os = "linux") && !may_go_first).then(|| {
        "this computer: who runs this may have no real-time priorities, so that other programs can delay motion: \
         give rtprio 3 in /etc/security/limits.d, as docs/deploy.md says"
            .to_owned()
    })
}

/// Any free port is another one at each start.
fn nowhere_known(network: &NetworkSettings) -> Option<String> {
    let listen = network.link.listen.filter(|listen| listen.port() == 0 && !network.announce)?;
    Some(format!(
        "[station] listen: {listen} is another port at each start, and no peer can be told which: give one, as \
         {}:7420, or announce = true",
        listen.ip()
    ))
}

/// Keys that more people can take than have to.
fn of_keys(network: &NetworkSettings) -> Vec<String> {
    let keys = &network.keys;
    let mut notes = Vec::new();
    let own = KeyFiles::of_station(keys, &network.name).key;
    if is_everybodys(&own) {
        notes.push(format!(
            "[station] keys: everybody on this computer may read {}, and who has it is this station: `chmod \
             o= {0}`",
            own.display()
        ));
    }
    let authority = KeyFiles::of_authority(keys).key;
    if authority.exists() {
        notes.push(format!(
            "[station] keys: {} is here, and who has it can make any station: keep it where the keys are made, \
             and on no station",
            authority.display()
        ));
    }
    notes
}

/// The console's secrets that more people can take than have to.
fn of_console(console: &ConsoleSettings) -> Vec<String> {
    let secrets = [
        ("token_file", console.token_file.as_deref(), "who has it can move the arm"),
        ("key", console.tls.as_ref().map(|tls| tls.key.as_path()), "who has it can pass for this console"),
    ];
    let shared = secrets.into_iter().filter_map(|(key, file, what)| Some((key, file?, what)));
    let shared = shared.filter(|(_, file, _)| is_everybodys(file)).map(|(key, file, what)| {
        let file = file.display();
        format!("[console] {key}: everybody on this computer may read {file}, and {what}: `chmod o= {file}`")
    });
    shared.collect()
}

/// Files of an operator with a console that cannot keep what is set up there.
fn not_kept(settings: &StationSettings, may_replace: impl Fn(&Path) -> bool) -> Vec<String> {
    let Some(operator) = &settings.operator else { return Vec::new() };
    let arms = ("[operator] arm_mm".to_owned(), settings.file.as_path(), "the arms' length");
    let colours = (1..).zip(&operator.cameras).filter_map(|(number, camera)| {
        Some((format!("[[operator.camera]] {number} colours"), camera.colours.as_deref()?, "colours"))
    });
    let files = std::iter::once(arms).chain(colours).filter(|(_, file, _)| !may_replace(file));
    let notes = files.map(|(key, file, what)| {
        let file = file.display();
        format!(
            "{key}: the console could not keep {what} in {file}: whoever runs this may write no file in its folder; \
             docs/deploy.md gives the operator one of its own"
        )
    });
    notes.collect()
}

/// Pictures that come so seldom that each is stale before the next.
fn flickers(preview_fps: f64) -> Option<String> {
    let seldom = preview_fps > 0.0 && preview_fps < LEAST_PREVIEW_FPS;
    seldom.then(|| {
        format!(
            "[camera] preview_fps: {preview_fps} pictures a second are so far apart that each counts as stale \
             before the next has come: give {LEAST_PREVIEW_FPS} or more, or 0 for none"
        )
    })
}

#[cfg(unix)]
fn is_everybodys(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::metadata(file).is_ok_and(|data| data.permissions().mode() & 0o006 != 0)
}

#[cfg(not(unix))]
fn is_everybodys(_file: &Path) -> bool {
    false
}

fn of_slave(slave: &SlaveSettings, here: bool) -> Vec<String> {
    let mut notes: Vec<String> = slave.arm.port.as_ref().and_then(no_port).into_iter().collect();
    for (number, camera) in (1..).zip(&slave.cameras) {
        if let SceneCamera::Source(source) = &camera.place {
            let key = format!("[[slave.camera]] {number} source");
            notes.extend(
                no_device(&key, Path::new(source), "lists the cameras").filter(|_| is_device(source)),
            );
        }
    }
    if !slave.cameras.is_empty() && slave.operator.is_none() && !here {
        let mend = "name the station that sees them in [slave] operator";
        notes.push(format!("[[slave.camera]]: pictures go over the link alone: {mend}"));
    }
    notes
}

fn no_camera(key: &str, camera: &LocalCamera) -> Option<String> {
    no_device(key, Path::new(&camera.source), "lists the cameras").filter(|_| is_device(&camera.source))
}

fn is_device(source: &str) -> bool {
    Path::new(source).starts_with("/dev")
}

fn no_device(key: &str, device: &Path, lists: &str) -> Option<String> {
    let missing = !device.exists();
    missing.then(|| format!("{key}: {} is not there now; `tetrad devices` {lists}", device.display()))
}

/// An arm's port that is not there.
fn no_port(address: &RobotAddress) -> Option<String> {
    const KEY: &str = "[slave] port";
    match address.kind() {
        RobotKind::Simulated(_) => None,
        RobotKind::DryRun(file) => {
            let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty())?;
            let missing = !folder.is_dir();
            missing.then(|| format!("{KEY}: there is no folder {}: make it", folder.display()))
        }
        RobotKind::Val2(place) => {
            // it was understood before
            let (device, _) = val2::parse(place, &val2::Val2Config::default()).ok()?;
            no_device(KEY, Path::new(&device), "lists the serial ports")
        }
        RobotKind::Canopen(CanopenAddress::Slcan { path: device, .. }) => {
            no_device(KEY, Path::new(device), "lists the serial ports")
        }
        RobotKind::Canopen(CanopenAddress::Interface(name)) => {
            no_device(KEY, &Path::new("/sys/class/net").join(name), "lists the CAN interfaces")
        }
    }
}

/// An address to listen on that is not this computer's. Whether the port is free is not asked: the
/// station itself may have it.
fn elsewhere(listen: SocketAddr) -> Option<String> {
    let any_port = SocketAddr::new(listen.ip(), 0);
    let error = UdpSocket::bind(any_port).err()?;
    (error.kind() == io::ErrorKind::AddrNotAvailable).then(|| {
        format!(
            "[station] listen: {} is no address of this computer now; 0.0.0.0 and [::] are all of them",
            listen.ip()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(address: &str) -> Option<String> {
        no_port(&address.parse().unwrap())
    }

    #[test]
    fn a_port_that_is_not_there_is_told_with_its_key() {
        for (address, words) in [
            ("val2:/dev/ttyNONE?baud=9600", "/dev/ttyNONE is not there now"),
            ("canopen:can-none", "can-none is not there now"),
            ("canopen+slcan:/dev/ttyNONE", "/dev/ttyNONE is not there now"),
            ("dry-run:/no/where/x.csv", "there is no folder /no/where"),
        ] {
            let note = port(address).unwrap_or_default();
            assert!(note.starts_with("[slave] port: ") && note.contains(words), "{address}: {note}");
        }
        for there in ["sim:", "dry-run:x.csv", "val2:/dev/null"] {
            assert_eq!(port(there), None);
        }
    }

    #[test]
    #[cfg(unix)]
    fn a_token_that_everybody_may_read_is_told() {
        use std::os::unix::fs::PermissionsExt as _;
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("token");
        std::fs::write(&file, "x").unwrap();
        let console = ConsoleSettings { token_file: Some(file.clone()), ..ConsoleSettings::demo() };
        for (mode, notes) in [(0o644, 1), (0o640, 0), (0o600, 0)] {
            std::fs::set_permissions(&file, std::fs::Permissions::from_mode(mode)).unwrap();
            let told = of_console(&console);
            assert_eq!(told.len(), notes, "{mode:o}: {told:?}");
            assert!(told.iter().all(|note| note.starts_with("[console] token_file: everybody ")), "{told:?}");
        }
    }

    #[test]
    fn what_the_console_cannot_keep_is_told() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("operator.toml");
        let text = "[operator]\narm_mm = 80\nslave = \"here\"\n[[operator.camera]]\nsource = \"sim:still\"\n\
                    [console]\nlisten = \"127.0.0.1:0\"\n";
        std::fs::write(&file, text).unwrap();
        let mut settings = StationSettings::load(&file).unwrap();
        assert!(!notes(&settings).iter().any(|note| note.contains("could not keep")), "it can be written");
        let camera = &mut settings.operator.as_mut().unwrap().cameras[0];
        camera.colours = Some(dir.path().join("gone").join("left.toml"));
        let told = |settings: &StationSettings| {
            let all = notes(settings);
            all.into_iter().filter(|note| note.contains("could not keep")).collect::<Vec<_>>()
        };
        let one = told(&settings);
        assert!(one.len() == 1 && one[0].starts_with("[[operator.camera]] 1 colours: "), "{one:?}");
        let both = not_kept(&settings, |_| false);
        assert!(
            both.len() == 2 && both[0].starts_with("[operator] arm_mm: the console could not keep"),
            "{both:?}"
        );
        // who has no console keeps nothing
        settings.console = None;
        assert!(told(&settings).is_empty());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn motion_that_gives_way_is_told() {
        assert_eq!(gives_way(true), None);
        let note = gives_way(false).unwrap_or_default();
        assert!(note.contains("real-time priorities") && note.contains("docs/deploy.md"), "{note}");
    }

    #[test]
    fn pictures_that_flicker_are_told() {
        for (fps, told) in [(0.0, false), (2.0, true), (4.0, false), (5.0, false)] {
            assert_eq!(flickers(fps).is_some(), told, "{fps}");
        }
    }

    #[test]
    fn an_address_of_another_computer_is_told() {
        // documentation's own network (RFC 5737): nobody has it
        let note = elsewhere("192.0.2.1:7420".parse().unwrap()).unwrap_or_default();
        assert!(note.starts_with("[station] listen: 192.0.2.1 is no address"), "{note}");
        let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
        assert_eq!(elsewhere(taken.local_addr().unwrap()), None, "a port in use is not asked for");
    }
}
