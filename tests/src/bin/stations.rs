//! `cargo stations`: four stations on loopback, and what may happen to them.

use std::path::PathBuf;
use std::process::{Command, ExitCode};
use std::time::Duration;
use tetrad_tests::stations::{Cell, RUNS, Run};

const USAGE: &str = "\
Starts two camera stations, an operator and a slave with a simulated arm as processes on loopback.
Logs and results: target/stations/RUN/

Usage: cargo stations [--seconds N] [--program FILE] [RUN...] | --list

  RUN             plain (the default), strangers, flood, page, deaths, or all
  --seconds N     how long the arm is driven in `plain` [default: 60]
  --program FILE  the `tetrad` to run [default: built here, release]

Exit codes: 0 all was as it has to be, 1 it was not, 2 bad arguments";

struct Arguments {
    seconds: u64,
    program: Option<PathBuf>,
    runs: Vec<&'static Run>,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|argument| argument == "--list") {
        RUNS.iter().for_each(|run| println!("{:10} {}", run.name, run.shows));
        return ExitCode::SUCCESS;
    }
    if arguments.iter().any(|argument| argument == "--help" || argument == "-h") {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    match understood(&arguments) {
        Ok(arguments) => all(&arguments),
        Err(problem) => {
            eprintln!("error: {problem}\n\n{USAGE}");
            ExitCode::from(2)
        }
    }
}

fn understood(arguments: &[String]) -> Result<Arguments, String> {
    let mut understood = Arguments { seconds: 60, program: None, runs: Vec::new() };
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--seconds" => {
                let seconds =
                    rest.next().and_then(|text| text.parse().ok()).filter(|n| (10..=86_400).contains(n));
                understood.seconds = seconds.ok_or("--seconds: a whole number from 10 to 86400 is needed")?;
            }
            "--program" => {
                understood.program = Some(rest.next().ok_or("--program: a file is needed")?.into());
            }
            "all" => understood.runs.extend(RUNS),
            name => {
                let run = RUNS.iter().find(|run| run.name == name);
                understood.runs.push(run.ok_or_else(|| format!("there is no run called {name}"))?);
            }
        }
    }
    if understood.runs.is_empty() {
        understood.runs.extend(RUNS.iter().take(1));
    }
    Ok(understood)
}

fn all(arguments: &Arguments) -> ExitCode {
    let target = tetrad_tests::target();
    let program = match &arguments.program {
        Some(program) => program.clone(),
        None => {
            let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
            cargo.args(["build", "--release", "--package", "tetrad"]).current_dir(tetrad_tests::repository());
            if !cargo.status().is_ok_and(|status| status.success()) {
                eprintln!("error: tetrad could not be built");
                return ExitCode::FAILURE;
            }
            target.join("release/tetrad")
        }
    };
    let mut failed = false;
    for run in &arguments.runs {
        println!("=== {}: {}", run.name, run.shows);
        let made = Cell::make(&program, &target.join("stations").join(run.name));
        match made.and_then(|cell| run.run(&cell, Duration::from_secs(arguments.seconds))) {
            Ok(report) => println!("{report}=== {}: as it has to be", run.name),
            Err(problem) => {
                failed = true;
                println!("{problem}\n=== {}: FAILED", run.name);
            }
        }
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
