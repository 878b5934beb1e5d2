//! `tetrad replay`: a recorded session through the same pipeline again.

mod results;
mod serve;

use super::same_file::{self, Input};
use super::{make_dir, make_results_dir, note, say};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::session::{self, Compared, Outcome, Reader, replay};
use anyhow::Context as _;
use clap::Args;
use results::Results;
use std::path::{Path, PathBuf};

pub(super) const EXAMPLES: &str = "\
Examples:
  Whether this version still sees what was seen when it was recorded:
    tetrad replay session.mcap --out replayed

  What was recorded, as CSV in replayed/recorded and as one page:
    tetrad replay session.mcap --out replayed --export-csv --report session.html

  To look at it moment by moment, in a browser on this computer, until Ctrl-C:
    tetrad replay session.mcap --serve

DIR gets what `tetrad track` writes, computed anew. Exit code 0 means that observations and poses are
those that were recorded, bit by bit; 1 that they are not, and the first difference is told.";

/// The flags of `tetrad replay`.
#[derive(Args, Clone, Debug)]
pub(super) struct ReplayArgs {
    /// The session, from `tetrad record` or `tetrad operator --record`
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Where the results go; made if missing
    #[arg(long, value_name = "DIR", required_unless_present = "serve")]
    out: Option<PathBuf>,
    /// Write the recorded channels as they are into DIR/recorded, as CSV
    #[arg(long)]
    export_csv: bool,
    /// Write plots of what was recorded as one page
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Show it, and those beside it, on a page of the console; nothing is computed anew
    #[arg(long, conflicts_with_all = ["out", "export_csv", "report"])]
    serve: bool,
}

/// Where the recorded channels go, in the folder of the results.
const RECORDED: &str = "recorded";

/// Runs `tetrad replay`.
pub(super) fn run(args: &ReplayArgs) -> Result<(), Failure> {
    let mut reader = Reader::open(&args.file).or_exit(Exit::Failed)?;
    // without one the flags ask for --serve
    let Some(out) = &args.out else { return serve::run(&args.file) };
    refuse_own_file(args, out)?;
    make_results_dir(out)?;
    if args.export_csv {
        let dir = out.join(RECORDED);
        make_dir(&dir)?;
        session::export(&mut Reader::open(&args.file).or_exit(Exit::Failed)?, &dir).or_exit(Exit::Failed)?;
        say(format_args!("what was recorded is in {}", dir.display()));
    }
    if let Some(page) = &args.report {
        let mut reader = Reader::open(&args.file).or_exit(Exit::Failed)?;
        let title = format!("Session {}", args.file.display());
        let report = session::report(&mut reader, &title).or_exit(Exit::Failed)?;
        std::fs::write(page, report.page())
            .with_context(|| format!("cannot write {}", page.display()))
            .or_exit(Exit::BadArguments)?;
        say(format_args!("plots are in {}", page.display()));
    }
    let mut results = Results::create(out, reader.beginning())?;
    let outcome = replay(&mut reader, |made| results.take(&made));
    let stopped_by = outcome.as_ref().err().map(|failure: &Failure| format!("{:#}", failure.cause));
    let written = results.finish(stopped_by);
    let outcome = outcome?;
    written?;
    report(&outcome, args, out)
}

/// A session is not written over by what is made of it.
fn refuse_own_file(args: &ReplayArgs, out: &Path) -> Result<(), Failure> {
    let session = [Input::new("the session", &args.file)];
    if let Some(page) = &args.report {
        same_file::refuse("--report", page, session)?;
    }
    same_file::refuse_in("--out", out, session)?;
    if args.export_csv { same_file::refuse_in("--out", &out.join(RECORDED), session) } else { Ok(()) }
}

fn report(outcome: &Outcome, args: &ReplayArgs, out: &Path) -> Result<(), Failure> {
    let file = args.file.display();
    if outcome.cut {
        note(format_args!("{file}: cut short: what follows is of as much of it as there is"));
    }
    outcome.notes.iter().for_each(note);
    say(format_args!("{} pictures tracked again, results in {}", outcome.pictures, out.display()));
    for compared in &outcome.compared {
        say(line(compared));
    }
    if outcome.is_identical() {
        return Ok(());
    }
    let first = outcome.compared.iter().find(|compared| !compared.is_identical());
    let cause = match first {
        Some(Compared { what, first: Some(first), .. }) => {
            anyhow::anyhow!("{file}: the {what} are not those that were recorded; first {first}")
        }
        Some(Compared { what, missing, .. }) => {
            anyhow::anyhow!(
                "{file}: {missing} of the {what} cannot be computed anew, for pictures are missing"
            )
        }
        None => anyhow::anyhow!("{file}: there is nothing in it that could be compared"),
    };
    Err(Failure::new(Exit::Failed, cause))
}

fn line(compared: &Compared) -> String {
    let Compared { what, count, recorded, replayed, missing, .. } = compared;
    let missing = if *missing > 0 { format!(", {missing} missing") } else { String::new() };
    if compared.is_identical() {
        format!("{what:<24} {count:>7} identical, hash {recorded:016x}")
    } else {
        format!(
            "{what:<24} {count:>7} compared, hash {recorded:016x} recorded, {replayed:016x} replayed{missing}"
        )
    }
}
