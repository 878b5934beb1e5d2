//! What the dependencies are: licences, doubles, origin, known vulnerabilities (`deny.toml`).

use super::packages;
use super::{Context, Outcome};
use std::time::Duration;

const VERSION: &str = "0.20.2";
const LIMIT: Duration = Duration::from_secs(300);

/// What cargo-deny prints when it cannot get the database of advisories.
const UNREACHABLE: &str = "failed to fetch advisory database";

pub(super) fn licences(context: &Context) -> Outcome {
    deny(context, "licenses")
}

pub(super) fn bans(context: &Context) -> Outcome {
    deny(context, "bans")
}

pub(super) fn sources(context: &Context) -> Outcome {
    deny(context, "sources")
}

pub(super) fn advisories(context: &Context) -> Outcome {
    deny(context, "advisories")
}

fn deny(context: &Context, part: &str) -> Outcome {
    let tool = match packages::cargo_tool(context, "cargo-deny", VERSION) {
        Ok(tool) => tool,
        Err(missing) => return Outcome::skip(&context.check, missing),
    };
    let mut deny = std::process::Command::new(tool);
    deny.args(["--all-features", "check", part]).current_dir(&context.repository);
    let run = context.run(&mut deny, LIMIT);
    if !run.ok && run.output.contains(UNREACHABLE) {
        return Outcome::skip(&context.check, "the advisory database on github.com cannot be reached");
    }
    run.outcome()
}
