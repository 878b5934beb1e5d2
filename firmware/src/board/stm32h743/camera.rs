//! Pictures of the OV7725 by DCMI and DMA, one at a time.

use super::pictures::{read_anew, words};
use crate::capture::{NoPicture, Sensor};
use crate::handover::{Captured, PICTURE_BYTES, PictureBuffer};
use crate::ov7725::{HEIGHT, Ov7725, SensorError, Timing, WIDTH};
use cortex_m::peripheral::{CPUID, SCB};
use embassy_stm32::dcmi::Dcmi;
use embassy_stm32::gpio::Output;
use embassy_stm32::i2c::{I2c, Master};
use embassy_stm32::mode::Blocking;
use embassy_stm32::{pac, peripherals};
use embassy_time::{Delay, Duration, Instant, Timer, with_timeout};
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::wire::BadPicture;

/// The longest a picture may take: one that has just begun is waited out, and the next comes.
const PICTURE: Duration = Duration::from_millis(200);

/// After so many without a picture the sensor is set up anew.
const PATIENCE: u32 = 3;

/// The pause before it is tried again when that does not help.
const PAUSE: Duration = Duration::from_millis(100);

/// How long the sensor's pins stay as they are when it is reset.
const RESET: Duration = Duration::from_millis(10);

/// Pictures until gain and white balance have settled, and are held.
const SETTLING: u32 = 60;

/// The image sensor, its registers and the interface that its pictures come by.
pub struct Camera {
    interface: Dcmi<'static, peripherals::DCMI>,
    sensor: Ov7725<I2c<'static, Blocking, Master>>,
    reset: Output<'static>,
    off: Output<'static>,
    scb: SCB,
    cpuid: CPUID,
    timing: Timing,
    /// Pictures since it was set up; `None` before.
    pictures: Option<u32>,
    /// Times in a row that none came.
    missed: u32,
}

impl Camera {
    pub(super) fn new(
        interface: Dcmi<'static, peripherals::DCMI>,
        registers: I2c<'static, Blocking, Master>,
        reset: Output<'static>,
        off: Output<'static>,
        scb: SCB,
        cpuid: CPUID,
    ) -> Self {
        let (sensor, timing) = (Ov7725::new(registers), Timing::default());
        Self { interface, sensor, reset, off, scb, cpuid, timing, pictures: None, missed: 0 }
    }

    /// Switches the caches on. Behind the first look at the buffers' memory, see [`super::pictures`].
    pub fn switch_caches_on(&mut self) {
        self.scb.enable_icache();
        self.scb.enable_dcache(&mut self.cpuid);
    }

    /// Resets the sensor by its pins, and sets it up.
    async fn set_up(&mut self) -> Result<(), SensorError> {
        self.off.set_low();
        self.reset.set_low();
        Timer::after(RESET).await;
        self.reset.set_high();
        Timer::after(RESET).await;
        self.sensor.start(&mut Delay).await?;
        (self.pictures, self.missed, self.timing) = (Some(0), 0, Timing::default());
        Ok(())
    }

    /// Waits for one picture; whether it came whole.
    async fn picture(&mut self, buffer: &mut PictureBuffer) -> bool {
        // the interface waits for its DMA even after an overrun, which then never ends: hence the limit
        let came = with_timeout(PICTURE, self.interface.capture(words(buffer))).await;
        let is_whole = matches!(came, Ok(Ok(())));
        if !is_whole {
            // what was given up was not told so: the next one would begin in the middle of a picture
            pac::DCMI.ier().modify(|interrupts| interrupts.0 = 0);
            pac::DCMI.cr().modify(|control| {
                control.set_capture(false);
                control.set_enable(false);
            });
        }
        is_whole
    }

    /// Holds the colours when they have settled; whether the sensor is still there.
    fn count_picture(&mut self) -> bool {
        self.missed = 0;
        let count = self.pictures.unwrap_or(0).saturating_add(1);
        self.pictures = Some(count);
        count != SETTLING || self.sensor.hold_colours().is_ok()
    }
}

impl Sensor for Camera {
    async fn capture(&mut self, buffer: &mut PictureBuffer) -> Result<Captured, NoPicture> {
        let none = NoPicture::Bad(BadPicture::Overrun);
        if self.pictures.is_none() && self.set_up().await.is_err() {
            Timer::after(PAUSE).await;
            return Err(none);
        }
        if !self.picture(buffer).await {
            self.missed += 1;
            if self.missed >= PATIENCE {
                self.pictures = None;
            }
            return Err(none);
        }
        let now_us = Instant::now().as_micros();
        read_anew(&mut self.scb, buffer);
        if !self.count_picture() {
            self.pictures = None;
        }
        let ready_us = self.timing.whole(now_us);
        Ok(Captured {
            length: PICTURE_BYTES,
            width: WIDTH,
            height: HEIGHT,
            format: PixelFormat::Rgb565Be,
            capture_us: now_us.saturating_sub(ready_us.into()),
            ready_us,
        })
    }
}
