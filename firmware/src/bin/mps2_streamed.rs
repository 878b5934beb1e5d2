//! The smart camera on the MPS2 boards, shown its pictures over the serial line: what `stm32h743-streamed` is on a real
//! board. Serial 0 is the line. It never ends by itself: QEMU is ended from outside. Exit codes: 101 a panic, 102 a
//! fault; where is said on standard error.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use static_cell::{ConstStaticCell, StaticCell};
use tetrad_core::node::Node;
use tetrad_firmware::board::mps2::{self, executor, uart};
use tetrad_firmware::handover::{BUFFERS, Buffers, Inputs, Packets, PictureBuffer};
use tetrad_firmware::{send, streamed, track};

static BUFFERS_FREE: Buffers = Buffers::new();
static INPUTS: Inputs = Inputs::new();
static PACKETS: Packets = Packets::new();

#[embassy_executor::task]
async fn receive_task() {
    streamed::receive(uart::Receiver, &BUFFERS_FREE, &INPUTS).await;
}

#[embassy_executor::task]
async fn track_task(node: &'static mut Node) {
    // the pictures are recorded, so no clock is theirs; and their sender may take any time, so no watchdog waits
    while let Some(begin) = track::track(node, &INPUTS, &BUFFERS_FREE, &PACKETS, || None, || {}).await {
        *node = Node::new(&streamed::config(begin)).expect("the settings are core's own");
    }
}

#[embassy_executor::task]
async fn send_task() {
    let Ok(()) = send::send(uart::Sender, &PACKETS).await;
}

// What is made here is moved to where it stays: the stack for that is given back before any task runs.
#[inline(never)]
fn spawn(spawner: Spawner) {
    static PICTURES: ConstStaticCell<[PictureBuffer; BUFFERS]> =
        ConstStaticCell::new([const { PictureBuffer::new() }; BUFFERS]);
    static NODE: StaticCell<Node> = StaticCell::new();
    let config = streamed::config(streamed::AT_FIRST);
    let node = NODE.init(Node::new(&config).expect("the settings are core's own"));
    for buffer in PICTURES.take() {
        assert!(BUFFERS_FREE.try_send(buffer).is_ok(), "there is room for each");
    }
    let once = "each task is started once";
    spawner.spawn(receive_task().expect(once));
    spawner.spawn(track_task(node).expect(once));
    spawner.spawn(send_task().expect(once));
}

#[cortex_m_rt::entry]
fn main() -> ! {
    mps2::start();
    executor::run(spawn)
}
