//! `tetrad learn`: teach the balls' colours by pointing at them.

use super::{make_dir, note, say};
use crate::balls::ball_by_name;
use crate::colours::{Colours, Origin};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::learning::{self, Taught};
use crate::output::ScanCsv;
use crate::scene_file::Seeds;
use crate::source::{self, Frame, Options, Source, View};
use anyhow::Context as _;
use clap::Args;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use tetrad_core::config::LearnConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::vision::colour::Reference;
use tetrad_core::vision::frame::{FrameView, Rgb};
use tetrad_core::vision::learn::{HorizontalScan, Learnt};

/// The most columns of a scan: a window of three diameters of 256 pixels.
const SCAN_COLUMNS: usize = 768;

pub(super) const EXAMPLES: &str = "\
Examples:
  Point at the balls in the first frame (pixels; x right, y down, from the top-left pixel):
    tetrad learn --source clip/left --at red=412,230 --at green=455,232 --at blue=410,180 \\
                 --at yellow=398,251 --out left.toml
  Write the horizontal scan through each ball (figures 1, 2 and 5 of the paper) as CSV:
    tetrad learn --source sim:still --at red=320,240 --out left.toml --scan scans";

/// The flags of `tetrad learn`.
#[derive(Args, Clone, Debug)]
pub(super) struct LearnArgs {
    /// The camera: /dev/videoN, a folder of numbered frames, a .y4m file or sim:NAME
    #[arg(long, value_name = "SRC")]
    source: String,
    /// A point inside a ball, in pixels; once for each ball
    #[arg(long, value_name = "BALL=X,Y", required = true)]
    at: Vec<At>,
    /// The frame to learn from, counted from 0
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: u64,
    /// The colours file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Write the horizontal scan through each ball as DIR/scan-BALL.csv
    #[arg(long, value_name = "DIR")]
    scan: Option<PathBuf>,
}

/// `red=412,230.5`
#[derive(Clone, Copy, Debug, PartialEq)]
struct At {
    ball: Ball,
    point: ImagePoint,
}

impl FromStr for At {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = || format!("`{text}`: a ball and a point are needed, as red=412,230");
        let (name, point) = text.split_once('=').ok_or_else(wanted)?;
        let ball = ball_by_name(name.trim())?;
        let (u, v) = point.split_once(',').ok_or_else(wanted)?;
        let number = |text: &str| text.trim().parse().map_err(|_| wanted());
        let point = ImagePoint::new(number(u)?, number(v)?);
        if point.is_finite() { Ok(Self { ball, point }) } else { Err(wanted()) }
    }
}

/// Runs `tetrad learn`.
pub(super) fn run(args: &LearnArgs) -> Result<(), Failure> {
    let seeds = seeds(&args.at)?;
    let mut source = source::open(&args.source, &Options { view: View::Left, ..Options::default() })?;
    source.take_notices().iter().for_each(note);
    let name = &args.source;
    let frame = nth(source.as_mut(), args.frame)?;
    let (width, height) = (frame.view.width(), frame.view.height());
    let taught = learning::learn_at(&frame.view, &seeds, &LearnConfig::default()).map_err(|refused| {
        let exit = if refused.outside() { Exit::BadArguments } else { Exit::Failed };
        let what = format!("nothing learnt from frame {} of {name} ({width}x{height})", args.frame);
        Failure::new(exit, anyhow::Error::new(refused).context(what))
    })?;
    describe(&taught);
    if let Some(dir) = &args.scan {
        scans(dir, &frame.view, &taught)?;
    }
    let origin = Origin { source: name.clone(), frame: args.frame };
    save(&args.out, &taught, origin)
}

fn seeds(at: &[At]) -> Result<Seeds, Failure> {
    let mut seeds = Seeds::default();
    for At { ball, point } in at {
        if seeds[ball.index()].replace(*point).is_some() {
            return Err(Failure::bad_arguments(format!("--at {}: the ball is given twice", ball.name())));
        }
    }
    Ok(seeds)
}

/// The frame of that index.
fn nth(source: &mut dyn Source, index: u64) -> Result<Frame<'_>, Failure> {
    for skipped in 0..index {
        if source.next()?.is_none() {
            return Err(too_short(&source.info().name, skipped, index));
        }
    }
    let name = source.info().name.clone();
    source.next()?.ok_or_else(|| too_short(&name, index, index))
}

fn too_short(name: &str, frames: u64, index: u64) -> Failure {
    Failure::bad_arguments(format!("--frame {index}: {name} has only {frames} frames, counted from 0"))
}

fn describe(taught: &Taught) {
    for (ball, learnt) in Ball::ALL.into_iter().zip(taught) {
        let Some(learnt) = learnt else { continue };
        let Reference { reference, typical, background, .. } = learnt.reference;
        let rgb = |c: Rgb| format!("({}, {}, {})", c.r, c.g, c.b);
        say(format_args!(
            "{:<7} at ({:.1}, {:.1}), {:.1} px across; reference {}, typical {}, background {}",
            ball.name(),
            learnt.centre.u,
            learnt.centre.v,
            learnt.diameter,
            rgb(reference),
            rgb(typical),
            rgb(background)
        ));
        let clash = f32::from(learnt.clash_permille) / 10.0;
        say(format_args!("        {} ({clash} %)", learning::clash_in_words(learnt.clash_permille)));
    }
}

fn scans(dir: &Path, frame: &FrameView<'_>, taught: &Taught) -> Result<(), Failure> {
    make_dir(dir)?;
    let config = LearnConfig::default();
    for (ball, learnt) in Ball::ALL.into_iter().zip(taught) {
        let Some(learnt) = learnt else { continue };
        let Learnt { reference, centre, diameter, .. } = learnt;
        let scan =
            HorizontalScan::<SCAN_COLUMNS>::through(frame, reference, config.alpha_256, *centre, *diameter)
                .with_context(|| format!("no scan through the {} ball", ball.name()))
                .or_exit(Exit::Failed)?;
        ScanCsv::write(dir, &format!("scan-{}.csv", ball.name()), &scan).or_exit(Exit::Failed)?;
    }
    Ok(())
}

fn save(path: &Path, taught: &Taught, origin: Origin) -> Result<(), Failure> {
    let balls = taught.map(|learnt| learnt.as_ref().map(learning::as_colours));
    let text = Colours { balls, origin: Some(origin) }.to_toml();
    std::fs::write(path, text)
        .with_context(|| format!("cannot write {}", path.display()))
        .or_exit(Exit::Failed)?;
    say(format_args!("colours written to {}", path.display()));
    Ok(())
}
