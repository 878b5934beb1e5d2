//! The smart camera on the MPS2 boards.
//!
//! It plays the tape `tetrad.tape` of the folder that QEMU runs in, writes packets to the serial line and
//! ends QEMU behind the last. A live tape waits for what the line asks for, and QEMU is ended from outside.
//! Serial 0 is the line. Exit codes: 0 played, 2 no tape, 101 a panic, 102 a
//! fault, 103 no picture that could be looked at for too long; where is said on standard error.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use semihosting::{eprintln, process};
use static_cell::{ConstStaticCell, StaticCell};
use tetrad_core::config::LearnConfig;
use tetrad_core::node::{Node, NodeConfig};
use tetrad_firmware::board::mps2::tape::{Asked, Player, Tape};
use tetrad_firmware::board::mps2::watchdog::Watchdog;
use tetrad_firmware::board::mps2::{self, executor, uart};
use tetrad_firmware::handover::{BUFFERS, Buffers, Inputs, Packets, PictureBuffer};
use tetrad_firmware::{capture, receive, send, track};

/// That of everything that is played from a tape: the same tape gives the same bytes.
const SESSION: u32 = 1;

const NO_TAPE: i32 = 2;

static BUFFERS_FREE: Buffers = Buffers::new();
static INPUTS: Inputs = Inputs::new();
static PACKETS: Packets = Packets::new();
static ASKED: Asked = Asked::new();

#[embassy_executor::task]
async fn capture_task(player: Player) {
    capture::capture(player, &BUFFERS_FREE, &INPUTS).await;
}

#[embassy_executor::task]
async fn receive_task() {
    receive::receive_telling(uart::Receiver, &INPUTS, |command| ASKED.hear(command)).await;
}

#[embassy_executor::task]
async fn track_task(node: &'static mut Node, mut watchdog: Watchdog) {
    // the pictures are recorded: no clock is theirs
    track::track(node, &INPUTS, &BUFFERS_FREE, &PACKETS, || None, || watchdog.feed()).await;
}

#[embassy_executor::task]
async fn send_task() {
    let Ok(()) = send::send(uart::Sender, &PACKETS).await;
    // a figure, as mps2_figures prints them
    eprintln!("camera {} stack", mps2::stack_used());
    process::exit(0)
}

// What is made here is moved to where it stays: the stack for that is given back before any task runs.
#[inline(never)]
fn spawn(spawner: Spawner, tape: Tape) {
    static PICTURES: ConstStaticCell<[PictureBuffer; BUFFERS]> =
        ConstStaticCell::new([const { PictureBuffer::new() }; BUFFERS]);
    static NODE: StaticCell<Node> = StaticCell::new();
    let head = tape.head();
    let (camera, tracker, learn) = (head.camera, head.tracker, LearnConfig::default());
    // whoever is at a live line may take any time
    let watchdog = if head.live { Watchdog::idle() } else { Watchdog::start() };
    let config = NodeConfig { camera, session: SESSION, tracker, learn, started: false };
    let node = NODE.init(Node::new(&config).expect("the settings are core's own"));
    for buffer in PICTURES.take() {
        assert!(BUFFERS_FREE.try_send(buffer).is_ok(), "there is room for each");
    }
    let once = "each task is started once";
    spawner.spawn(capture_task(tape.play(&INPUTS, &ASKED)).expect(once));
    spawner.spawn(receive_task().expect(once));
    spawner.spawn(track_task(node, watchdog).expect(once));
    spawner.spawn(send_task().expect(once));
}

#[cortex_m_rt::entry]
fn main() -> ! {
    mps2::start();
    let Some(tape) = Tape::open() else {
        eprintln!("no tape: write one to tetrad.tape in the folder that QEMU runs in");
        process::exit(NO_TAPE)
    };
    executor::run(|spawner| spawn(spawner, tape))
}
