//! `cargo verify`: every check of the project by one command.
//!
//! A check is a name, a line on what it protects, and a function that gives an [`Outcome`]; [`CHECKS`]
//! is the whole list in the order of running. What a check prints goes to `target/verify/NAME.log`;
//! when it fails, the end of that is shown. A check that needs something this machine lacks and that
//! cannot be installed counts as skipped, by name.
//!
//! This part of the crate depends on the standard library alone: it must build and report even when
//! nothing else does.

mod command;
mod count;
mod firmware;
mod fuzz;
mod no_panic;
mod packages;
mod peers;
mod program;
mod stm32h743;
mod style;
mod suite;
mod supply;
mod target;

pub use command::{Context, Run};
pub use count::{Outcome, Skip};

use std::io::Write as _;
use std::time::Instant;

/// One check.
pub struct Check {
    /// What `--only` takes and the log is named after.
    pub name: &'static str,
    /// What it protects, for `--list`.
    pub protects: &'static str,
    /// Whether `--quick` runs it.
    pub quick: bool,
    run: fn(&Context) -> Outcome,
}

/// Every check, in order: what answers fastest and fails most often first.
pub const CHECKS: &[Check] = &[
    Check { name: "fmt", protects: "one layout of the code", quick: true, run: style::fmt },
    Check { name: "clippy", protects: "no lint is left, in code or tests", quick: true, run: style::clippy },
    Check {
        name: "doc",
        protects: "the documentation builds and its links lead somewhere",
        quick: true,
        run: style::doc,
    },
    Check {
        name: "peers",
        protects: "what others wrote and tests talk to is there: PyPI canopen, mcap",
        quick: true,
        run: peers::install,
    },
    Check {
        name: "test",
        protects: "every cargo test of the workspace, each counted",
        quick: true,
        run: suite::workspace,
    },
    Check {
        name: "console",
        protects: "the console in a real browser: a page moves the arm, whatever goes wrong there stops it",
        quick: false,
        run: suite::console,
    },
    Check {
        name: "golden-release",
        protects: "a release build gives the bits of a debug build",
        quick: false,
        run: suite::golden_release,
    },
    Check {
        name: "arm-sequences",
        protects: "no sequence of commands, losses and stops makes the arm jump: all 100,000 of them",
        quick: false,
        run: suite::arm_sequences,
    },
    Check {
        name: "two-views",
        protects: "core without `eight-views`, as a microcontroller links it, keeps the promises of the hand",
        quick: false,
        run: suite::two_views,
    },
    Check {
        name: "benchmarks",
        protects: "every benchmark still runs: each once, without figures",
        quick: false,
        run: suite::benchmarks,
    },
    Check {
        name: "target-build",
        protects: "core builds for thumbv7em-none-eabihf without std or alloc",
        quick: false,
        run: target::build,
    },
    Check {
        name: "target-build-defmt",
        protects: "core builds for thumbv7em-none-eabihf with the feature defmt",
        quick: false,
        run: target::build_defmt,
    },
    Check {
        name: "target-clippy",
        protects: "no lint is left in core as built for the target",
        quick: false,
        run: target::clippy,
    },
    Check {
        name: "no-panic",
        protects: "no panic and no allocation is left behind core's entry points: linked for the target",
        quick: false,
        run: no_panic::check,
    },
    Check {
        name: "firmware-clippy",
        protects: "no lint is left in the firmware of any board",
        quick: false,
        run: firmware::clippy,
    },
    Check {
        name: "firmware-qemu",
        protects: "the same pictures give the same packets on both boards of QEMU, within the figures' ceilings",
        quick: false,
        run: firmware::qemu,
    },
    Check {
        name: "firmware-test",
        protects: "the firmware's parts that know no board: sensor, button, CAN payloads, what feeds the watchdog",
        quick: false,
        run: stm32h743::desktop,
    },
    Check {
        name: "firmware-stm32h743",
        protects: "the program for the OpenMV Cam H7 builds, and lies in the right memories; it has not run there",
        quick: false,
        run: stm32h743::build,
    },
    Check {
        name: "deny-licences",
        protects: "every dependency's licence is one we may ship",
        quick: false,
        run: supply::licences,
    },
    Check {
        name: "deny-bans",
        protects: "no banned or needlessly doubled dependency",
        quick: false,
        run: supply::bans,
    },
    Check {
        name: "deny-sources",
        protects: "dependencies come from crates.io alone",
        quick: false,
        run: supply::sources,
    },
    Check {
        name: "deny-advisories",
        protects: "no dependency has a published vulnerability",
        quick: false,
        run: supply::advisories,
    },
    Check {
        name: "fuzz-frame",
        protects: "no bytes, size, stride or format make a frame panic",
        quick: false,
        run: fuzz::frame,
    },
    Check {
        name: "fuzz-packet",
        protects: "no bytes from a cable make the decoder panic",
        quick: false,
        run: fuzz::packet,
    },
    Check {
        name: "fuzz-link",
        protects: "no bytes from a peer make the link panic, or let an old packet through",
        quick: false,
        run: fuzz::link,
    },
    Check {
        name: "fuzz-node",
        protects: "no bytes from a smart camera's serial port make the operator panic, or hide what comes after",
        quick: false,
        run: fuzz::node,
    },
    Check {
        name: "fuzz-colours",
        protects: "no colours.toml makes its parser panic",
        quick: false,
        run: fuzz::colours,
    },
    Check {
        name: "fuzz-session",
        protects: "no bytes in a session's file make its reader panic",
        quick: false,
        run: fuzz::session,
    },
    Check {
        name: "demo",
        protects: "the main job runs from start to end without hardware",
        quick: false,
        run: program::demo,
    },
    Check {
        name: "stations",
        protects: "four stations over loopback: the arm follows, no stranger gets in, deaths stop it",
        quick: false,
        run: program::stations,
    },
    Check {
        name: "footage",
        protects: "labelled balls in real footage are found, and nothing else is",
        quick: false,
        run: program::footage,
    },
    Check {
        name: "readme",
        protects: "the commands that README names exist",
        quick: false,
        run: program::readme,
    },
];

/// Runs `checks` in order, printing each, and gives their sum.
#[must_use]
pub fn run(context: &Context, checks: &[&Check]) -> Outcome {
    let mut total = Outcome::default();
    for check in checks {
        print!("{:.<24} ", format!("{} ", check.name));
        // The name of a check that takes minutes is to be seen while it runs.
        let _ = std::io::stdout().flush();
        let started = Instant::now();
        let outcome = (check.run)(&context.named(check.name));
        println!("{} ({:.1} s)", outcome.summary(), started.elapsed().as_secs_f64());
        for line in outcome.report.lines() {
            println!("    {line}");
        }
        if outcome.failed > 0 {
            println!("    the whole of it: {}", context.log_path(check.name).display());
        }
        total.add(outcome);
    }
    total
}
