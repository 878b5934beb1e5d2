//! The slave on the MPS2 boards.
//!
//! It plays the tape `tetrad.tape` of the folder that QEMU runs in (`board/mps2/slave_tape.rs` has its
//! format), writes the arm's state to serial 0 and the frames for the drives to serial 1, and ends QEMU behind
//! the last. Exit codes: 0 played, 2 no tape, 101 a panic, 102 a fault; where is said on standard error.
//!
//! What a cycle costs is said on standard output, right where an instruction counts as 1024 ns
//! (`board/mps2/cost.rs`).
#![no_std]
#![no_main]

use core::mem::size_of;
use embassy_executor::Spawner;
use semihosting::{eprintln, println, process};
use static_cell::StaticCell;
use tetrad_core::arm::canopen::Frames;
use tetrad_core::arm::wired::WiredSlave;
use tetrad_core::config::{CanopenConfig, SlaveConfig};
use tetrad_core::wire::ArmStatePacket;
use tetrad_firmware::board::mps2::cost::instructions;
use tetrad_firmware::board::mps2::slave_tape::SlaveTape;
use tetrad_firmware::board::mps2::{self, bus, executor, uart};
use tetrad_firmware::can::Slcan;
use tetrad_firmware::handover::Packets;
use tetrad_firmware::send;
use tetrad_firmware::slave::{SlaveInputs, drive};

/// That of everything that is played from a tape: the same tape gives the same bytes.
const SESSION: u32 = 1;

const NO_TAPE: i32 = 2;

static INPUTS: SlaveInputs = SlaveInputs::new();
static PACKETS: Packets = Packets::new();

/// What cycles cost so far, instructions.
#[derive(Default)]
struct Costs {
    cycles: u64,
    sum: u64,
    most: u32,
}

impl Costs {
    fn cycle(&mut self, slave: &mut WiredSlave, now_us: u64, frames: &mut Frames) -> Option<ArmStatePacket> {
        let mut state = None;
        let cost = instructions(|| state = slave.cycle(now_us, frames));
        self.cycles += 1;
        self.sum += u64::from(cost);
        self.most = self.most.max(cost);
        state
    }
}

#[embassy_executor::task]
async fn play_task(tape: SlaveTape) {
    tape.play(&INPUTS).await;
}

#[embassy_executor::task]
async fn drive_task(slave: &'static mut WiredSlave) {
    // paints the stack anew: what it took to make the slave has been given back
    mps2::stack_of(|| ());
    let mut costs = Costs::default();
    let can = Slcan(bus::Sender::start());
    drive(slave, &INPUTS, &PACKETS, can, |slave, now_us, frames| costs.cycle(slave, now_us, frames)).await;
    println!("slave-cycle {} instructions", costs.sum / costs.cycles.max(1));
    println!("slave-cycle-most {} instructions", costs.most);
}

#[embassy_executor::task]
async fn send_task() {
    let Ok(()) = send::send(uart::Sender, &PACKETS).await;
    println!("slave {} stack", mps2::stack_used());
    println!("slave {} bytes", size_of::<WiredSlave>());
    process::exit(0)
}

// What is made here is moved to where it stays: the stack for that is given back before any task runs.
#[inline(never)]
fn spawn(spawner: Spawner, tape: SlaveTape) {
    static SLAVE: StaticCell<WiredSlave> = StaticCell::new();
    let slave = WiredSlave::new(&SlaveConfig::default(), &CanopenConfig::default(), SESSION);
    let slave = SLAVE.init(slave.expect("the settings are core's own"));
    let once = "each task is started once";
    spawner.spawn(play_task(tape).expect(once));
    spawner.spawn(drive_task(slave).expect(once));
    spawner.spawn(send_task().expect(once));
}

#[cortex_m_rt::entry]
fn main() -> ! {
    mps2::start();
    let Some(tape) = SlaveTape::open() else {
        eprintln!("no tape: write one to tetrad.tape in the folder that QEMU runs in");
        process::exit(NO_TAPE)
    };
    executor::run(|spawner| spawn(spawner, tape))
}
