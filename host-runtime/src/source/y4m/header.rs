//! The first line of a film: `YUV4MPEG2 W640 H480 F30:1 Ip C420jpeg`.

use tetrad_core::vision::frame::MAX_SIDE;

use crate::source::MAX_FPS;

/// How many chroma samples there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Chroma {
    /// One for four pixels.
    Quarter,
    /// One for two neighbours in a row.
    Half,
    /// One a pixel.
    Full,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Header {
    pub(super) width: u16,
    pub(super) height: u16,
    /// `None` when the film says that it does not know (0:0) or nothing at all.
    pub(super) fps: Option<f64>,
    pub(super) chroma: Chroma,
    /// Whether samples span 0 to 255 instead of 16 to 235 (luma) and 240 (chroma).
    pub(super) full_range: bool,
}

impl Header {
    /// Understands the line, or says what is wrong with it.
    pub(super) fn parse(line: &[u8]) -> Result<Self, String> {
        let Some(parameters) = line.strip_prefix(b"YUV4MPEG2".as_slice()).filter(|rest| {
            // "YUV4MPEG2X" is something else.
            rest.is_empty() || rest.starts_with(b" ")
        }) else {
            return Err("does not begin with a YUV4MPEG2 header".to_owned());
        };
        let (mut width, mut height, mut fps) = (None, None, None);
        let (mut chroma, mut full_range) = (Chroma::Quarter, false);
        for parameter in parameters.split(|byte| *byte == b' ') {
            let text = String::from_utf8_lossy(parameter);
            let mut letters = text.chars();
            match (letters.next(), letters.as_str()) {
                (Some('W'), value) => width = Some(side("width", value)?),
                (Some('H'), value) => height = Some(side("height", value)?),
                (Some('F'), value) => fps = rate(value)?,
                (Some('I'), value) => progressive(value)?,
                (Some('C'), value) => chroma = sampling(value)?,
                (Some('X'), value) => full_range |= value == "COLORRANGE=FULL",
                // The shape of pixels and whatever else there may be changes nothing.
                _ => {}
            }
        }
        let width = width.ok_or("its header gives no width (W...)")?;
        let height = height.ok_or("its header gives no height (H...)")?;
        if (chroma != Chroma::Full && width % 2 != 0) || (chroma == Chroma::Quarter && height % 2 != 0) {
            return Err(format!(
                "{width} x {height} pixels whose colours are shared between neighbours: make both even with `ffmpeg -i IN.y4m -vf crop=trunc(iw/2)*2:trunc(ih/2)*2 OUT.y4m`"
            ));
        }
        Ok(Self { width, height, fps, chroma, full_range })
    }
}

fn side(name: &str, value: &str) -> Result<u16, String> {
    let pixels: u64 = value.parse().map_err(|_| format!("its header's {name} '{value}' is no number"))?;
    match u16::try_from(pixels) {
        Ok(pixels @ 1..=MAX_SIDE) => Ok(pixels),
        _ => Err(format!(
            "its header's {name} is {value} pixels, and 1 to {MAX_SIDE} are read here: scale the film"
        )),
    }
}

fn rate(value: &str) -> Result<Option<f64>, String> {
    let wrong = || format!("its header's frame rate '{value}' is not two numbers such as 30:1");
    let (numerator, denominator) = value.split_once(':').ok_or_else(wrong)?;
    let numerator: u32 = numerator.parse().map_err(|_| wrong())?;
    let denominator: u32 = denominator.parse().map_err(|_| wrong())?;
    if numerator == 0 && denominator == 0 {
        return Ok(None);
    }
    let fps = f64::from(numerator) / f64::from(denominator);
    if fps > 0.0 && fps <= MAX_FPS {
        Ok(Some(fps))
    } else {
        Err(format!("its header's frame rate {value} is not between 0 and {MAX_FPS} frames a second"))
    }
}

fn progressive(value: &str) -> Result<(), String> {
    match value {
        "p" | "?" => Ok(()),
        _ => Err("an interlaced film: two moments in one picture cannot be tracked; `ffmpeg -i IN -vf yadif OUT.y4m` separates them".to_owned()),
    }
}

fn sampling(value: &str) -> Result<Chroma, String> {
    match value {
        "420" | "420jpeg" | "420mpeg2" | "420paldv" => Ok(Chroma::Quarter),
        "422" => Ok(Chroma::Half),
        "444" => Ok(Chroma::Full),
        _ if value.starts_with("mono") => {
            Err("a grey film, and balls are found by their colour: record in colour".to_owned())
        }
        _ => Err(format!(
            "its samples are '{value}', and 8-bit 420, 422 and 444 are read here: `ffmpeg -i IN -pix_fmt yuv420p OUT.y4m` converts it"
        )),
    }
}
