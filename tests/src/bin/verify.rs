//! `cargo verify`: runs every check, prints each with its result, and ends with the plain count.

use std::process::ExitCode;
use tetrad_tests::verify::{CHECKS, Check, Context, run};

const USAGE: &str = "\
Runs every check of the project. Logs: target/verify/NAME.log

Usage: cargo verify [--quick] [--only NAME]... [--list]

  --quick      only what needs neither a release build nor another tool
  --only NAME  only this check; may be given more than once
  --list       name the checks and say what each protects

Exit codes: 0 nothing failed, 1 a check failed, 2 bad arguments";

/// What the arguments ask for.
enum Task {
    Help,
    List,
    Run(Vec<&'static Check>),
}

fn main() -> ExitCode {
    match parse(std::env::args().skip(1)) {
        Ok(Task::Help) => println!("{USAGE}"),
        Ok(Task::List) => {
            for check in CHECKS {
                println!("{:<20} {}", check.name, check.protects);
            }
        }
        Ok(Task::Run(checks)) => {
            let total = run(&Context::new(tetrad_tests::repository()), &checks);
            for skip in &total.skipped {
                println!("skipped {}: {}", skip.name, skip.why);
            }
            println!("{}", total.counts());
            return if total.failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE };
        }
        Err(message) => {
            eprintln!("{message}\n\n{USAGE}");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Task, String> {
    let mut quick = false;
    let mut only = Vec::new();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--help" | "-h" => return Ok(Task::Help),
            "--list" => return Ok(Task::List),
            "--quick" => quick = true,
            "--only" => {
                let name = arguments.next().ok_or("--only needs the name of a check")?;
                let check = CHECKS.iter().find(|check| check.name == name);
                only.push(check.ok_or_else(|| format!("there is no check {name}: --list names them"))?);
            }
            other => return Err(format!("{other} is not understood")),
        }
    }
    let chosen: Vec<&'static Check> = match only.is_empty() {
        true => CHECKS.iter().filter(|check| check.quick || !quick).collect(),
        false => only,
    };
    Ok(Task::Run(chosen))
}
