//! The firmware for the OpenMV Cam H7, which no emulator has: what can be shown without the board.

use super::firmware::MANIFEST;
use super::target::{TRIPLE, Toolchain};
use super::{Context, Outcome, suite};
use std::fs;
use std::time::Duration;

/// The crates for its chip are large.
const LIMIT: Duration = Duration::from_secs(1800);

/// What the camera with a log is called beside the one without.
const LOGGING: &str = "stm32h743-camera-logging";

/// The parts that know no board, on this computer.
pub(super) fn desktop(context: &Context) -> Outcome {
    let folder = context.target.join("firmware").display().to_string();
    let arguments = ["test", "--locked", "--manifest-path", MANIFEST, "--target-dir", &folder, "--lib"];
    let outcome = suite::cargo_test_with(context, &arguments, &[]);
    if outcome.passed == 0 && outcome.failed == 0 {
        return Outcome::fail("no test of the firmware ran: firmware/src is not where it was");
    }
    outcome
}

/// The programs are built, and tests/qemu looks at what they take of which memory.
pub(super) fn build(context: &Context) -> Outcome {
    let toolchain = match Toolchain::find(context) {
        Ok(toolchain) => toolchain,
        Err(missing) => return Outcome::skip(&context.check, missing),
    };
    let base = ["build", "--locked", "--release", "--manifest-path", MANIFEST];
    let folder = context.target.join("firmware");
    let programs = folder.join(TRIPLE).join("release");
    // the camera that logs first: the one that is kept and measured is the one without
    let builds: [(&str, &[&str]); 2] = [
        ("stm32h743,defmt", &["stm32h743-camera"]),
        ("stm32h743", &["stm32h743-camera", "stm32h743-streamed"]),
    ];
    for (features, names) in builds {
        let mut cargo = toolchain.cargo_for(context, &base, Some("cortex-m7"));
        cargo.args(["--features", features]).args(names.iter().flat_map(|name| ["--bin", name]));
        let logs = features.ends_with("defmt");
        if logs {
            cargo.env("DEFMT_LOG", "info");
        }
        let run = context.run(cargo.env("CARGO_TARGET_DIR", &folder), LIMIT);
        if !run.ok {
            return run.outcome();
        }
        if logs && let Err(error) = fs::rename(programs.join("stm32h743-camera"), programs.join(LOGGING)) {
            return Outcome::fail(format!("{LOGGING} cannot be kept: {error}"));
        }
    }
    let Some(programs) = programs.to_str() else {
        return Outcome::fail(format!("{}: the path has to be UTF-8", programs.display()));
    };
    let figures = context.log_path(&context.check).with_extension("figures");
    // Left over from the last run; that it is not there is the usual case.
    let _ = fs::remove_file(&figures);
    let arguments = ["test", "--locked", "--package", "tetrad-qemu", "--features", "stm32h743"];
    let arguments = [&arguments[..], &["--test", "stm32h743"]].concat();
    let told = [("TETRAD_STM32H743", programs), ("TETRAD_FIGURES", figures.to_str().unwrap_or_default())];
    let outcome = suite::cargo_test_with(context, &arguments, &told);
    if outcome.failed > 0 {
        return outcome;
    }
    outcome.showing(fs::read_to_string(figures).unwrap_or_default())
}
