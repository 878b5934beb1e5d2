use super::*;
use core::cell::RefCell;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_hal::i2c::{ErrorKind, ErrorType, Operation};
use std::vec::Vec;

/// A sensor on its bus, as far as its set-up goes.
struct Sensor {
    registers: [u8; 256],
    /// What the next byte is read of.
    pointer: u8,
    /// Writes since the last reset.
    written: Vec<(u8, u8)>,
    /// Since its reset it was not left alone for long enough.
    is_resetting: bool,
    answers: bool,
}

impl Sensor {
    fn new(identity: u16) -> RefCell<Self> {
        let mut registers = [0xEE; 256];
        [registers[0x0A], registers[0x0B]] = identity.to_be_bytes();
        let sensor = Self { registers, pointer: 0, written: Vec::new(), is_resetting: false, answers: true };
        RefCell::new(sensor)
    }

    fn write(&mut self, bytes: &[u8]) {
        match *bytes {
            [register] => self.pointer = register,
            [0x12, value] if value & 0x80 != 0 => {
                self.is_resetting = true;
                self.written.clear();
            }
            [register, value] => {
                self.registers[usize::from(register)] = value;
                self.written.push((register, value));
            }
            _ => panic!("no such message: {bytes:?}"),
        }
    }
}

struct Bus<'a>(&'a RefCell<Sensor>);

impl ErrorType for Bus<'_> {
    type Error = ErrorKind;
}

impl I2c for Bus<'_> {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        let mut sensor = self.0.borrow_mut();
        if address != 0x21 || !sensor.answers || sensor.is_resetting {
            return Err(ErrorKind::Other);
        }
        match operations {
            [Operation::Write(bytes)] => sensor.write(bytes),
            [Operation::Read(bytes)] => bytes.fill(sensor.registers[usize::from(sensor.pointer)]),
            // SCCB has no repeated start
            _ => return Err(ErrorKind::Bus),
        }
        Ok(())
    }
}

/// Time that passes at once, and ends a reset.
struct Clock<'a>(&'a RefCell<Sensor>);

impl DelayNs for Clock<'_> {
    async fn delay_ns(&mut self, ns: u32) {
        if ns >= 1_000_000 {
            self.0.borrow_mut().is_resetting = false;
        }
    }
}

/// Nothing here waits.
fn at_once<T>(future: impl Future<Output = T>) -> T {
    let Poll::Ready(value) = pin!(future).poll(&mut Context::from_waker(Waker::noop())) else {
        panic!("it waits")
    };
    value
}

fn start(sensor: &RefCell<Sensor>) -> Result<(), SensorError> {
    at_once(Ov7725::new(Bus(sensor)).start(&mut Clock(sensor)))
}

#[test]
fn it_sends_qvga_in_rgb565_after_its_reset() {
    let sensor = Sensor::new(0x7721);
    assert_eq!(start(&sensor), Ok(()));
    let sensor = sensor.borrow();
    let register = |at: usize| sensor.registers[at];
    assert_eq!(register(0x12), 0x46, "COM7");
    assert_eq!(register(0x0C), 0, "COM3: high byte first, not mirrored");
    assert_eq!((register(0x29), register(0x2C)), (80, 120), "320 by 240 go out");
    assert_eq!((register(0x18), register(0x1A)), (80, 120), "and are read");
    assert_eq!(register(0x13) & 0b111, 0b111, "gain, white balance and exposure by itself");
    assert_eq!(sensor.written.len(), SETTINGS.len(), "all behind the reset");
}

#[test]
fn colours_are_held_and_exposure_is_not() {
    let sensor = Sensor::new(0x7721);
    let mut driver = Ov7725::new(Bus(&sensor));
    assert_eq!(at_once(driver.start(&mut Clock(&sensor))), Ok(()));
    let before = sensor.borrow().registers;
    assert_eq!(driver.hold_colours(), Ok(()));
    let mut expected = before;
    expected[0x13] &= !0b110;
    assert_eq!(sensor.borrow().registers, expected);
}

#[test]
fn another_part_is_named_and_left_as_it_is() {
    let sensor = Sensor::new(0x2642);
    assert_eq!(start(&sensor), Err(SensorError::Stranger(0x2642)));
    assert!(sensor.borrow().written.is_empty() && !sensor.borrow().is_resetting);
}

#[test]
fn silence_is_told() {
    let sensor = Sensor::new(0x7721);
    sensor.borrow_mut().answers = false;
    assert_eq!(start(&sensor), Err(SensorError::Silent));
    assert_eq!(Ov7725::new(Bus(&sensor)).hold_colours(), Err(SensorError::Silent));
}

#[test]
fn the_rows_of_a_picture_take_their_share_of_the_shortest_time_between_two() {
    let mut timing = Timing::default();
    assert_eq!(timing.whole(1_000_000), 0, "one picture says nothing");
    // a picture was left out before this one
    assert_eq!(timing.whole(1_055_600), 48_000);
    assert_eq!(timing.whole(1_083_400), 24_000);
    assert_eq!(timing.whole(1_200_000), 24_000);
}
