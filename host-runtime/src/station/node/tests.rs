//! A node on a pseudo terminal.

use super::*;
use serialport::TTYPort;
use std::io::Write as _;
use std::time::Instant;
use tetrad_core::vision::colour::{Primary, Reference};
use tetrad_core::vision::frame::Rgb;
use tetrad_core::wire::{CommandPacket, Decoder, MAX_FRAME_LEN, NotTaught, Packet, encode};
use tetrad_fixtures::packets;

const UNTAUGHT: Told = Told { session: 1, taught: [None; BALLS] };

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
    assert_eq!(cable.told(0).command, Command::Start, "nothing came so far");
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
    let told = Told { session: 3, taught: [Some(red()), None, None, None] };
    let node = SerialNode::start(&cable.device(), 115_200, Clock::wall(), told, || ()).unwrap();
    let teach = Command::SetReference { ball: Ball::Red, learnt: red() };

    let first = cable.told(0);
    assert_eq!((first.session, first.command), (3, teach));
    // told again, under its number, as long as nobody answers
    assert_eq!(cable.told(0), first);
    cable.answer(&first, Notice::Done);
    let second = cable.told(1);
    assert_eq!((second.sequence, second.command), (1, Command::Start));
    cable.answer(&second, Notice::Done);

    cable.unplug();
    until_told(&node, "went away");
    cable.plug();
    let third = cable.told(2);
    assert_eq!(third.command, teach, "it was switched off, perhaps");
    cable.answer(&third, Notice::NotTaught { ball: Ball::Red, why: NotTaught::Colour });
    let refused = until_told(&node, "was not taught");
    assert!(refused.contains("the red ball"), "{refused}");
    assert_eq!(cable.told(3).command, Command::Start, "the others may be known");
}
