//! A node on a pseudo terminal.

use super::board::{AT, Board, HEIGHT, WIDTH};
use super::*;
use serialport::TTYPort;
use std::io::Write as _;
use std::time::Instant;
use tetrad_core::vision::colour::{Primary, Reference};
use tetrad_core::vision::frame::Rgb;
use tetrad_core::wire::{CommandPacket, Decoder, MAX_FRAME_LEN, NotTaught, Packet, encode};
use tetrad_fixtures::packets;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;

const UNTAUGHT: Told = Told { session: 1, taught: [None; BALLS], preview_every: 0 };

/// Made 3 ms after the exposure.
pub(super) fn packet(session: u32, sequence: u32, capture_us: u64) -> ObservationPacket {
    ObservationPacket { capture_us, width: 320, height: 240, ..packets::observation(session, sequence) }
}

pub(super) fn frame(packet: &ObservationPacket) -> Vec<u8> {
    let mut out = [0; MAX_FRAME_LEN];
    let length = encode(&(*packet).into(), &mut out).unwrap();
    out[..length].to_vec()
}

/// A pseudo terminal behind a name that stays, as a device has one.
struct Cable {
    dir: tempfile::TempDir,
    ends: Option<(TTYPort, TTYPort)>,
}

impl Cable {
    fn unplugged() -> Self {
        Self { dir: tempfile::tempdir().unwrap(), ends: None }
    }

    fn device(&self) -> PathBuf {
        self.dir.path().join("ttyACM0")
    }

    fn plug(&mut self) {
        let (master, slave) = TTYPort::pair().unwrap();
        std::os::unix::fs::symlink(slave.name().unwrap(), self.device()).unwrap();
        // the slave's end stays open: the terminal lives while no program listens
        self.ends = Some((master, slave));
    }

    fn unplug(&mut self) {
        std::fs::remove_file(self.device()).unwrap();
        self.ends = None;
    }

    /// The command of this number, or the first behind it; those before it may be told again.
    fn told(&mut self, number: u32) -> CommandPacket {
        let (mut decoder, began) = (Decoder::new(), Instant::now());
        while began.elapsed() < Duration::from_secs(60) {
            let mut byte = [0];
            // nothing there yet
            let count = self.ends.as_mut().unwrap().0.read(&mut byte).unwrap_or(0);
            if let Some(packet) = decoder.packets(&byte[..count]).next() {
                let Ok(Packet::Command(packet)) = packet else { panic!("{packet:?}") };
                if packet.sequence >= number {
                    return packet;
                }
            }
        }
        panic!("it is told nothing");
    }

    /// Answers a command.
    fn answer(&mut self, command: &CommandPacket, notice: Notice) {
        let sequence = command.sequence;
        let notice = NoticePacket { camera: 0, session: 5, sequence, answers: Some(sequence), notice };
        let mut out = [0; MAX_FRAME_LEN];
        let length = encode(&notice.into(), &mut out).unwrap();
        self.send(&out[..length]);
    }

    fn send(&mut self, bytes: &[u8]) {
        self.ends.as_mut().unwrap().0.write_all(bytes).unwrap();
    }
}

/// Sends until something comes, for what is sent before the port is open is lost.
fn until_heard(cable: &mut Cable, node: &SerialNode, session: u32) -> Received<ObservationPacket> {
    let began = Instant::now();
    let mut sequence = 0;
    while began.elapsed() < Duration::from_secs(60) {
        cable.send(&frame(&packet(session, sequence, 1_000 * u64::from(sequence))));
        sequence += 1;
        std::thread::sleep(Duration::from_millis(5));
        if let Some(came) = node.observation() {
            return came;
        }
    }
    panic!("nothing came");
}

fn until_told(node: &SerialNode, words: &str) -> String {
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(60) {
        if let Some(notice) = node.take_notices().into_iter().find(|notice| notice.contains(words)) {
            return notice;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("nothing was told of '{words}'");
}

#[test]
fn a_node_is_heard_through_garbage_restarts_and_pulled_cables() {
    let mut cable = Cable::unplugged();
    let clock = Clock::wall();
    let (rung, rings) = std::sync::mpsc::channel();
    let ring = move || rung.send(()).unwrap();
    let node = SerialNode::start(&cable.device(), 115_200, clock.clone(), UNTAUGHT, ring).unwrap();
    let missing = until_told(&node, "cannot be opened");
    assert!(missing.contains("ttyACM0") && missing.contains("plug the camera in"), "{missing}");

    cable.plug();
    until_told(&node, "is open");
    let first = cable.told(0);
    assert_eq!(first.command, Command::Preview { every: 0 }, "nothing came so far");
    cable.answer(&first, Notice::Done);
    assert_eq!(cable.told(1).command, Command::Start);
    let came = until_heard(&mut cable, &node, 7);
    assert_eq!((came.what.session, came.what.width), (7, 320));
    rings.recv_timeout(Duration::from_secs(60)).unwrap();
    let captured_us = came.captured_us.unwrap();
    assert!(captured_us <= came.received_us && came.received_us <= clock.now_us());

    cable.send(&[0x55; 700]);
    cable.send(&[0]);
    assert_eq!(until_heard(&mut cable, &node, 8).what.session, 8, "begun anew");
    let counts = node.counts();
    assert!(counts.damaged >= 1 && counts.taken >= 2, "{counts:?}");

    cable.unplug();
    let lost = until_told(&node, "went away");
    assert!(lost.contains("plug the camera in again"), "{lost}");
    assert_eq!(node.observation(), None);
    cable.plug();
    assert_eq!(until_heard(&mut cable, &node, 9).what.session, 9);
    // the thread ends although nothing comes
    drop(node);
}

/// Red, in core's words.
fn red() -> LearntBall {
    let (red, grey) = (Rgb::new(200, 36, 40), Rgb::new(70, 72, 74));
    let reference =
        Reference { primary: Primary::of(Ball::Red), reference: red, typical: red, background: grey };
    LearntBall { reference, diameter: 20.0, aspect: 1.0 }
}

#[test]
fn a_camera_with_colours_is_taught_before_it_is_started_and_again_when_it_is_plugged_in_again() {
    let mut cable = Cable::unplugged();
    cable.plug();
    let told = Told { session: 3, taught: [Some(red()), None, None, None], preview_every: 10 };
    let node = SerialNode::start(&cable.device(), 115_200, Clock::wall(), told, || ()).unwrap();
    let teach = Command::SetReference { ball: Ball::Red, learnt: red() };

    let first = cable.told(0);
    assert_eq!((first.session, first.command), (3, teach));
    // told again, under its number, as long as nobody answers
    assert_eq!(cable.told(0), first);
    cable.answer(&first, Notice::Done);
    let second = cable.told(1);
    assert_eq!((second.sequence, second.command), (1, Command::Preview { every: 10 }));
    cable.answer(&second, Notice::Done);
    let third = cable.told(2);
    assert_eq!((third.sequence, third.command), (2, Command::Start));
    cable.answer(&third, Notice::Done);

    cable.unplug();
    until_told(&node, "went away");
    cable.plug();
    let again = cable.told(3);
    assert_eq!(again.command, teach, "it was switched off, perhaps");
    cable.answer(&again, Notice::NotTaught { ball: Ball::Red, why: NotTaught::Colour });
    let refused = until_told(&node, "was not taught");
    assert!(refused.contains("the red ball"), "{refused}");
    let shown = cable.told(4);
    assert_eq!(shown.command, Command::Preview { every: 10 }, "the others may be known");
    cable.answer(&shown, Notice::Done);
    assert_eq!(cable.told(5).command, Command::Start);
}

/// Listens to a smart camera that is taught red and shows it every so many pictures.
fn listen(board: &Board, preview_every: u16) -> SerialNode {
    let told = Told { session: 3, taught: [Some(red()), None, None, None], preview_every };
    SerialNode::start(&board.device, 115_200, Clock::wall(), told, || ()).unwrap()
}

/// The next picture; the observations that come meanwhile are taken, as the operator does.
fn until_shown(node: &SerialNode) -> Received<Picture> {
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(60) {
        let _ = node.observation();
        if let Some(picture) = node.picture() {
            return picture;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("nothing was shown");
}

/// What a rim that is marked leaves around it in a JPEG; ball, grey and dark are farther apart.
const OF_JPEG: i32 = 27;

/// The ball before its grey in the middle, at the size that it has in the picture, and the dark around.
fn check(picture: &Picture) {
    assert_eq!((picture.width, picture.height, picture.camera), (WIDTH, HEIGHT, 0));
    let pixels = JpegDecoder::new(ZCursor::new(&picture.jpeg)).decode().unwrap();
    let at = |u: f32, v: f32| {
        let place = 3 * ((AT.v + v) as usize * usize::from(WIDTH) + (AT.u + u) as usize);
        [pixels[place], pixels[place + 1], pixels[place + 2]].map(i32::from)
    };
    let near = |[r, g, b]: [i32; 3], [red, green, blue]: [i32; 3]| {
        [r - red, g - green, b - blue].iter().all(|difference| difference.abs() < OF_JPEG)
    };
    for (u, v) in [(0.0, 0.0), (5.0, 0.0), (-4.0, 4.0)] {
        assert!(near(at(u, v), [200, 36, 40]), "({u}, {v}) of the ball: {:?}", at(u, v));
    }
    // a ball of about 20 px has a thumbnail of 32 x 36 of the picture's, or 48 x 54
    for (u, v) in [(-13.0, 0.0), (13.0, 13.0), (0.0, -15.0), (0.0, 15.0)] {
        assert!(near(at(u, v), [70, 72, 74]), "({u}, {v}) beside it: {:?}", at(u, v));
    }
    for (u, v) in [(-32.0, 0.0), (32.0, 0.0), (0.0, -36.0), (0.0, 36.0), (-70.0, 50.0)] {
        assert!(near(at(u, v), [16, 16, 16]), "({u}, {v}) around: {:?}", at(u, v));
    }
}

#[test]
fn the_picture_of_a_ball_is_that_of_the_cameras_pixels_with_their_time() {
    let board = Board::start(0, |_| 5);
    let node = listen(&board, 4);
    let mut before_us = 0;
    for _ in 0..3 {
        let picture = until_shown(&node);
        check(&picture.what);
        let captured_us = picture.captured_us.unwrap();
        assert!(captured_us > before_us && captured_us <= picture.received_us, "{picture:?}");
        before_us = captured_us;
    }
    assert_eq!(node.counts().other, 0, "strips are what was asked for");
}

#[test]
fn a_line_that_loses_frames_costs_pictures_and_spoils_none() {
    // six frames bring a thumbnail: now and then none of them is lost that it needs
    let board = Board::start(7, |_| 5);
    let node = listen(&board, 3);
    for _ in 0..3 {
        check(&until_shown(&node).what);
    }
    assert!(node.counts().damaged > 3, "{:?}", node.counts());
}

#[test]
fn nothing_is_shown_where_nobody_asked() {
    let board = Board::start(0, |_| 5);
    let node = listen(&board, 0);
    let began = Instant::now();
    while node.counts().taken < 60 {
        assert!(began.elapsed() < Duration::from_secs(60), "{:?}", node.counts());
        assert_eq!(node.picture(), None);
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(node.counts().damaged, 0);
}
