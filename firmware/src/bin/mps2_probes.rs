//! The hand's pose and the arm's inverse on the MPS2 boards, to be compared with a desktop.
//!
//! It plays the tape `tetrad.tape` of the folder that QEMU runs in and writes what `probes` answers to
//! `tetrad.answers` there. Exit codes as those of `mps2-camera`.
#![no_std]
#![no_main]

use core::ffi::CStr;
use semihosting::fs::File;
use semihosting::io::Write as _;
use semihosting::{eprintln, process};
use static_cell::{ConstStaticCell, StaticCell};
use tetrad_firmware::board::mps2;
use tetrad_firmware::board::mps2::tape::{Record, Tape};
use tetrad_firmware::handover::PictureBuffer;
use tetrad_firmware::probes::{Arm, Hand};

const ANSWERS: &CStr = c"tetrad.answers";

const NO_TAPE: i32 = 2;

#[cortex_m_rt::entry]
fn main() -> ! {
    static BUFFER: ConstStaticCell<PictureBuffer> = ConstStaticCell::new(PictureBuffer::new());
    static HAND: StaticCell<Hand> = StaticCell::new();
    mps2::start();
    let Some(mut tape) = Tape::open() else {
        eprintln!("no tape: write one to tetrad.tape in the folder that QEMU runs in");
        process::exit(NO_TAPE)
    };
    let mut answers = File::create(ANSWERS).expect("a file can be written beside the tape");
    let mut answer = |bytes: &[u8]| answers.write_all(bytes).expect("the file takes more");
    let (buffer, arm) = (BUFFER.take(), Arm::new());
    let hand = HAND.init(Hand::new(tape.head().hand));
    while let Ok(record) = tape.next(buffer) {
        match record {
            Record::Line(length) => hand.take(buffer.0.get(..length).unwrap_or_default(), &mut answer),
            Record::Case(length) => arm.answer(buffer.0.get(..length).unwrap_or_default(), &mut answer),
            Record::Picture(_) | Record::Pause(_) | Record::TooLong | Record::Unknown => {}
        }
    }
    process::exit(0)
}
