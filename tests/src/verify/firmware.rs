//! The firmware: built for its target, and run on QEMU's boards.

use super::target::{TRIPLE, Toolchain};
use super::{Context, Outcome, Run, packages, suite};
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(900);

const MANIFEST: &str = "firmware/Cargo.toml";

/// Every board's feature.
const BOARDS: [&str; 1] = ["mps2"];

fn build(context: &Context, toolchain: &Toolchain, features: &str) -> Run {
    let base = ["build", "--locked", "--release", "--manifest-path", MANIFEST, "--features", features];
    let mut cargo = toolchain.cargo(context, &base);
    context.run(cargo.env("CARGO_TARGET_DIR", context.target.join("firmware")), LIMIT)
}

fn programs(context: &Context) -> PathBuf {
    context.target.join("firmware").join(TRIPLE).join("release")
}

/// No lint is left in the firmware of any board.
pub(super) fn clippy(context: &Context) -> Outcome {
    let toolchain = match Toolchain::find(context) {
        Ok(toolchain) => toolchain,
        Err(missing) => return Outcome::skip(&context.check, missing),
    };
    for board in BOARDS {
        let base = ["clippy", "--locked", "--release", "--manifest-path", MANIFEST, "--features", board];
        let mut cargo = toolchain.cargo(context, &base);
        cargo.args(["--", "--deny", "warnings"]).env("CARGO_TARGET_DIR", context.target.join("firmware"));
        let run = context.run(&mut cargo, LIMIT);
        if !run.ok {
            return run.outcome();
        }
    }
    Outcome::pass()
}

/// Both QEMU boards, on the pictures that the desktop has.
pub(super) fn qemu(context: &Context) -> Outcome {
    let ready = Toolchain::find(context).and_then(|toolchain| has_qemu(context).map(|()| toolchain));
    let toolchain = match ready {
        Ok(toolchain) => toolchain,
        Err(missing) => return Outcome::skip(&context.check, missing),
    };
    let built = build(context, &toolchain, "mps2");
    if !built.ok {
        return built.outcome();
    }
    let programs = programs(context);
    let Some(folder) = programs.to_str() else {
        return Outcome::fail(format!("{}: the path has to be UTF-8", programs.display()));
    };
    let arguments =
        ["test", "--locked", "--package", "tetrad-qemu", "--features", "boards", "--no-fail-fast"];
    let figures = context.log_path(&context.check).with_extension("figures");
    // Left over from the last run; that it is not there is the usual case.
    let _ = fs::remove_file(&figures);
    let told = [("TETRAD_FIRMWARE", folder), ("TETRAD_FIGURES", figures.to_str().unwrap_or_default())];
    let outcome = suite::cargo_test_with(context, &arguments, &told);
    if outcome.failed > 0 {
        return outcome;
    }
    outcome.showing(fs::read_to_string(figures).unwrap_or_default())
}

fn has_qemu(context: &Context) -> Result<(), String> {
    let qemu = Command::new("qemu-system-arm").arg("--version").output();
    if qemu.is_ok_and(|output| output.status.success()) {
        return Ok(());
    }
    packages::debian(context, &["qemu-system-arm"])
}
