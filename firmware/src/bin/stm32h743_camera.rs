//! The smart camera on the OpenMV Cam H7. It has not run there: src/board/stm32h743/README.md.
//!
//! Packets go to the serial line and to the CAN bus, commands come from the serial line and the button.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::gpio::Input;
use embassy_stm32::usart::{BufferedUartRx, BufferedUartTx};
use embassy_time::Instant;
use static_cell::StaticCell;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::node::{Node, NodeConfig};
use tetrad_firmware::board::stm32h743::bus::Bus;
use tetrad_firmware::board::stm32h743::camera::Camera;
use tetrad_firmware::board::stm32h743::light::Light;
use tetrad_firmware::board::stm32h743::watchdog::{Watchdog, is_well};
use tetrad_firmware::board::stm32h743::{self, pictures};
use tetrad_firmware::handover::{Buffers, Inputs, Packets};
use tetrad_firmware::ov7725::{HEIGHT, WIDTH};
use tetrad_firmware::{capture, receive, send, share, teach, track};

/// The middle of a picture, px: where a ball is held to be learnt by the button.
const MIDDLE: ImagePoint = ImagePoint { u: (WIDTH - 1) as f32 / 2.0, v: (HEIGHT - 1) as f32 / 2.0 };

static BUFFERS_FREE: Buffers = Buffers::new();
static INPUTS: Inputs = Inputs::new();
static PACKETS: Packets = Packets::new();
static TO_LINE: Packets = Packets::new();
static TO_BUS: Packets = Packets::new();

#[embassy_executor::task]
async fn capture_task(camera: Camera) {
    capture::capture(camera, &BUFFERS_FREE, &INPUTS).await;
}

#[embassy_executor::task]
async fn receive_task(line: BufferedUartRx<'static>) {
    receive::receive(line, &INPUTS).await;
}

#[embassy_executor::task]
async fn teach_task(button: Input<'static>, mut light: Light) {
    teach::teach(button, |ball| light.show(ball, is_well()), &INPUTS, MIDDLE).await;
}

#[embassy_executor::task]
async fn track_task(node: &'static mut Node, mut watchdog: Watchdog) {
    let now_us = || Some(Instant::now().as_micros());
    track::track(node, &INPUTS, &BUFFERS_FREE, &PACKETS, now_us, || watchdog.feed()).await;
}

#[embassy_executor::task]
async fn share_task() {
    share::share(&PACKETS, &TO_LINE, &TO_BUS).await;
}

#[embassy_executor::task]
async fn line_task(line: BufferedUartTx<'static>) {
    // an error of the line ends in silence, which its reader sees
    let _ = send::send(line, &TO_LINE).await;
}

#[embassy_executor::task]
async fn bus_task(bus: Bus) {
    let Ok(()) = send::send(bus, &TO_BUS).await;
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    static NODE: StaticCell<Node> = StaticCell::new();
    let mut board = stm32h743::start();
    let watchdog = board.watchdog.wake();
    for buffer in pictures::take().expect("they are taken here alone") {
        assert!(BUFFERS_FREE.try_send(buffer).is_ok(), "there is room for each");
    }
    board.camera.switch_caches_on();
    let config = NodeConfig {
        camera: board.number,
        session: board.session,
        tracker: TrackerConfig::default(),
        learn: LearnConfig::default(),
        started: false,
    };
    let node = NODE.init(Node::new(&config).expect("the settings are core's own"));
    let once = "each task is started once";
    spawner.spawn(capture_task(board.camera).expect(once));
    spawner.spawn(receive_task(board.told).expect(once));
    spawner.spawn(teach_task(board.button, board.light).expect(once));
    spawner.spawn(track_task(node, watchdog).expect(once));
    spawner.spawn(share_task().expect(once));
    spawner.spawn(line_task(board.said).expect(once));
    spawner.spawn(bus_task(board.bus).expect(once));
}
