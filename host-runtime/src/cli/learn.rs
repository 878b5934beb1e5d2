//! `tetrad learn`: teach the balls' colours, by pointing at them or by confirming a proposal.

mod node;

use super::same_file::{self, Input};
use super::{make_dir, note, say};
use crate::balls::ball_by_name;
use crate::colours::{Colours, Origin};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::learning::{self, Taught};
use crate::output::ScanCsv;
use crate::scene_file::Seeds;
use crate::settings::smart_camera::SerialPlace;
use crate::source::{self, Frame, Options, Source, View};
use anyhow::Context as _;
use clap::{ArgGroup, Args, ValueEnum};
use std::io::{self, IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use tetrad_core::config::{LearnConfig, ProposeConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::vision::colour::Reference;
use tetrad_core::vision::frame::{FrameView, Rgb};
use tetrad_core::vision::learn::propose::propose;
use tetrad_core::vision::learn::{HorizontalScan, Learnt};

/// The most columns of a scan: a window of three diameters of 256 pixels.
const SCAN_COLUMNS: usize = 768;

pub(super) const EXAMPLES: &str = "\
Examples:
  Point at the balls in the first frame (pixels; x right, y down, from the top-left pixel):
    tetrad learn --source clip/left --at red=412,230 --at green=455,232 --at blue=410,180 \\
                 --at yellow=398,251 --out left.toml
  Let the program find the four balls in both cameras, look at what it proposes and confirm:
    tetrad learn --source /dev/video0 --right-source /dev/video2 --find --out left.toml \\
                 --out-right right.toml
  Write the horizontal scan through each ball (figures 1, 2 and 5 of the paper) as CSV:
    tetrad learn --source sim:still --find --yes --out left.toml --scan scans";

/// The flags of `tetrad learn`.
#[derive(Args, Clone, Debug)]
#[command(group(ArgGroup::new("how").required(true).args(["at", "find"])))]
pub(super) struct LearnArgs {
    /// The camera: /dev/videoN, a folder of numbered frames, a .y4m file or sim:NAME; with --at also
    /// node:serial:DEVICE, a smart camera
    #[arg(long, value_name = "SRC")]
    source: String,
    /// With sim:NAME: which of its cameras --source is
    #[arg(long, value_enum, default_value_t = Side::Left)]
    view: Side,
    /// A point inside a ball, in pixels; once for each ball
    #[arg(long, value_name = "BALL=X,Y")]
    at: Vec<At>,
    /// Propose the four balls instead of being told where they are
    #[arg(long)]
    find: bool,
    /// With --find: the other camera, whose picture must agree
    #[arg(long, value_name = "SRC", requires_all = ["find", "out_right"], conflicts_with = "view")]
    right_source: Option<String>,
    /// With --find: write what is proposed without asking
    #[arg(long, requires = "find")]
    yes: bool,
    /// The frame to learn from, counted from 0
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: u64,
    /// The colours file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// The other camera's colours file
    #[arg(long, value_name = "FILE", requires = "right_source")]
    out_right: Option<PathBuf>,
    /// Write the horizontal scan through each ball as DIR/scan-BALL.csv (DIR/scan-right-BALL.csv)
    #[arg(long, value_name = "DIR")]
    scan: Option<PathBuf>,
}

/// One of the two cameras of a simulated scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Side {
    /// The first.
    Left,
    /// The second.
    Right,
}

impl From<Side> for View {
    fn from(side: Side) -> Self {
        match side {
            Side::Left => Self::Left,
            Side::Right => Self::Right,
        }
    }
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
    refuse_own_source(args)?;
    match SerialPlace::of(&args.source) {
        _ if args.find => find(args),
        Some(place) => {
            let wrong = |problem| Failure::bad_arguments(format!("--source {}: {problem}", args.source));
            node::point(args, &place.map_err(wrong)?)
        }
        None => point(args),
    }
}

/// What is learnt goes to files of its own.
fn refuse_own_source(args: &LearnArgs) -> Result<(), Failure> {
    let left = Input::source("--source", &args.source);
    let right = args.right_source.as_deref().and_then(|right| Input::source("--right-source", right));
    let sources = || left.into_iter().chain(right);
    same_file::refuse("--out", &args.out, sources())?;
    if let Some(out_right) = &args.out_right {
        same_file::refuse("--out", &args.out, [Input::new("--out-right", out_right)])?;
        same_file::refuse("--out-right", out_right, sources())?;
    }
    args.scan.as_ref().map_or(Ok(()), |dir| same_file::refuse_in("--scan", dir, sources()))
}

/// Learns at the points given.
fn point(args: &LearnArgs) -> Result<(), Failure> {
    let seeds = seeds(&args.at)?;
    let mut camera = Camera::open(&args.source, args.view.into(), &args.out)?;
    let frame = camera.frame(args.frame)?;
    let (width, height) = (frame.view.width(), frame.view.height());
    let taught = learning::learn_at(&frame.view, &seeds, &LearnConfig::default()).map_err(|refused| {
        let exit = if refused.outside() { Exit::BadArguments } else { Exit::Failed };
        let what = format!("nothing learnt from frame {} of {} ({width}x{height})", args.frame, args.source);
        Failure::new(exit, anyhow::Error::new(refused).context(what))
    })?;
    describe(&taught);
    if let Some(dir) = &args.scan {
        scans(dir, "scan", &frame.view, &taught)?;
    }
    camera.save(args.frame, &taught)
}

/// Proposes the four balls and learns them once that is confirmed.
fn find(args: &LearnArgs) -> Result<(), Failure> {
    let mut cameras = vec![Camera::open(&args.source, args.view.into(), &args.out)?];
    if let (Some(source), Some(out)) = (&args.right_source, &args.out_right) {
        cameras.push(Camera::open(source, View::Right, out)?);
    }
    let frames = cameras.iter_mut().map(|camera| camera.frame(args.frame)).collect::<Result<Vec<_>, _>>()?;
    let views: Vec<_> = frames.iter().map(|frame| frame.view).collect();
    let proposal = propose(&views, &ProposeConfig::default());

    let mut found: Vec<Taught> = Vec::new();
    let mut reasons = Vec::new();
    for ((view, frame), name) in proposal.views.iter().zip(&views).zip(args.names()) {
        match view.balls {
            Ok(balls) => {
                let next = view.runner_up;
                say(format_args!("{name}: score {:.2} of 1, the next best four have {next:.2}", view.score));
                let taught = balls.map(Some);
                describe(&taught);
                if let Some(dir) = &args.scan {
                    scans(dir, if found.is_empty() { "scan" } else { "scan-right" }, frame, &taught)?;
                }
                found.push(taught);
            }
            Err(reason) => reasons.push(format!("{name}: {reason}")),
        }
    }
    if !reasons.is_empty() {
        return Err(Failure::new(Exit::Failed, anyhow::anyhow!("{}", reasons.join("\n")))
            .help("point at the balls with --at, as --at red=412,230"));
    }
    if !(args.yes || confirmed()?) {
        return Err(Failure::new(Exit::Failed, anyhow::anyhow!("not confirmed: nothing is written")));
    }
    cameras.iter().zip(&found).try_for_each(|(camera, taught)| camera.save(args.frame, taught))
}

/// Asks on the terminal.
fn confirmed() -> Result<bool, Failure> {
    if !io::stdin().is_terminal() {
        return Err(Failure::bad_arguments("nobody is there to confirm the proposal: nothing is written")
            .help("run it on a terminal, or give --yes"));
    }
    let _ = write!(io::stderr(), "Are these the balls? [y/N] ");
    let mut answer = String::new();
    io::stdin().read_line(&mut answer).context("cannot read the answer").or_exit(Exit::Failed)?;
    Ok(matches!(answer.trim(), "y" | "Y" | "yes"))
}

impl LearnArgs {
    /// What the cameras are called in messages.
    fn names(&self) -> Vec<String> {
        match &self.right_source {
            None => vec![self.source.clone()],
            Some(right) => vec![format!("left ({})", self.source), format!("right ({right})")],
        }
    }
}

/// A source, and the colours file it teaches.
struct Camera<'a> {
    source: Box<dyn Source>,
    out: &'a Path,
}

impl<'a> Camera<'a> {
    fn open(spec: &str, view: View, out: &'a Path) -> Result<Self, Failure> {
        let mut source = source::open(spec, &Options { view, ..Options::default() })?;
        source.take_notices().iter().for_each(note);
        Ok(Self { source, out })
    }

    /// The frame of that index.
    fn frame(&mut self, index: u64) -> Result<Frame<'_>, Failure> {
        let name = self.source.info().name.clone();
        let too_short = |frames| {
            let counted = "counted from 0";
            Failure::bad_arguments(format!("--frame {index}: {name} has only {frames} frames, {counted}"))
        };
        for skipped in 0..index {
            if self.source.next()?.is_none() {
                return Err(too_short(skipped));
            }
        }
        self.source.next()?.ok_or_else(|| too_short(index))
    }

    fn save(&self, frame: u64, taught: &Taught) -> Result<(), Failure> {
        let balls = taught.map(|learnt| learnt.as_ref().map(learning::as_colours));
        let origin = Some(Origin { source: self.source.info().name.clone(), frame });
        write(self.out, &Colours { balls, origin })
    }
}

fn write(out: &Path, colours: &Colours) -> Result<(), Failure> {
    std::fs::write(out, colours.to_toml())
        .with_context(|| format!("cannot write {}", out.display()))
        .or_exit(Exit::Failed)?;
    say(format_args!("colours written to {}", out.display()));
    Ok(())
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

fn scans(dir: &Path, prefix: &str, frame: &FrameView<'_>, taught: &Taught) -> Result<(), Failure> {
    make_dir(dir)?;
    let config = LearnConfig::default();
    for (ball, learnt) in Ball::ALL.into_iter().zip(taught) {
        let Some(learnt) = learnt else { continue };
        let Learnt { reference, centre, diameter, .. } = learnt;
        let scan =
            HorizontalScan::<SCAN_COLUMNS>::through(frame, reference, config.alpha_256, *centre, *diameter)
                .with_context(|| format!("no scan through the {} ball", ball.name()))
                .or_exit(Exit::Failed)?;
        ScanCsv::write(dir, &format!("{prefix}-{}.csv", ball.name()), &scan).or_exit(Exit::Failed)?;
    }
    Ok(())
}
