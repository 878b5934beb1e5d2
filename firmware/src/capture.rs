//! Pictures from a sensor into free buffers.

use crate::handover::{Buffers, Captured, Input, Inputs, Picture, PictureBuffer};
use tetrad_core::wire::BadPicture;

/// Why a sensor gave no picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPicture {
    /// It had one that cannot be looked at.
    Bad(BadPicture),
    /// There are no more.
    End,
}

/// A sensor, or what stands for one.
#[allow(async_fn_in_trait, reason = "tasks of one executor: nobody asks whether the future is Send")]
pub trait Sensor {
    /// Waits for the next picture and has it written to `buffer`.
    async fn capture(&mut self, buffer: &mut PictureBuffer) -> Result<Captured, NoPicture>;
}

/// Fills one free buffer after the other and hands it on. A sensor that is faster than the tracker loses
/// pictures, never parts of them. Ends with the sensor's pictures.
pub async fn capture(mut sensor: impl Sensor, buffers: &Buffers, inputs: &Inputs) {
    loop {
        let buffer = buffers.receive().await;
        let input = match sensor.capture(buffer).await {
            Ok(captured) => Input::Picture(Picture { buffer, captured }),
            Err(none) => {
                // there is room: it has just come from there
                buffers.send(buffer).await;
                match none {
                    NoPicture::Bad(why) => Input::BadPicture(why),
                    NoPicture::End => {
                        inputs.send(Input::End).await;
                        return;
                    }
                }
            }
        };
        inputs.send(input).await;
    }
}
