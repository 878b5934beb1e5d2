//! Which of its formats a camera is asked for, and what it makes of it.

use std::io;

use tetrad_core::vision::frame::{MAX_SIDE, PixelFormat};

use super::device::{Device, FourCc, FrameSize, Picture};

/// What is asked for when the user does not say.
pub(super) const DEFAULT_SIZE: (u16, u16) = (640, 480);

/// A granted rate this close to the one asked for is no news: 30 is often 29.97.
const RATE_TOLERANCE: f64 = 0.01;

/// The formats core reads, best first: full colour at every pixel, then colour shared by two, by
/// four, and last the coarse 16-bit ones.
const READABLE: [(FourCc, PixelFormat); 8] = [
    (FourCc(*b"RGB3"), PixelFormat::Rgb888),
    (FourCc(*b"BGR3"), PixelFormat::Bgr888),
    (FourCc(*b"AB24"), PixelFormat::Rgba8888),
    (FourCc(*b"YUYV"), PixelFormat::Yuyv),
    (FourCc(*b"UYVY"), PixelFormat::Uyvy),
    (FourCc(*b"NV12"), PixelFormat::Nv12),
    (FourCc(*b"RGBP"), PixelFormat::Rgb565Le),
    (FourCc(*b"RGBR"), PixelFormat::Rgb565Be),
];

/// What the camera will send.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Agreed {
    pub(super) width: u16,
    pub(super) height: u16,
    pub(super) stride: usize,
    pub(super) format: PixelFormat,
    /// `None` when the driver does not tell.
    pub(super) fps: Option<f64>,
}

/// Why nothing was agreed.
pub(super) enum Disagreement {
    /// The driver failed.
    Io(io::Error),
    /// The camera has nothing we can use: what, and what would help.
    Unusable(String),
}

impl From<io::Error> for Disagreement {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Sets size, format and rate, as near to the wish as the camera comes, and reads back what it
/// granted. What differs from the wish is told of in `notices`.
pub(super) fn negotiate(
    device: &mut impl Device,
    size: Option<(u16, u16)>,
    fps: f64,
    notices: &mut Vec<String>,
) -> Result<Agreed, Disagreement> {
    let (width, height) = size.unwrap_or(DEFAULT_SIZE);
    let offered = device.formats()?;
    let (best, format) = choose(device, &offered, u32::from(width), u32::from(height))?;
    let granted = device.set_format(&best)?;
    if granted.fourcc != best.fourcc {
        return Err(Disagreement::Unusable(format!(
            "asked for {} pictures it sends {}: it may be set up by another program; close that",
            best.fourcc, granted.fourcc
        )));
    }
    if granted.interlaced {
        return Err(Disagreement::Unusable(
            "it sends interlaced pictures, two moments in one: choose a progressive mode on the device"
                .to_owned(),
        ));
    }
    let (Ok(agreed_width), Ok(agreed_height)) = (u16::try_from(granted.width), u16::try_from(granted.height))
    else {
        return Err(too_large(&granted));
    };
    if agreed_width > MAX_SIDE || agreed_height > MAX_SIDE {
        return Err(too_large(&granted));
    }
    if (agreed_width, agreed_height) != (width, height) {
        notices.push(format!(
            "asked for {width} x {height} pixels, the camera sends {agreed_width} x {agreed_height}"
        ));
    }
    let yuv = matches!(format, PixelFormat::Yuyv | PixelFormat::Uyvy | PixelFormat::Nv12);
    if yuv && granted.other_yuv {
        notices.push(
            "its YUV is not BT.601 limited range and is read as if it were: use colours taught on this camera only"
                .to_owned(),
        );
    }
    let granted_fps = device.set_rate(fps)?;
    match granted_fps {
        Some(rate) if (rate - fps).abs() > fps * RATE_TOLERANCE => {
            notices.push(format!("asked for {fps} frames/s, the camera sends {rate:.2}"));
        }
        Some(_) => {}
        None => {
            notices.push(format!("the camera does not tell its frame rate; {fps} frames/s were asked for"))
        }
    }
    // A driver that gives no stride has no padding.
    let stride = (granted.stride as usize).max(format.row_bytes(usize::from(agreed_width)));
    Ok(Agreed { width: agreed_width, height: agreed_height, stride, format, fps: granted_fps })
}

/// The first readable format that comes in the size asked for; else the one that comes nearest.
fn choose(
    device: &mut impl Device,
    offered: &[FourCc],
    width: u32,
    height: u32,
) -> Result<(Picture, PixelFormat), Disagreement> {
    let area = u64::from(width) * u64::from(height);
    let mut best: Option<(u64, Picture, PixelFormat)> = None;
    for (fourcc, format) in READABLE.iter().filter(|(fourcc, _)| offered.contains(fourcc)) {
        let granted = device.try_format(&Picture::ask(*fourcc, width, height))?;
        if granted.fourcc != *fourcc || granted.interlaced {
            continue;
        }
        let distance = if (granted.width, granted.height) == (width, height) {
            0
        } else {
            (u64::from(granted.width) * u64::from(granted.height)).abs_diff(area).max(1)
        };
        if best.as_ref().is_none_or(|(nearest, ..)| distance < *nearest) {
            best = Some((distance, granted, *format));
        }
    }
    best.map(|(_, granted, format)| (granted, format))
        .ok_or_else(|| Disagreement::Unusable(refusal(device, offered)))
}

fn too_large(granted: &Picture) -> Disagreement {
    Disagreement::Unusable(format!(
        "its pictures have {} x {} pixels, and at most {MAX_SIDE} a side are read here",
        granted.width, granted.height
    ))
}

/// Names what the camera offers, what is read, and what to do.
fn refusal(device: &mut impl Device, offered: &[FourCc]) -> String {
    if offered.is_empty() {
        return "it offers no picture format at all: choose its input first (v4l2-ctl --set-input)"
            .to_owned();
    }
    let readable: Vec<String> = READABLE.iter().map(|(fourcc, _)| fourcc.to_string()).collect();
    format!(
        "it offers only {}, and progressive {} are read in this version: record with another program to a .y4m file, or use another camera",
        offers(device, offered).join("; "),
        readable.join(", ")
    )
}

/// What a camera offers, for people: formats that come in the same sizes together, those that are
/// read first.
pub(super) fn offers(device: &mut impl Device, offered: &[FourCc]) -> Vec<String> {
    let mut groups: Vec<(bool, Vec<FrameSize>, Vec<String>)> = Vec::new();
    for fourcc in offered {
        let readable = READABLE.iter().any(|(known, _)| known == fourcc);
        // A driver need not list sizes.
        let sizes = device.sizes(*fourcc).unwrap_or_default();
        match groups.iter_mut().find(|(read, same, _)| *read == readable && *same == sizes) {
            Some((.., names)) => names.push(fourcc.to_string()),
            None => groups.push((readable, sizes, vec![fourcc.to_string()])),
        }
    }
    // Stable: false comes before true.
    groups.sort_by_key(|(readable, ..)| !readable);
    groups
        .iter()
        .map(|(readable, sizes, names)| {
            let sizes: Vec<String> = sizes.iter().map(FrameSize::to_string).collect();
            let (colon, note) =
                (if sizes.is_empty() { "" } else { ": " }, if *readable { "" } else { " (not read)" });
            format!("{}{note}{colon}{}", names.join(", "), sizes.join(", "))
        })
        .collect()
}
