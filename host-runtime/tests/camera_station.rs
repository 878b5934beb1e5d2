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
    for arguments in ["authority", "station left", "station operator"] {
        tetrad(dir, &format!("keys --out keys {arguments}")).done();
    }
}

/// An operator that dials the camera at this port.
fn operator(dir: &Path, port: u16) -> Link {
    let config = LinkConfig {
        listen: None,
        peers: vec![PeerConfig { name: name("left"), address: Some(format!("127.0.0.1:{port}")) }],
        picture_bytes_per_s: 2_500_000,
    };
    let identity = Identity::load(&dir.join("keys"), &name("operator")).expect("keys");
    Link::start(&config, &identity, Clock::wall()).expect("a link")
}

fn station(dir: &Path, camera: &str) -> u16 {
    // a port that is free now
    let port = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).expect("a port").port();
    let file = format!(
        "[station]\nname = \"left\"\nkeys = \"keys\"\nlisten = \"127.0.0.1:{port}\"\n\n\
         [[peer]]\nname = \"operator\"\n\n[camera]\n{camera}"
    );
    fs::write(dir.join("tetrad.toml"), file).expect("the file is written");
    port
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
    let port = station(dir.path(), camera);
    let child = command("camera --config tetrad.toml")
        .current_dir(dir.path())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let link = operator(dir.path(), port);
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

    let (code, out, err) = interrupted(child);
    assert_eq!(code, Some(0), "{out}\n{err}");
    assert!(err.contains("link: operator is connected"), "{err}");
    for words in
        ["tracked", "red             visible", "tracking        p50", "operator        connected 1 times"]
    {
        assert!(out.contains(words), "no {words:?} in {out}");
    }
}

#[test]
fn it_ends_after_its_time_with_nobody_listening() {
    let dir = tempfile::tempdir().expect("a directory");
    keys(dir.path());
    station(dir.path(), "source = \"sim:static-16px\"\nfps = 10\n");
    let said = tetrad(dir.path(), "camera --config tetrad.toml --seconds 1").done().stdout;
    assert!(said.contains("operator        connected 0 times"), "{said}");
}

#[test]
fn what_is_wrong_is_refused_with_the_mend() {
    let dir = tempfile::tempdir().expect("a directory");
    let run = || tetrad(dir.path(), "camera --config tetrad.toml --seconds 1");
    run().refused(2, &["cannot read tetrad.toml"]);
    station(dir.path(), "source = \"sim:static-16px\"\n");
    let unnamed = run();
    assert!(
        unnamed.code == Some(2) && unnamed.stderr.contains("keys/left.pem; `tetrad keys`"),
        "{unnamed:?}"
    );
    keys(dir.path());
    station(dir.path(), "source = \"sim:nothing\"\n");
    run().refused(2, &["sim:nothing", "no scene is called"]);
    fs::write(dir.path().join("colours.toml"), COLOURS).expect("written");
    station(dir.path(), "source = \"/dev/video-none\"\ncolours = \"colours.toml\"\n");
    run().refused(3, &["/dev/video-none", "no such camera"]);
    fs::write(dir.path().join("tetrad.toml"), "[camera]\nsource = \"sim:still\"\n").expect("written");
    run().refused(2, &["there is no [station]", "docs/stations.md"]);
    tetrad(dir.path(), "camera --config tetrad.toml --seconds 0").refused(2, &["--seconds 0"]);
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
