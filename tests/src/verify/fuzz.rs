//! A short run of each fuzz target of `fuzz/`. Longer by hand: `cargo fuzz run --sanitizer none NAME`.

use super::packages;
use super::{Context, Outcome};
use std::process::Command;
use std::time::Duration;

const VERSION: &str = "0.13.2";

/// What a run may take: building the target, and [`SECONDS`] of running it.
const LIMIT: Duration = Duration::from_secs(1200);

/// How long inputs are tried.
const SECONDS: u32 = 20;

pub(super) fn frame(context: &Context) -> Outcome {
    fuzz(context, "frame")
}

pub(super) fn packet(context: &Context) -> Outcome {
    fuzz(context, "packet")
}

pub(super) fn link(context: &Context) -> Outcome {
    fuzz(context, "link")
}

pub(super) fn node(context: &Context) -> Outcome {
    fuzz(context, "node")
}

pub(super) fn session(context: &Context) -> Outcome {
    fuzz(context, "session")
}

pub(super) fn colours(context: &Context) -> Outcome {
    fuzz(context, "colours")
}

fn fuzz(context: &Context, target: &str) -> Outcome {
    let ready =
        packages::cargo_tool(context, "cargo-fuzz", VERSION).and_then(|tool| has_cxx(context).map(|()| tool));
    let tool = match ready {
        Ok(tool) => tool,
        Err(missing) => return Outcome::skip(&context.check, missing),
    };
    // What the fuzzer keeps goes to target/, beside the seeds that are part of the repository.
    let corpus = context.target.join("fuzz").join(target);
    if let Err(error) = std::fs::create_dir_all(&corpus) {
        return Outcome::fail(format!("{}: {error}", corpus.display()));
    }
    let mut fuzz = Command::new(tool);
    // No sanitizer: the code under test is safe Rust, where panics and hangs are what can go wrong,
    // and without one the stable compiler will do.
    fuzz.args(["run", "--sanitizer", "none", target]).arg(corpus);
    fuzz.arg(context.repository.join("fuzz/seeds").join(target));
    fuzz.args(["--", &format!("-max_total_time={SECONDS}"), "-timeout=10", "-max_len=4096"]);
    fuzz.env("RUSTC_BOOTSTRAP", "1").env_remove("CARGO_TARGET_DIR").current_dir(&context.repository);
    context.run(&mut fuzz, LIMIT).outcome()
}

/// libFuzzer is C++.
fn has_cxx(context: &Context) -> Result<(), String> {
    if Command::new("c++").arg("--version").output().is_ok_and(|output| output.status.success()) {
        return Ok(());
    }
    packages::debian(context, &["g++"])
}
