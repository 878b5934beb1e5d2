//! The smart camera on the OpenMV Cam H7, shown its pictures over the serial line instead of by its sensor: `hil`
//! compares what it sees with what a desktop sees. It has not run there: src/board/stm32h743/README.md.
//!
//! No watchdog runs: whoever shows pictures may take any time between two.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::usart::{BufferedUartRx, BufferedUartTx};
use static_cell::StaticCell;
use tetrad_core::node::Node;
use tetrad_firmware::board::stm32h743::{self, pictures};
use tetrad_firmware::handover::{Buffers, Inputs, Packets};
use tetrad_firmware::{send, streamed, track};

static BUFFERS_FREE: Buffers = Buffers::new();
static INPUTS: Inputs = Inputs::new();
static PACKETS: Packets = Packets::new();

#[embassy_executor::task]
async fn receive_task(line: BufferedUartRx<'static>) {
    streamed::receive(line, &BUFFERS_FREE, &INPUTS).await;
}

#[embassy_executor::task]
async fn track_task(node: &'static mut Node) {
    // the pictures are recorded: no clock is theirs
    while let Some(begin) = track::track(node, &INPUTS, &BUFFERS_FREE, &PACKETS, || None, || {}).await {
        *node = Node::new(&streamed::config(begin)).expect("the settings are core's own");
    }
}

#[embassy_executor::task]
async fn send_task(line: BufferedUartTx<'static>) {
    // an error of the line ends in silence, which its reader sees
    let _ = send::send(line, &PACKETS).await;
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    static NODE: StaticCell<Node> = StaticCell::new();
    let mut board = stm32h743::start();
    // the processor writes them here and no DMA does, so that what the caches hold of them is what they are
    for buffer in pictures::take().expect("they are taken here alone") {
        assert!(BUFFERS_FREE.try_send(buffer).is_ok(), "there is room for each");
    }
    board.camera.switch_caches_on();
    let config = streamed::config(streamed::AT_FIRST);
    let node = NODE.init(Node::new(&config).expect("the settings are core's own"));
    let once = "each task is started once";
    spawner.spawn(receive_task(board.told).expect(once));
    spawner.spawn(track_task(node).expect(once));
    spawner.spawn(send_task(board.said).expect(once));
}
