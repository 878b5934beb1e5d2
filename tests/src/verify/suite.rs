//! The cargo tests, each counted.

use super::{Context, Outcome, count, packages};
use std::fs;
use std::time::Duration;

/// From clean: it builds every dependency, and takes twice as long on a computer that is shared.
const LIMIT: Duration = Duration::from_secs(2400);

pub(super) fn workspace(context: &Context) -> Outcome {
    cargo_test(context, &["test", "--locked", "--workspace", "--no-fail-fast"])
}

/// The golden hashes again, as a release build computes them: debug and release agree when both
/// agree with the file.
pub(super) fn golden_release(context: &Context) -> Outcome {
    let golden = [
        "test",
        "--locked",
        "--release",
        "--package",
        "tetrad-tests",
        "--test",
        "goldens",
        "--test",
        "session",
    ];
    let outcome = cargo_test(context, &golden);
    if outcome.passed == 0 && outcome.failed == 0 {
        return Outcome::fail("no golden test ran: tests/tests/goldens.rs is empty");
    }
    outcome
}

/// The property tests of the arm with all their random sequences; `cargo test` runs a twentieth.
pub(super) fn arm_sequences(context: &Context) -> Outcome {
    let arguments = ["test", "--locked", "--package", "tetrad-core", "--lib", "arm::"];
    let outcome = cargo_test_with(context, &arguments, &[("TETRAD_FULL", "1")]);
    if outcome.passed == 0 && outcome.failed == 0 {
        return Outcome::fail("no test of the arm ran: core/src/arm is not where it was");
    }
    outcome
}

/// Core as a microcontroller links it, for two cameras: what depends on their number.
pub(super) fn two_views(context: &Context) -> Outcome {
    let arguments =
        ["test", "--locked", "--package", "tetrad-core", "--no-default-features", "--lib", "hand::"];
    let outcome = cargo_test(context, &arguments);
    if outcome.passed == 0 && outcome.failed == 0 {
        return Outcome::fail("no test of the hand ran: core/src/hand is not where it was");
    }
    outcome
}

/// The console in a real browser, and what was measured there.
pub(super) fn console(context: &Context) -> Outcome {
    if let Err(missing) = packages::debian(context, &["chromium", "chromium-driver"]) {
        return Outcome::skip(&context.check, missing);
    }
    let arguments = ["test", "--locked", "--package", "tetrad", "--test", "console", "--", "--nocapture"];
    let outcome = cargo_test(context, &arguments);
    if outcome.passed == 0 && outcome.failed == 0 {
        return Outcome::fail("no test of the console ran: host-runtime/tests/console is not where it was");
    }
    if outcome.failed > 0 {
        return outcome;
    }
    let log = fs::read_to_string(context.log_path(&context.check)).unwrap_or_default();
    let figures: Vec<&str> =
        log.lines().filter_map(|line| line.split_once("measured: ")).map(|(_, figure)| figure).collect();
    outcome.showing(figures.join("\n"))
}

fn cargo_test(context: &Context, arguments: &[&str]) -> Outcome {
    cargo_test_with(context, arguments, &[])
}

pub(super) fn cargo_test_with(context: &Context, arguments: &[&str], settings: &[(&str, &str)]) -> Outcome {
    let log = context.log_path(&context.check).with_extension("skipped");
    // Left over from the last run; that it is not there is the usual case.
    let _ = fs::remove_file(&log);
    let mut cargo = context.cargo(arguments);
    cargo.env(crate::SKIP_LOG, &log).envs(settings.iter().copied());
    let run = context.run(&mut cargo, LIMIT);
    let skipped = fs::read_to_string(&log).unwrap_or_default();
    let mut outcome = count::of_cargo_test(&run.output, &skipped, run.ok);
    if outcome.failed > 0 {
        outcome.report = format!("{}\n{}", run.tail(), outcome.report);
    }
    outcome
}

/// Each benchmark once: they measure nothing then, but they run.
pub(super) fn benchmarks(context: &Context) -> Outcome {
    let arguments = ["bench", "--locked", "--package", "tetrad-tests", "--bench", "stages", "--", "--test"];
    context.run(&mut context.cargo(arguments), LIMIT).outcome()
}
