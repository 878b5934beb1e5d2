//! OpenMV Cam H7: STM32H743VI and OV7725. Nothing here has run on the board; README.md beside this file has
//! the pins, and what is not known.
//!
//! | job | file |
//! |---|---|
//! | clocks | `clock` |
//! | buffers for pictures, where DMA reaches them | `pictures` |
//! | pictures by DCMI and DMA, begun anew when none comes | `camera` |
//! | packets on the CAN bus | `bus` |
//! | the three colours of the light | `light` |
//! | a reset when no picture was looked at for too long | `watchdog` |
//! | what happens when something cannot be gone on with | `fault` |
//! | the log, with the feature `defmt` | `log` |
//!
//! The processor's stack and variables are in DTCM, which is as fast as it is. Caches are for code,
//! constants and pictures; `pictures` says why none of them ever shows an old picture.

pub mod bus;
pub mod camera;
mod clock;
mod fault;
pub mod light;
#[cfg(feature = "defmt")]
mod log;
pub mod pictures;
pub mod watchdog;

use embassy_stm32::dcmi::Dcmi;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::i2c::{self, I2c};
use embassy_stm32::peripherals::{DCMI, DMA1_CH0, FDCAN2, RNG, USART3};
use embassy_stm32::rcc::{Mco, Mco1Source, McoConfig};
use embassy_stm32::rng::Rng;
use embassy_stm32::usart::{BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_stm32::{bind_interrupts, can, dcmi, dma, rng, usart};
use embassy_time::Duration;
use static_cell::ConstStaticCell;

/// Of the serial line.
const BAUD: u32 = 921_600;

/// Bytes that wait on the serial line, each way.
const RING: usize = 1024;

/// The longest an image sensor's register may take.
const REGISTER: Duration = Duration::from_millis(10);

bind_interrupts!(struct Interrupts {
    DCMI => dcmi::InterruptHandler<DCMI>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
    FDCAN2_IT0 => can::IT0InterruptHandler<FDCAN2>;
    FDCAN2_IT1 => can::IT1InterruptHandler<FDCAN2>;
    RNG => rng::InterruptHandler<RNG>;
    USART3 => usart::BufferedInterruptHandler<USART3>;
});

/// What the board has.
pub struct Board {
    /// The image sensor.
    pub camera: camera::Camera,
    /// What is told, from the serial line.
    pub told: BufferedUartRx<'static>,
    /// What is said, to the serial line.
    pub said: BufferedUartTx<'static>,
    /// The CAN bus, to send.
    pub bus: bus::Bus,
    /// The light.
    pub light: light::Light,
    /// The button; it pulls its pin low.
    pub button: Input<'static>,
    /// A program that looks at pictures in their time wakes it.
    pub watchdog: watchdog::Asleep,
    /// The camera's place in the list of views: 1 where the jumper is set, else 0.
    pub number: u8,
    /// Another one each time the board starts.
    pub session: u32,
}

/// Starts the clocks and everything but the watchdog. Once.
///
/// # Panics
/// When called a second time.
#[must_use]
pub fn start() -> Board {
    let p = embassy_stm32::init(clock::settings());
    // read last: until then its pull-up has pulled it up
    let jumper = Input::new(p.PD13, Pull::Up);
    let core = cortex_m::Peripherals::take().expect("the board is started once");

    // the image sensor's clock is the crystal's; embassy's is only needed to set it
    let _ = Mco::new(p.MCO1, p.PA8, Mco1Source::HSE, McoConfig::default());
    let mut settings = i2c::Config::default();
    settings.timeout = REGISTER;
    let registers = I2c::new_blocking(p.I2C1, p.PB8, p.PB9, settings);
    let (d0, d1, d2, d3, d4, d5, d6, d7) = (p.PC6, p.PC7, p.PE0, p.PE1, p.PE4, p.PB6, p.PE5, p.PE6);
    let (vertical, horizontal, pixel) = (p.PB7, p.PA4, p.PA6);
    // the levels and the edge of the OV7725 are embassy's own defaults
    let settings = dcmi::Config::default();
    let interface = Dcmi::new_8bit(
        p.DCMI, p.DMA1_CH0, Interrupts, d0, d1, d2, d3, d4, d5, d6, d7, vertical, horizontal, pixel, settings,
    );
    let reset = Output::new(p.PA10, Level::Low, Speed::Low);
    let off = Output::new(p.PD7, Level::Low, Speed::Low);
    let camera = camera::Camera::new(interface, registers, reset, off, core.SCB, core.CPUID);

    static SAID: ConstStaticCell<[u8; RING]> = ConstStaticCell::new([0; RING]);
    static TOLD: ConstStaticCell<[u8; RING]> = ConstStaticCell::new([0; RING]);
    let mut settings = usart::Config::default();
    settings.baudrate = BAUD;
    let line = BufferedUart::new(p.USART3, p.PB11, p.PB10, SAID.take(), TOLD.take(), Interrupts, settings);
    let (said, told) = line.expect("the clock is fast enough for this rate").split();

    let number = u8::from(jumper.is_low());
    Board {
        camera,
        told,
        said,
        bus: bus::Bus::new(can::CanConfigurator::new(p.FDCAN2, p.PB12, p.PB13, Interrupts), number),
        light: light::Light::new(p.PC0, p.PC1, p.PC2),
        button: Input::new(p.PD14, Pull::Up),
        watchdog: watchdog::Asleep(p.IWDG1),
        number,
        session: Rng::new(p.RNG, Interrupts).next_u32(),
    }
}
