//! Setting up the image sensor OV7725 (OmniVision, data sheet of 2008): QVGA in RGB565, over SCCB.
//!
//! SCCB is I2C without a repeated start: a register is read by writing its number, a stop, and reading one
//! byte. What is not set here stays as the sensor has it after its reset.

use core::fmt;
use embedded_hal::i2c::I2c;
use embedded_hal_async::delay::DelayNs;

/// Pixels of a row.
pub const WIDTH: u16 = 320;

/// Rows of a picture.
pub const HEIGHT: u16 = 240;

/// Rows from one picture to the next: those that are sent, and the pause.
const ROWS_WITH_PAUSE: u32 = 278;

/// Its address on the bus, seven bits.
const ADDRESS: u8 = 0x21;

/// What its two registers of identity hold.
const IDENTITY: u16 = 0x7721;

/// How long it is left alone after a reset, milliseconds; the data sheet asks for one.
const RESET_MS: u32 = 5;

const IDENTITY_HIGH: u8 = 0x0A;
const IDENTITY_LOW: u8 = 0x0B;
const COM3: u8 = 0x0C;
const COM4: u8 = 0x0D;
const CLKRC: u8 = 0x11;
const COM7: u8 = 0x12;
const COM8: u8 = 0x13;
const HSTART: u8 = 0x17;
const HSIZE: u8 = 0x18;
const VSTART: u8 = 0x19;
const VSIZE: u8 = 0x1A;
const HOUTSIZE: u8 = 0x29;
const EXHCH: u8 = 0x2A;
const VOUTSIZE: u8 = 0x2C;
const HREF: u8 = 0x32;

/// COM7: all registers as they are when power comes.
const RESET: u8 = 0x80;

/// COM7: QVGA, RGB565, RGB.
const QVGA_RGB565: u8 = 0x40 | 0x04 | 0x02;

/// COM8: fast, in steps of any size; gain, white balance and exposure by itself.
const BY_ITSELF: u8 = 0x80 | 0x40 | 0x04 | 0x02 | 0x01;

/// COM8: the same with gain and white balance as they are.
const COLOURS_HELD: u8 = 0x80 | 0x40 | 0x01;

/// What is written, in this order: register, value.
const SETTINGS: [(u8, u8); 13] = [
    // the clock that comes in times four, and a quarter of that: of 12 MHz, 37 pictures a second by the
    // data sheet
    (COM4, 0x41),
    (CLKRC, 0x81),
    (COM7, QVGA_RGB565),
    // neither mirrored nor swapped: a pixel's high byte first, red in its upper bits
    (COM3, 0x00),
    // where the picture begins on the sensor, and its size: four columns and two rows a step
    (HSTART, 0x3F),
    (HSIZE, (WIDTH / 4) as u8),
    (VSTART, 0x03),
    (VSIZE, (HEIGHT / 2) as u8),
    (HREF, 0x00),
    (HOUTSIZE, (WIDTH / 4) as u8),
    (VOUTSIZE, (HEIGHT / 2) as u8),
    (EXHCH, 0x00),
    (COM8, BY_ITSELF),
];

/// Why the sensor could not be set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorError {
    /// Nobody answers on the bus.
    Silent,
    /// Another part answers, of this identity.
    Stranger(u16),
}

impl fmt::Display for SensorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silent => f.write_str("the image sensor does not answer"),
            Self::Stranger(identity) => write!(f, "no OV7725 but {identity:#06x}"),
        }
    }
}

impl core::error::Error for SensorError {}

/// The sensor on its bus.
pub struct Ov7725<B> {
    bus: B,
}

impl<B: I2c> Ov7725<B> {
    /// The sensor as it is: nothing is sent.
    pub const fn new(bus: B) -> Self {
        Self { bus }
    }

    /// Sets it up from its reset on. Colours and brightness settle within the next pictures.
    ///
    /// # Errors
    /// It is not there, or is another one.
    pub async fn start(&mut self, delay: &mut impl DelayNs) -> Result<(), SensorError> {
        let identity = u16::from_be_bytes([self.read(IDENTITY_HIGH)?, self.read(IDENTITY_LOW)?]);
        if identity != IDENTITY {
            return Err(SensorError::Stranger(identity));
        }
        self.write(COM7, RESET)?;
        delay.delay_ms(RESET_MS).await;
        SETTINGS.into_iter().try_for_each(|(register, value)| self.write(register, value))
    }

    /// Keeps gain and white balance as they are, so that a colour stays as it was learnt when something
    /// bright or coloured comes into the picture. Exposure still follows the light.
    ///
    /// # Errors
    /// It is not there.
    pub fn hold_colours(&mut self) -> Result<(), SensorError> {
        self.write(COM8, COLOURS_HELD)
    }

    fn write(&mut self, register: u8, value: u8) -> Result<(), SensorError> {
        self.bus.write(ADDRESS, &[register, value]).map_err(|_| SensorError::Silent)
    }

    fn read(&mut self, register: u8) -> Result<u8, SensorError> {
        let mut value = [0];
        self.bus.write(ADDRESS, &[register]).map_err(|_| SensorError::Silent)?;
        self.bus.read(ADDRESS, &mut value).map_err(|_| SensorError::Silent)?;
        let [value] = value;
        Ok(value)
    }
}

/// When pictures were taken, by when they were whole: the sensor says neither how fast it is nor when a
/// picture begins, so that the shortest time between two of them is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timing {
    newest_us: Option<u64>,
    period_us: Option<u64>,
}

impl Timing {
    /// A picture was whole; how long its rows took to come, microseconds. 0 for the first, of which that
    /// is not known.
    pub fn whole(&mut self, now_us: u64) -> u32 {
        if let Some(before) = self.newest_us.replace(now_us) {
            let since = now_us.saturating_sub(before);
            self.period_us = Some(self.period_us.map_or(since, |period| period.min(since)));
        }
        let rows = self.period_us.unwrap_or(0) * u64::from(HEIGHT) / u64::from(ROWS_WITH_PAUSE);
        u32::try_from(rows).unwrap_or(u32::MAX)
    }
}

#[cfg(test)]
mod tests;
