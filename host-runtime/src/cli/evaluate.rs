//! `tetrad evaluate`: section 5 of the paper again, both modes side by side.

use super::{make_dir, progress, say};
use crate::evaluate::{Evaluation, Plan, broken_promises};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::report::{PAGE, Report};
use clap::Args;
use std::path::PathBuf;
use std::time::Instant;

pub(super) const EXAMPLES: &str = "\
Examples:
  Everything, in a few minutes, with the page to open in the end:
    tetrad evaluate --out evaluation
  A look in half a minute, with other noise:
    tetrad evaluate --quick --seed 7 --out evaluation-quick

DIR gets index.html (one page with all of it, which needs no network), and every table as CSV and every
figure as SVG beside it. The same seed gives the same tables; delays.csv, of times, is the exception.
Exit status 1 when a promise is not held (the report is whole then too), or when it cannot be made.";

/// The flags of `tetrad evaluate`.
#[derive(Args, Clone, Debug)]
pub(super) struct EvaluateArgs {
    /// Where the report goes; made if missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Fewer frames and cases
    #[arg(long)]
    quick: bool,
    /// Another seed is other noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

/// Runs `tetrad evaluate`.
pub(super) fn run(args: &EvaluateArgs) -> Result<(), Failure> {
    make_dir(&args.out)?;
    // the page of an earlier run never stands for one that ended before it had its own; and a place that
    // takes no file is told of now and not after the whole run
    Report::claim(&args.out).or_exit(Exit::Failed)?;
    say(format_args!("seed            {}", args.seed));
    let started = Instant::now();
    let evaluation = Evaluation::new(Plan::new(args.seed, args.quick));
    let bar = progress::frames(Some(evaluation.frames()));
    let report = evaluation.run(&|| bar.inc(1));
    bar.finish_and_clear();
    let report = report.or_exit(Exit::Failed)?;
    report.write(&args.out).or_exit(Exit::Failed)?;
    for row in &report.headlines.rows {
        let fields: Vec<String> = row.iter().map(|cell| cell.text()).collect();
        if let [what, published, refined, promised, promise, paper] = &fields[..] {
            say(format_args!(
                "{what}\n    refined     {refined}\n    promised    {promised}: {promise}\n    paper mode  {paper}\n    published   {published}"
            ));
        }
    }
    say(format_args!("took            {:.0} s", started.elapsed().as_secs_f64()));
    say(format_args!("report          {}", args.out.join(PAGE).display()));
    let broken = broken_promises(&report);
    if broken.is_empty() {
        return Ok(());
    }
    let cause = anyhow::anyhow!("not held: {}", broken.join("; "));
    Err(Failure::new(Exit::Failed, cause).help("the report is whole, and shows by how much"))
}
