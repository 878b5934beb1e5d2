//! The camera's automatic controls, off while we look and as they were afterwards.
//!
//! A tracker that knows balls by their colour cannot use a camera that changes its colours: exposure,
//! gain, white balance and focus are taken off automatic before the first picture, each said by
//! name, and set back when the camera is closed. Exposure and white balance then stay at the
//! camera's manual values, the same in every session, so that colours taught once stay right.

use std::io;

use super::device::Device;

/// An automatic control: its number in linux/v4l2-controls.h, its name for people, and the value
/// that means off.
struct Automatic {
    id: u32,
    name: &'static str,
    off: i32,
}

/// In this order: gain and white balance may only become settable once exposure is manual.
const AUTOMATIC: [Automatic; 4] = [
    // V4L2_CID_EXPOSURE_AUTO; V4L2_EXPOSURE_MANUAL is 1.
    Automatic { id: 0x009a_0901, name: "auto exposure", off: 1 },
    // V4L2_CID_AUTOGAIN
    Automatic { id: 0x0098_0912, name: "automatic gain", off: 0 },
    // V4L2_CID_AUTO_WHITE_BALANCE
    Automatic { id: 0x0098_090c, name: "auto white balance", off: 0 },
    // V4L2_CID_FOCUS_AUTO
    Automatic { id: 0x009a_090c, name: "autofocus", off: 0 },
];

/// The values controls had.
#[derive(Debug, Default)]
pub(super) struct Saved(Vec<(u32, i32)>);

/// Switches off what the camera has and tells of each. A control that is missing, inactive or off
/// already is passed over; one that will not go off is told of and does not stop the camera.
pub(super) fn switch_off(device: &mut impl Device, notices: &mut Vec<String>) -> Saved {
    let mut saved = Saved::default();
    for automatic in &AUTOMATIC {
        match switch_one(device, automatic) {
            Ok(None) => {}
            Ok(Some(before)) => {
                saved.0.push((automatic.id, before));
                notices.push(format!(
                    "{} switched off; it is set back when the camera is closed",
                    automatic.name
                ));
            }
            Err(error) => notices.push(format!(
                "{} could not be switched off ({error}): colours may drift from those taught",
                automatic.name
            )),
        }
    }
    saved
}

/// The value before, when it was another.
fn switch_one(device: &mut impl Device, automatic: &Automatic) -> io::Result<Option<i32>> {
    let info = device.control_info(automatic.id)?;
    if !info.is_some_and(|info| info.settable) {
        return Ok(None);
    }
    let before = device.control(automatic.id)?;
    if before == automatic.off {
        return Ok(None);
    }
    device.set_control(automatic.id, automatic.off)?;
    // Some drivers accept a value and keep their own.
    match device.control(automatic.id)? {
        now if now == automatic.off => Ok(Some(before)),
        now => Err(io::Error::other(format!("it went to {now} instead of {}", automatic.off))),
    }
}

/// Sets the controls back, the last one first. A camera that is gone cannot be set back and forgets
/// by itself.
pub(super) fn restore(device: &mut impl Device, saved: &Saved) {
    for &(id, value) in saved.0.iter().rev() {
        let _ = device.set_control(id, value);
    }
}
