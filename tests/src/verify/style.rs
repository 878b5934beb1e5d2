//! Layout, lints and documentation.

use super::{Context, Outcome};
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(900);

/// The packages outside the workspace: each has its own lock file and settings.
const APART: [&str; 3] = ["firmware/Cargo.toml", "fuzz/Cargo.toml", "tests/no-panic/Cargo.toml"];

pub(super) fn fmt(context: &Context) -> Outcome {
    let run = context.run(&mut context.cargo(["fmt", "--all", "--check"]), LIMIT);
    if !run.ok {
        return run.outcome();
    }
    for manifest in APART {
        let run = context.run(&mut context.cargo(["fmt", "--check", "--manifest-path", manifest]), LIMIT);
        if !run.ok {
            return run.outcome();
        }
    }
    Outcome::pass()
}

/// Every target; the tests in a browser and on boards are named, for they are none that `cargo test` runs by
/// itself.
pub(super) fn clippy(context: &Context) -> Outcome {
    let every = ["--workspace", "--all-targets"].as_slice();
    let boards = ["--package", "tetrad-qemu", "--all-targets", "--features", "boards,stm32h743"].as_slice();
    // as a microcontroller links it
    let few_views = ["--package", "tetrad-core", "--all-targets", "--no-default-features"].as_slice();
    for targets in [every, &["--package", "tetrad", "--test", "console"], boards, few_views] {
        let mut cargo = context.cargo(["clippy", "--locked"]);
        let run = context.run(cargo.args(targets).args(["--", "--deny", "warnings"]), LIMIT);
        if !run.ok {
            return run.outcome();
        }
    }
    Outcome::pass()
}

pub(super) fn doc(context: &Context) -> Outcome {
    let mut cargo = context.cargo(["doc", "--locked", "--workspace", "--no-deps"]);
    cargo.env("RUSTDOCFLAGS", "--deny warnings");
    context.run(&mut cargo, LIMIT).outcome()
}
