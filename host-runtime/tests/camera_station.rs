//! `tetrad camera` as a program, seen by the station it talks to.

mod common;

use common::{command, tetrad};
use std::fs;
use std::io::Read as _;
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};
use tetrad::link::{Carrier as _, Link, LinkConfig, PeerConfig, StationName};
use tetrad::link::{Identity, Peer};
use tetrad::robot::clock::Clock;
use tetrad_core::observation::{BALLS, ObservationState};

const PATIENCE: Duration = Duration::from_secs(120);

fn name(text: &str) -> StationName {
    text.parse().expect("a name")
}

fn keys(dir: &Path) {
    for arguments in ["authority", "station left", "station right", "station operator"] {
        tetrad(dir, &format!("keys --out keys {arguments}")).done();
    }
}

/// An operator that dials the cameras at these ports.
fn operator(dir: &Path, cameras: &[(&str, u16)]) -> Link {
    let peer = |(camera, port): &(&str, u16)| PeerConfig {
        name: name(camera),
        address: Some(format!("127.0.0.1:{port}")),
    };
    let config = LinkConfig {
        listen: None,
        peers: cameras.iter().map(peer).collect(),
        picture_bytes_per_s: 2_500_000,
    };
    let identity = Identity::load(&dir.join("keys"), &name("operator")).expect("keys");
    Link::start(&config, &identity, Clock::wall()).expect("a link")
}

/// Writes NAME.toml, and gives the port.
fn station(dir: &Path, name: &str, camera: &str) -> u16 {
    // a port that is free now
    let port = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).expect("a port").port();
    let file = format!(
        "[station]\nname = \"{name}\"\nkeys = \"keys\"\nlisten = \"127.0.0.1:{port}\"\n\n\
         [[peer]]\nname = \"operator\"\n\n[camera]\n{camera}"
    );
    fs::write(dir.join(format!("{name}.toml")), file).expect("the file is written");
    port
}

/// A program that is killed with the test.
struct Station(Option<Child>);

impl Station {
    fn start(dir: &Path, name: &str) -> Self {
        let child = command(&format!("camera --config {name}.toml"))
            .current_dir(dir)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        Self(Some(child.expect("the program starts")))
    }

    fn child(mut self) -> Child {
        self.0.take().expect("once")
    }
}

impl Drop for Station {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            child.kill().and_then(|()| child.wait()).expect("it is killed");
        }
    }
}

/// Ends the program as Ctrl-C does, and gives how it ended and what it said.
fn interrupted(mut child: Child) -> (Option<i32>, String, String) {
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("kill").success());
    let code = child.wait().expect("it ends").code();
    let (mut out, mut err) = (String::new(), String::new());
    child.stdout.take().expect("piped").read_to_string(&mut out).expect("text");
    child.stderr.take().expect("piped").read_to_string(&mut err).expect("text");
    (code, out, err)
}

fn until<T>(what: &str, mut get: impl FnMut() -> Option<T>) -> T {
    let began = Instant::now();
    while began.elapsed() < PATIENCE {
        if let Some(got) = get() {
            return got;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("{what} never came");
}

#[test]
fn observations_and_pictures_come_until_ctrl_c() {
    let dir = tempfile::tempdir().expect("a directory");
    keys(dir.path());
    let camera = "source = \"sim:static-16px\"\nfps = 20\npreview_fps = 5\n";
    let port = station(dir.path(), "left", camera);
    let program = Station::start(dir.path(), "left");
    let link = operator(dir.path(), &[("left", port)]);
    let left: Peer = link.peer(&name("left")).expect("the peer");
    let mut last = None;
    for _ in 0..10 {
        let came = until("an observation", || left.observation(0));
        assert!(last < Some(came.what.sequence), "newer ones only");
        last = Some(came.what.sequence);
        assert_eq!((came.what.width, came.what.height), (640, 480));
        assert!(came.what.observed_us >= came.what.ready_us);
        let visible = came.what.balls.iter().filter(|ball| ball.state == ObservationState::Visible);
        assert_eq!(visible.count(), BALLS, "{came:?}");
    }
    let picture = until("a picture", || left.picture(0)).what;
    assert_eq!((picture.width, picture.height, &picture.jpeg[..2]), (640, 480, &[0xFF, 0xD8][..]));
    // once the clocks are compared, the time of capture is known here
    let came = until("a time of capture", || left.observation(0).filter(|came| came.captured_us.is_some()));
    assert!(came.captured_us < Some(came.received_us + 1_000_000));

    let (code, out, err) = interrupted(program.child());
    assert_eq!(code, Some(0), "{out}\n{err}");
    assert!(err.contains("link: operator is connected"), "{err}");
    for words in
        ["tracked", "red             visible", "tracking        p50", "operator        connected 1 times"]
    {
        assert!(out.contains(words), "no {words:?} in {out}");
    }
}

#[test]
fn two_stations_show_the_same_moment() {
    let dir = tempfile::tempdir().expect("a directory");
    keys(dir.path());
    // 50 mm from picture to picture; both have the same view, so that both see the same
    let camera = "source = \"sim:linear-0.5-30fps\"\nfps = 10\n";
    let ports = ["left", "right"].map(|name| (name, station(dir.path(), name, camera)));
    let _programs = ports.map(|(name, _)| Station::start(dir.path(), name));
    let link = operator(dir.path(), &ports);
    let peers = ports.map(|(camera, _)| link.peer(&name(camera)).expect("the peer"));
    let mut seen: [Vec<(u64, f32)>; 2] = Default::default();
    until("ten moments of both", || {
        for (peer, seen) in peers.iter().zip(&mut seen) {
            let came =
                peer.observation(0).filter(|came| came.what.balls[0].state == ObservationState::Visible);
            seen.extend(came.and_then(|came| Some((came.captured_us?, came.what.balls[0].centre.u))));
        }
        let [left, right] = &seen;
        let same = |at_us: u64| right.iter().find(|(other_us, _)| other_us.abs_diff(at_us) < 20_000);
        let pairs: Vec<_> = left.iter().filter_map(|(at_us, u)| Some((*u, same(*at_us)?.1))).collect();
        for (left_u, right_u) in &pairs {
            assert!((left_u - right_u).abs() < 0.1, "{pairs:?}");
        }
        // the hand rests now and then, and moments of rest show nothing
        let (least, most) = left.iter().fold((f32::MAX, 0.0_f32), |(a, b), (_, u)| (a.min(*u), b.max(*u)));
        (pairs.len() >= 10 && most - least > 20.0).then_some(())
    });
}

#[test]
fn a_station_that_was_killed_is_heard_again() {
    let dir = tempfile::tempdir().expect("a directory");
    keys(dir.path());
    let port = station(dir.path(), "left", "source = \"sim:static-16px\"\nfps = 20\n");
    let link = operator(dir.path(), &[("left", port)]);
    let left = link.peer(&name("left")).expect("the peer");
    let heard = || {
        let _program = Station::start(dir.path(), "left");
        until("an observation", || left.observation(0)).what.session
    };
    let first = heard();
    // what it sent last is not taken for the next one's
    let second = until("another session", || {
        let session = heard();
        (session != first).then_some(session)
    });
    assert_ne!(first, second);
}

#[test]
fn it_ends_after_its_time_with_nobody_listening() {
    let dir = tempfile::tempdir().expect("a directory");
    keys(dir.path());
    station(dir.path(), "left", "source = \"sim:static-16px\"\nfps = 10\n");
    let said = tetrad(dir.path(), "camera --config left.toml --seconds 1").done().stdout;
    assert!(said.contains("operator        connected 0 times"), "{said}");
}

#[test]
fn what_is_wrong_is_refused_with_the_mend() {
    let dir = tempfile::tempdir().expect("a directory");
    let run = || tetrad(dir.path(), "camera --config left.toml --seconds 1");
    run().refused(2, &["cannot read left.toml"]);
    station(dir.path(), "left", "source = \"sim:static-16px\"\n");
    run()
        .refused(2, &["left.toml: [station] keys", "keys/left.pem", "`tetrad keys --out keys station left`"]);
    keys(dir.path());
    station(dir.path(), "left", "source = \"sim:nothing\"\n");
    run().refused(2, &["sim:nothing", "no scene is called"]);
    fs::write(dir.path().join("colours.toml"), COLOURS).expect("written");
    station(dir.path(), "left", "source = \"/dev/video-none\"\ncolours = \"colours.toml\"\n");
    run().refused(3, &["/dev/video-none", "no such camera"]);
    fs::write(dir.path().join("left.toml"), "[camera]\nsource = \"sim:still\"\n").expect("written");
    run().refused(2, &["there is no [station]", "docs/stations.md"]);
    tetrad(dir.path(), "camera --config left.toml --seconds 0").refused(2, &["--seconds 0"]);
}

const COLOURS: &str = "\
[red]
reference = [203, 41, 52]
typical = [198, 44, 55]
background = [120, 118, 110]
diameter_px = 16.5
[green]
reference = [41, 203, 52]
typical = [44, 198, 55]
background = [120, 118, 110]
diameter_px = 16.5
[blue]
reference = [41, 52, 203]
typical = [44, 55, 198]
background = [120, 118, 110]
diameter_px = 16.5
[yellow]
reference = [203, 203, 52]
typical = [198, 198, 55]
background = [120, 118, 110]
diameter_px = 16.5
";
