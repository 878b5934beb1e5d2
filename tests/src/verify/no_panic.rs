//! The programs of `tests/no-panic`: each calls one part of core and links only when nothing in it
//! can panic and nothing allocates.

use super::target::Toolchain;
use super::{Context, Outcome};
use std::fs;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(900);

/// The symbol that the panic handler of the programs wants and nobody has.
const MISSING_SYMBOL: &str = "a_panic_path_is_left";

/// What chooses how many cameras core takes: as many as on the desktop, as many as on a microcontroller.
const VIEWS: [&[&str]; 2] = [&[], &["--no-default-features"]];

/// The program that does panic: when it links, this check checks nothing.
const CANARY: &str = "canary";

pub(super) fn check(context: &Context) -> Outcome {
    let toolchain = match Toolchain::find(context) {
        Ok(toolchain) => toolchain,
        Err(missing) => return Outcome::skip(&context.check, missing),
    };
    let names = match programs(context) {
        Ok(names) => names,
        Err(failure) => return Outcome::fail(failure),
    };
    let build = |arguments: &[&str]| {
        let base = ["build", "--locked", "--release", "--manifest-path", "tests/no-panic/Cargo.toml"];
        let mut cargo = toolchain.cargo(context, &base);
        cargo.args(arguments).env("CARGO_TARGET_DIR", context.target.join("no-panic"));
        context.run(&mut cargo, LIMIT)
    };

    let mut outcome = Outcome::default();
    for views in VIEWS {
        let all = build(&[&["--bins", "--keep-going"], views].concat());
        let before = outcome.failed;
        for name in &names {
            let failed = all.output.contains(&format!("`tetrad-no-panic` (bin \"{name}\")"));
            outcome.add(if failed { Outcome::fail("") } else { Outcome::pass() });
            if failed {
                outcome.report.push_str(&format!("a panic or an allocation is left in {name} {views:?}\n"));
            }
        }
        if !all.ok && outcome.failed == before {
            return Outcome::fail(all.tail());
        }
    }

    let canary = build(&["--bin", CANARY, "--features", CANARY]);
    if canary.ok || !canary.output.contains(MISSING_SYMBOL) {
        outcome.add(Outcome::fail(""));
        outcome.report.push_str("the program that panics did not fail to link: the check is blind\n");
    } else {
        outcome.add(Outcome::pass());
    }
    outcome
}

/// The names of the programs, without the one that is meant to fail.
fn programs(context: &Context) -> Result<Vec<String>, String> {
    let folder = context.repository.join("tests/no-panic/src/bin");
    let files = fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut names: Vec<String> = files
        .flatten()
        .filter_map(|file| file.path().file_stem().map(|stem| stem.to_string_lossy().into_owned()))
        .filter(|name| name != CANARY)
        .collect();
    names.sort();
    if names.is_empty() { Err(format!("{}: no programs", folder.display())) } else { Ok(names) }
}
