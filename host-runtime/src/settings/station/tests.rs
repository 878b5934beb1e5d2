use super::*;
use crate::link::authority::{make_authority, make_station};
use crate::source::View;
use std::fs;

/// An example of docs/stations.md.
fn documented(role: &str) -> String {
    let document = include_str!("../../../../docs/stations.md");
    let (_, example) = document.split_once(&format!("```toml {role}\n")).unwrap();
    example.split_once("```").unwrap().0.to_owned()
}

fn load(text: &str) -> Result<StationSettings, String> {
    let dir = tempfile::tempdir().unwrap();
    load_in(dir.path(), text)
}

fn load_in(dir: &Path, text: &str) -> Result<StationSettings, String> {
    let file = dir.join("tetrad.toml");
    fs::write(&file, text).unwrap();
    StationSettings::load(&file).map_err(|error| {
        let message = error.to_string();
        message.strip_prefix(&format!("{}: ", file.display())).expect("the file is named").to_owned()
    })
}

#[track_caller]
fn refused(text: &str, message: &str) {
    let error = load(text).unwrap_err();
    assert!(error.contains(message), "{error}");
}

#[test]
fn the_documented_files_are_taken() {
    let operator = load(&documented("operator")).unwrap();
    let network = operator.network.unwrap();
    assert_eq!((network.name.as_str(), network.link.peers.len()), ("operator", 3));
    assert_eq!(network.link.listen, None);
    assert!(network.keys.ends_with("keys") && network.keys.is_absolute());
    let hand = operator.operator.unwrap();
    assert_eq!((hand.arm_m, hand.cameras.len()), (0.08, 2));
    assert_eq!(hand.slave, SlavePlace::Station("slave".parse().unwrap()));
    assert_eq!(hand.cameras[1].focal_px, Some(800.0));
    assert_eq!(hand.filter, tetrad_core::config::FilterConfig::default());

    let slave = load(&documented("slave")).unwrap();
    assert_eq!(slave.network.unwrap().link.picture_bytes_per_s, 2_500_000);
    assert_eq!(slave.slave.operator, Some("operator".parse().unwrap()));
    let views: Vec<_> = slave.slave.cameras.iter().map(|camera| camera.options.view).collect();
    assert_eq!(views, [View::Left, View::Right]);

    // its colours are beside it
    let dir = tempfile::tempdir().unwrap();
    let text = documented("camera");
    let missing = load_in(dir.path(), &text).unwrap_err();
    assert!(
        missing.starts_with("[camera] colours: cannot read") && missing.contains("left-colours.toml"),
        "{missing}"
    );
    let of_a_scene = text.replace("/dev/video0", "sim:demo").replace("colours = ", "# colours = ");
    let camera = load_in(dir.path(), &of_a_scene).unwrap().camera.unwrap();
    assert_eq!(camera.camera.start, CameraStart::OfScene);
    assert_eq!((camera.camera.options.fps, camera.preview_fps), (Some(60.0), 5.0));
}

#[test]
fn everything_in_one_file() {
    let settings = load(
        "[operator]\narm_mm = 80\nslave = \"here\"\n\
         [[operator.camera]]\nsource = \"sim:demo\"\n\
         [[operator.camera]]\nsource = \"sim:demo\"\nview = \"right\"\n\
         [[operator.camera]]\nsource = \"node:serial:/dev/ttyACM0?baud=115200\"\n\
         [slave]\nport = \"sim:\"\n",
    )
    .unwrap();
    let operator = settings.operator.unwrap();
    assert_eq!((settings.network, operator.slave), (None, SlavePlace::Here));
    let device = "/dev/ttyACM0".into();
    let serial = HandCamera::Serial { device, baud: 115_200, colours: None, preview_every: 10 };
    assert_eq!(operator.cameras[2].place, serial);
}

#[test]
fn a_smart_camera_may_have_colours_and_a_preview_and_nothing_else_of_a_camera_here() {
    let dir = tempfile::tempdir().unwrap();
    let colours =
        "reference = [200, 30, 30]\ntypical = [200, 30, 30]\nbackground = [90, 90, 90]\ndiameter_px = 15\n";
    let colours: String =
        ["red", "green", "blue", "yellow"].map(|ball| format!("[{ball}]\n{colours}")).concat();
    fs::write(dir.path().join("smart.toml"), colours).unwrap();
    let text = |more: &str| {
        format!(
            "[operator]\narm_mm = 80\nslave = \"here\"\n\
             [[operator.camera]]\nsource = \"node:serial:/dev/ttyACM0\"\n{more}\n[slave]\nport = \"sim:\"\n"
        )
    };
    let operator = load_in(dir.path(), &text("colours = \"smart.toml\"")).unwrap().operator.unwrap();
    let HandCamera::Serial { colours: Some(taught), .. } = &operator.cameras[0].place else {
        panic!("{operator:?}")
    };
    assert!(taught.learnt_balls().iter().flatten().all(|ball| ball.diameter == 15.0), "{taught:?}");
    assert_eq!(operator.cameras[0].colours, Some(dir.path().join("smart.toml")));

    let refused = |more: &str| load_in(dir.path(), &text(more)).unwrap_err();
    let missing = refused("colours = \"none.toml\"");
    assert!(missing.starts_with("[[operator.camera]] 1 colours: cannot read"), "{missing}");
    for (given, expected) in [("", 10), ("preview_every = 0", 0), ("preview_every = 65535", u16::MAX)] {
        let operator = load_in(dir.path(), &text(given)).unwrap().operator.unwrap();
        let place = &operator.cameras[0].place;
        assert!(
            matches!(place, HandCamera::Serial { preview_every, .. } if *preview_every == expected),
            "{place:?}"
        );
    }
    for wrong in ["-1", "65536", "0.5"] {
        let told = refused(&format!("preview_every = {wrong}"));
        assert!(told.contains("preview_every"), "{told}");
    }
    for (source, mend) in [("sim:demo", "a smart camera"), ("node:left", "has preview_fps")] {
        let other = text("preview_every = 10").replace("node:serial:/dev/ttyACM0", source);
        let told = load_in(dir.path(), &other).unwrap_err();
        assert!(told.starts_with("[[operator.camera]] 1 preview_every: ") && told.contains(mend), "{told}");
    }
    let paper = refused("colours = \"smart.toml\"\nmode = \"paper\"");
    assert!(paper.starts_with("[[operator.camera]] 1 mode: node:serial:/dev/ttyACM0 knows"), "{paper}");
    let twice =
        "[[operator.camera]]\nsource = \"node:serial:/dev/ttyACM0?baud=9600\"\ncolours = \"smart.toml\"";
    let twice = refused(twice);
    assert!(twice.contains("is given twice"), "{twice}");
}

#[test]
fn what_cannot_be_meant_is_refused_with_its_key() {
    let operator = documented("operator");
    let slave = documented("slave");
    refused(&operator.replace("arm_mm", "arms_mm"), "unknown field `arms_mm`");
    refused(&operator.replace("arm_mm = 80", "arm_mm = 1"), "[operator] arm_mm: a number from 5 to 2000 mm");
    refused(&operator.replace("arm_mm = 80", "arm_mm = nan"), "[operator] arm_mm");
    refused(
        &operator.replace("name = \"right\"", "name = \"left\""),
        "[[peer]] name: two stations are called `left`",
    );
    refused(
        &operator.replace("name = \"right\"", "name = \"operator\""),
        "two stations are called `operator`",
    );
    refused(
        &operator.replace("10.0.0.12:7420", "10.0.0.12"),
        "[[peer]] 2 address: '10.0.0.12' cannot be dialled",
    );
    refused(&operator.replace("name = \"right\"", "name = \"Right\""), "[[peer]] 2 name: `Right` is no name");
    refused(
        &operator.replace("slave = \"slave\"", "slave = \"arm\""),
        "[operator] slave: no [[peer]] is called `arm`",
    );
    refused(
        &operator.replace("source = \"node:right\"", "source = \"node:left\""),
        "[[operator.camera]] 2 source: node:left is given twice",
    );
    refused(
        &operator.replace("focal_px = 800", "colours = \"right.toml\""),
        "[[operator.camera]] 2 colours: node:right knows that itself",
    );
    refused(&operator.replace("lead_ms = 0", "lead_ms = -1"), "[operator.filter] lead_ms: a number from 0");
    refused(
        &operator.replace("[station]\nname = \"operator\"\nkeys = \"keys\"\n", ""),
        "[[peer]]: peers need",
    );
    refused(&slave.replace("listen = \"0.0.0.0:7420\"\n", ""), "[[peer]] address: `operator` has no address");
    refused(
        &slave.replace("0.0.0.0:7420", "arm.local:7420"),
        "[station] listen: 'arm.local:7420' is no address",
    );
    refused(
        &slave.replace("operator = \"operator\"", "operator = \"boss\""),
        "[slave] operator: no [[peer]]",
    );
    refused(
        &slave.replace("quality = 80", "quality = 0"),
        "[[slave.camera]] 1 quality: a number from 10 to 100",
    );
    refused(
        &operator.replace("10.0.0.12:7420", "10.0.0.11:7420"),
        "[[peer]] 2 address: left is at 10.0.0.11:7420 too",
    );
    refused(
        &operator.replace("10.0.0.12:7420", "0.0.0.0:7420"),
        "[[peer]] 2 address: '0.0.0.0:7420' is an address to listen on",
    );
    let own = slave.replace("0.0.0.0:7420", "10.0.0.3:7420");
    refused(
        &own.replace("name = \"operator\"\n", "name = \"operator\"\naddress = \"10.0.0.3:7420\"\n"),
        "[[peer]] 1 address: 10.0.0.3:7420 is where this station listens itself",
    );
    let three = format!("{slave}[[slave.camera]]\nsource = \"sim:arm\"\n");
    refused(&three, "[[slave.camera]]: at most 2 cameras");
    refused(&slave.replace("\"sim:\"", "\"simm:\""), "[slave] port: simm:");
}

#[test]
fn a_console_is_the_operators() {
    let console = "[console]\nlisten = \"127.0.0.1:8080\"\n";
    let operator = load(&format!("{}{console}", documented("operator"))).unwrap();
    assert_eq!(operator.console.unwrap().listen.port(), 8080);
    assert_eq!(load(&documented("operator")).unwrap().console, None);
    refused(&format!("{}{console}", documented("slave")), "[console]: it is the operator's");
    refused(
        &format!("{}{}", documented("operator"), console.replace("127.0.0.1", "0.0.0.0")),
        "[console] token_file: 0.0.0.0:8080 can be reached from other computers",
    );
}

/// What no camera can be is said before one is opened.
#[test]
fn a_source_that_cannot_be_meant_is_refused_with_its_key() {
    let camera = documented("camera").replace("colours = ", "# colours = ").replace("fps = 60", "");
    let seen = |source: &str| camera.replace("/dev/video0", source);
    refused(&seen("sim:demp"), "[camera] source: sim:demp: no scene is called 'demp': there are de");
    refused(
        &seen("sim:demo?format=grey"),
        "[camera] source: sim:demo?format=grey: 'grey' is no pixel format",
    );
    refused(&seen("http://10.0.0.9/stream"), "no such file or folder: SRC is /dev/videoN");
    refused(&seen("node:left"), "[camera] source: node:left is another station");
    let slave = documented("slave");
    refused(
        &slave.replacen("source = \"sim:arm\"", "source = \"sim:harm\"", 1),
        "[[slave.camera]] 1 source: sim:harm: no scene is called 'harm'",
    );
    let hand = documented("operator").replace("source = \"node:right\"", "source = \"/no/film.y4m\"");
    refused(&hand, "[[operator.camera]] 2 source: /no/film.y4m: no such file or folder");
    // a recording lies beside the file that names it
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("clip")).unwrap();
    let text = format!("{}\ncolours = \"no.toml\"\n", seen("clip").replace("# colours", "# "));
    let error = load_in(dir.path(), &text).unwrap_err();
    assert!(error.starts_with("[camera] colours: cannot read"), "the clip was found: {error}");
}

#[test]
fn stations_can_be_announced_and_looked_up() {
    let operator = documented("operator");
    let sought = operator.replace("10.0.0.11:7420", "mdns").replace("10.0.0.12:7420", "mdns");
    let network = load(&sought).unwrap().network.unwrap();
    let names: Vec<_> = network.link.sought().iter().map(ToString::to_string).collect();
    assert_eq!((names, network.announce), (vec!["left".to_owned(), "right".to_owned()], false));
    refused(&operator.replace("10.0.0.12:7420", "dns"), "or \"mdns\"");
    let announced = |text: &str| text.replace("keys = \"keys\"", "keys = \"keys\"\nannounce = true");
    refused(&announced(&operator), "[station] announce: a station that only dials has nothing to announce");
    let slave = announced(&documented("slave"));
    assert!(load(&slave).unwrap().network.unwrap().announce);
    refused(
        &slave.replace("0.0.0.0", "127.0.0.1"),
        "[station] announce: 127.0.0.1:7420 is for this computer",
    );
}

#[test]
fn tables_that_contradict_each_other_are_refused() {
    let lonely = "[camera]\nsource = \"sim:demo\"\n";
    refused(lonely, "[camera]: there is no [station], and a camera station needs it");
    let both = documented("operator").replace("slave = \"slave\"", "slave = \"here\"");
    let both = format!("{both}[slave]\noperator = \"slave\"\n");
    refused(&both, "[slave] operator: the arm is moved from here");
}

#[test]
fn limits_that_exclude_the_start_are_refused() {
    let slave = documented("slave");
    let low = format!("{slave}[workspace]\nmin_mm = [-900, -900, 0]\nmax_mm = [900, 900, 100]\n");
    refused(&low, "[workspace] min_mm, max_mm: the arm starts with its tool at");
    let narrow = format!("{slave}[arm]\nmin_deg = [20, -45, -225, -110, -100, -266]\n");
    refused(&narrow, "[arm] min_deg, max_deg: joint 1 of the simulated arm starts at 0 degrees");
    let slow = format!("{slave}[governor]\ncycle_ms = 50\n");
    refused(
        &slow,
        "[teleop] command_timeout_ms: a command that is old after 100 ms does not last 3 cycles of 50 ms",
    );
    let hasty = format!("{slave}[teleop]\ncommand_timeout_ms = 5\n");
    refused(&hasty, "[teleop] command_timeout_ms");
    let beyond = slave.replace("\"sim:\"", "\"sim:?start_deg=0,45,60,0,0,0\"");
    refused(&beyond, "start_deg: joint 3 can be from -225.0 to 45.0 degrees");
}

#[test]
fn keys_have_to_be_of_one_make() {
    let dir = tempfile::tempdir().unwrap();
    let settings = load_in(dir.path(), &documented("slave")).unwrap();
    let network = settings.network.unwrap();
    let missing = network.identity().unwrap_err().to_string();
    let command = format!("`tetrad keys --out {} station slave`", network.keys.display());
    for words in ["tetrad.toml: [station] keys: ", "slave.pem", "authority.pem", &command] {
        assert!(missing.contains(words), "no {words:?} in {missing}");
    }
    fs::create_dir(&network.keys).unwrap();
    make_authority(&network.keys).unwrap();
    make_station(&network.keys, &network.name).unwrap();
    assert_eq!(network.identity().unwrap().name(), &network.name);
}
