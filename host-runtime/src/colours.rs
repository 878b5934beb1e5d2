//! `colours.toml`: what was learnt about each ball's colour in one camera.
//!
//! ```toml
//! [learnt_from]                # optional, for people
//! source = "sim:linear"
//! frame = 0
//!
//! [red]
//! reference = [203, 41, 52]    # p_ref of eq. 1, each component 0 to 255
//! typical = [198, 44, 55]      # p_typ
//! background = [120, 118, 110] # p_bkg
//! diameter_px = 16.5           # its width
//! aspect = 1.0                 # optional: height / width, for pixels that are not square
//! at = [312.4, 201.9]          # optional: where the ball was
//! ```
//!
//! One table a ball, at least one ball. Parsing is strict: an unknown key, a value out of range or a
//! ball that cannot be told from its background is an error that names the file and the key.

use crate::balls::BallSet;
use std::fmt::{self, Write as _};
use tetrad_core::config::MAX_DIAMETER;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::{LearntBall, MAX_ASPECT, MIN_DIAMETER};
use tetrad_core::vision::colour::{Matcher, Primary, Reference};
use tetrad_core::vision::frame::Rgb;
use toml::{Table, Value};

const KEYS_OF_A_BALL: [&str; 6] = ["reference", "typical", "background", "diameter_px", "aspect", "at"];
const KEYS_OF_THE_ORIGIN: [&str; 2] = ["source", "frame"];

/// What is known of one ball in one camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallColours {
    /// Colours and size, as the tracker takes them.
    pub learnt: LearntBall,
    /// Where the ball was in that picture.
    pub at: Option<ImagePoint>,
}

/// Where colours were learnt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The source as it was given on the command line.
    pub source: String,
    /// The frame's number, from 0.
    pub frame: u64,
}

/// One camera's colours, ordered as [`Ball::ALL`]; `None` for a ball that was not learnt.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Colours {
    /// The balls.
    pub balls: [Option<BallColours>; BALLS],
    /// Where they were learnt.
    pub origin: Option<Origin>,
}

/// Why a colours file is refused: the file, the key in it, and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ColoursError {
    /// The file as it was named.
    pub file: String,
    /// The table and key, as `[red] typical`; empty when the whole file is meant.
    pub key: String,
    /// What is wrong, in words that say what would be right.
    pub problem: String,
}

impl fmt::Display for ColoursError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, key, problem } = self;
        if key.is_empty() { write!(f, "{file}: {problem}") } else { write!(f, "{file}: {key}: {problem}") }
    }
}

impl Colours {
    /// Reads the text of a colours file; `file` is only for messages.
    ///
    /// # Errors
    /// [`ColoursError`] for text that is not TOML, unknown keys, missing keys, values out of range
    /// (NaN too), balls that equal their background, and a file without a ball.
    pub fn parse(text: &str, file: &str) -> Result<Self, ColoursError> {
        let at = |key: &str, problem: String| ColoursError { file: file.into(), key: key.into(), problem };
        let table: Table = text.parse().map_err(|e: toml::de::Error| at("", format!("not TOML: {e}")))?;
        let mut colours = Self::default();
        for (name, value) in &table {
            let Value::Table(entries) = value else {
                return Err(at(name, "a table is needed here, as `[red]`".into()));
            };
            if name == "learnt_from" {
                colours.origin = Some(parse_origin(entries).map_err(|(key, problem)| at(&key, problem))?);
            } else if let Some(ball) = Ball::ALL.into_iter().find(|ball| ball.name() == name) {
                let learnt = parse_ball(ball, entries).map_err(|(key, problem)| at(&key, problem))?;
                colours.balls[ball.index()] = Some(learnt);
            } else {
                let known = "red, green, blue, yellow and learnt_from";
                return Err(at(&format!("[{name}]"), format!("unknown table: there are {known}")));
            }
        }
        if BallSet::known(&colours.balls).is_none() {
            let problem = "it has no ball: add at least one with `tetrad learn --at red=X,Y`";
            return Err(at("", problem.into()));
        }
        Ok(colours)
    }

    /// The same colours with only these balls.
    ///
    /// # Errors
    /// [`ColoursError`] naming the first ball of the set that the file does not have.
    pub fn select(mut self, balls: BallSet, file: &str) -> Result<Self, ColoursError> {
        for ball in Ball::ALL {
            let slot = &mut self.balls[ball.index()];
            if !balls.contains(ball) {
                *slot = None;
            } else if slot.is_none() {
                let name = ball.name();
                return Err(ColoursError {
                    file: file.into(),
                    key: format!("[{name}]"),
                    problem: format!(
                        "the {name} ball is missing: learn it with `tetrad learn --at {name}=X,Y`, \
                         or name the balls to track with --balls"
                    ),
                });
            }
        }
        Ok(self)
    }

    /// What a tracker takes.
    #[must_use]
    pub fn learnt_balls(&self) -> [Option<LearntBall>; BALLS] {
        self.balls.map(|ball| ball.map(|ball| ball.learnt))
    }

    /// The text of the file; [`Colours::parse`] gives the same value back.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text =
            String::from("# Ball colours of one camera, for `tetrad track --colours-left/-right`.\n");
        if let Some(Origin { source, frame }) = &self.origin {
            let source = Value::String(source.clone());
            let _ = write!(text, "\n[learnt_from]\nsource = {source}\nframe = {frame}\n");
        }
        for ball in Ball::ALL {
            let Some(BallColours { learnt, at }) = self.balls[ball.index()] else { continue };
            let LearntBall { reference, diameter, aspect } = learnt;
            let _ = write!(
                text,
                "\n[{}]\nreference = {}\ntypical = {}\nbackground = {}\ndiameter_px = {diameter:?}\naspect = {aspect:?}\n",
                ball.name(),
                components(reference.reference),
                components(reference.typical),
                components(reference.background),
            );
            if let Some(ImagePoint { u, v }) = at {
                let _ = writeln!(text, "at = [{u:?}, {v:?}]");
            }
        }
        text
    }
}

fn components(colour: Rgb) -> String {
    format!("[{}, {}, {}]", colour.r, colour.g, colour.b)
}

/// A problem within a table: the key, and what is wrong with it.
type Problem = (String, String);

fn parse_ball(ball: Ball, entries: &Table) -> Result<BallColours, Problem> {
    let table = ball.name();
    refuse_unknown(table, entries, &KEYS_OF_A_BALL)?;
    let colour = |key| {
        let value = required(table, entries, key)?;
        parse_rgb(value).ok_or_else(|| {
            (format!("[{table}] {key}"), format!("three whole numbers from 0 to 255 are needed, not {value}"))
        })
    };
    let reference = Reference {
        primary: Primary::of(ball),
        reference: colour("reference")?,
        typical: colour("typical")?,
        background: colour("background")?,
    };
    let again = format!("learn the ball again with `tetrad learn --at {table}=X,Y`");
    if reference.typical == reference.background {
        let problem = format!("it equals background, so nothing tells the ball from it: {again}");
        return Err((format!("[{table}] typical"), problem));
    }
    // alpha does not matter here: a reference without contrast is refused for any of them
    if let Err(error) = Matcher::new(&reference, 128) {
        return Err((format!("[{table}] typical"), format!("{error}: {again}")));
    }
    let ranged = |key: &str, value: &Value, (least, most): (f32, f32)| {
        number(value).filter(|x| (least..=most).contains(x)).ok_or_else(|| {
            (format!("[{table}] {key}"), format!("a number from {least} to {most} is needed, not {value}"))
        })
    };
    let diameter = required(table, entries, "diameter_px")?;
    let diameter = ranged("diameter_px", diameter, (MIN_DIAMETER, MAX_DIAMETER))?;
    let aspect = match entries.get("aspect") {
        Some(value) => ranged("aspect", value, (1.0 / MAX_ASPECT, MAX_ASPECT))?,
        None => 1.0,
    };
    let at = entries.get("at").map(|value| {
        parse_point(value)
            .ok_or_else(|| (format!("[{table}] at"), format!("two finite numbers are needed, not {value}")))
    });
    let learnt = LearntBall { reference, diameter, aspect };
    Ok(BallColours { learnt, at: at.transpose()? })
}

fn parse_origin(entries: &Table) -> Result<Origin, Problem> {
    let table = "learnt_from";
    refuse_unknown(table, entries, &KEYS_OF_THE_ORIGIN)?;
    let source = required(table, entries, "source")?;
    let frame = required(table, entries, "frame")?;
    Ok(Origin {
        source: source
            .as_str()
            .ok_or_else(|| (format!("[{table}] source"), "a string is needed".into()))?
            .to_owned(),
        frame: frame.as_integer().and_then(|n| u64::try_from(n).ok()).ok_or_else(|| {
            (format!("[{table}] frame"), format!("a whole number from 0 is needed, not {frame}"))
        })?,
    })
}

fn required<'a>(table: &str, entries: &'a Table, key: &str) -> Result<&'a Value, Problem> {
    entries.get(key).ok_or_else(|| (format!("[{table}] {key}"), "the key is missing".into()))
}

fn refuse_unknown(table: &str, entries: &Table, known: &[&str]) -> Result<(), Problem> {
    match entries.keys().find(|key| !known.contains(&key.as_str())) {
        Some(key) => {
            Err((format!("[{table}] {key}"), format!("unknown key: there are {}", known.join(", "))))
        }
        None => Ok(()),
    }
}

fn parse_rgb(value: &Value) -> Option<Rgb> {
    let [r, g, b] = value.as_array()?.as_slice() else { return None };
    let component = |value: &Value| value.as_integer().and_then(|c| u8::try_from(c).ok());
    Some(Rgb::new(component(r)?, component(g)?, component(b)?))
}

fn parse_point(value: &Value) -> Option<ImagePoint> {
    let [u, v] = value.as_array()?.as_slice() else { return None };
    let point = ImagePoint::new(number(u)?, number(v)?);
    point.is_finite().then_some(point)
}

/// A number, whole or not; NaN and infinities come through and fail the range check that follows.
fn number(value: &Value) -> Option<f32> {
    match *value {
        Value::Float(x) => Some(x as f32),
        Value::Integer(x) => Some(x as f32),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
