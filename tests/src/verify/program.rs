//! The program itself: the demo runs, real footage is tracked, and README names nothing that is not
//! there.

use super::{Context, Outcome};
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

const BUILD_LIMIT: Duration = Duration::from_secs(900);
const RUN_LIMIT: Duration = Duration::from_secs(120);

/// Subcommands of cargo itself that README may name.
const CARGO_COMMANDS: [&str; 7] = ["bench", "build", "doc", "fuzz", "install", "run", "test"];

pub(super) fn demo(context: &Context) -> Outcome {
    let program = match build(context) {
        Ok(program) => program,
        Err(failure) => return failure,
    };
    let folder = context.target.join("verify/demo");
    if let Err(error) = fs::create_dir_all(&folder) {
        return Outcome::fail(format!("{}: {error}", folder.display()));
    }
    let mut demo = Command::new(program);
    demo.args(["demo", "--headless", "--seconds", "10"]).current_dir(folder);
    let run = context.run(&mut demo, RUN_LIMIT);
    let said = run.output.to_lowercase();
    for figure in ["frames", "centre error", "pose error"] {
        if run.ok && !said.contains(figure) {
            return Outcome::fail(format!("the demo did not print its {figure}:\n{}", run.output));
        }
    }
    let outcome = run.outcome();
    if run.ok { outcome.showing(run.output) } else { outcome }
}

/// The runs of `cargo stations` but the flood and the page's costs, which are measured on a quiet computer.
pub(super) fn stations(context: &Context) -> Outcome {
    let program = match build(context) {
        Ok(program) => program,
        Err(failure) => return failure,
    };
    let mut stations = context.cargo(["stations", "--seconds", "15", "--program"]);
    stations.arg(program).args(["plain", "strangers", "deaths"]);
    let run = context.run(&mut stations, BUILD_LIMIT);
    let outcome = run.outcome();
    if run.ok { outcome.showing(run.output) } else { outcome }
}

pub(super) fn footage(context: &Context) -> Outcome {
    if crate::shared().is_none() {
        return Outcome::skip(&context.check, "no shared footage: name its folder in TETRAD_SHARED");
    }
    if Command::new("python3").arg("--version").output().is_err() {
        return Outcome::skip(&context.check, "missing: python3");
    }
    let program = match build(context) {
        Ok(program) => program,
        Err(failure) => return failure,
    };
    let mut script = Command::new("python3");
    script
        .args(["tests/scripts/footage.py", "--check", "--tetrad"])
        .arg(program)
        .current_dir(&context.repository);
    let run = context.run(&mut script, BUILD_LIMIT);
    let outcome = run.outcome();
    if run.ok { outcome.showing(run.output) } else { outcome }
}

pub(super) fn readme(context: &Context) -> Outcome {
    let text = match read(context, "README.md") {
        Ok(text) => text,
        Err(failure) => return Outcome::fail(failure),
    };
    let aliases = match read(context, ".cargo/config.toml") {
        Ok(text) => text,
        Err(failure) => return Outcome::fail(failure),
    };
    let program = match build(context) {
        Ok(program) => program,
        Err(failure) => return failure,
    };
    let commands = commands_in(&text);
    if commands.is_empty() {
        return Outcome::fail("README.md names no command");
    }
    let mut unknown = Vec::new();
    for (name, subcommand) in commands {
        let exists = match name.as_str() {
            "cargo" => {
                CARGO_COMMANDS.contains(&subcommand.as_str())
                    || aliases.lines().any(|line| line.starts_with(&format!("{subcommand} = ")))
            }
            _ => {
                let mut help = Command::new(&program);
                context.run(help.args([subcommand.as_str(), "--help"]), RUN_LIMIT).ok
            }
        };
        if !exists {
            unknown.push(format!("{name} {subcommand}"));
        }
    }
    if unknown.is_empty() {
        Outcome::pass()
    } else {
        Outcome::fail(format!("README.md names what is not there: {}", unknown.join(", ")))
    }
}

fn read(context: &Context, file: &str) -> Result<String, String> {
    fs::read_to_string(context.repository.join(file)).map_err(|error| format!("{file}: {error}"))
}

pub(super) fn build(context: &Context) -> Result<PathBuf, Outcome> {
    let mut cargo = context.cargo(["build", "--locked", "--release", "--package", "tetrad"]);
    let run = context.run(&mut cargo, BUILD_LIMIT);
    if run.ok { Ok(context.target.join("release/tetrad")) } else { Err(run.outcome()) }
}

/// `cargo X` and `tetrad X` wherever a line of a code block in `markdown` starts with one.
fn commands_in(markdown: &str) -> BTreeSet<(String, String)> {
    let mut in_code = false;
    let mut commands = BTreeSet::new();
    for line in markdown.lines() {
        if line.starts_with("```") {
            in_code = !in_code;
        } else if in_code {
            let mut words = line.trim_start_matches("$ ").split_whitespace();
            if let (Some(name @ ("cargo" | "tetrad")), Some(subcommand)) = (words.next(), words.next()) {
                commands.insert((name.to_owned(), subcommand.to_owned()));
            }
        }
    }
    commands
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_found_in_code_blocks_only() {
        let markdown =
            "cargo nothing\n```sh\ncargo demo --headless\n$ tetrad track --left a\nls\n```\ntetrad no";
        let commands: Vec<_> = commands_in(markdown).into_iter().collect();
        assert_eq!(commands, [("cargo".into(), "demo".into()), ("tetrad".into(), "track".into())]);
    }
}
