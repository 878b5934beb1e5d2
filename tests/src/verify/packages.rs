//! What checks need beyond Rust: installed where that is possible, named where it is not.

use super::Context;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

const APT_LIMIT: Duration = Duration::from_secs(600);
const INSTALL_LIMIT: Duration = Duration::from_secs(1200);

/// Makes sure that Debian `packages` are installed.
///
/// # Errors
/// What is missing and how to install it, when this is not a Debian, or we are not root, or the
/// archive cannot be reached.
pub(super) fn debian(context: &Context, packages: &[&str]) -> Result<(), String> {
    let missing: Vec<&str> = packages.iter().copied().filter(|package| !installed(package)).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let install = || {
        let mut apt = Command::new("apt-get");
        apt.args(["install", "--yes", "--no-install-recommends"]).args(&missing);
        context.run(apt.env("DEBIAN_FRONTEND", "noninteractive"), APT_LIMIT).ok
    };
    let reached = is_root()
        && (install() || (context.run(Command::new("apt-get").arg("update"), APT_LIMIT).ok && install()));
    if reached {
        return Ok(());
    }
    Err(format!("missing: apt-get install {}", missing.join(" ")))
}

fn installed(package: &str) -> bool {
    let status =
        Command::new("dpkg-query").args(["--show", "--showformat=${db:Status-Status}", package]).output();
    status.is_ok_and(|output| output.stdout.starts_with(b"installed"))
}

fn is_root() -> bool {
    Command::new("id").arg("--user").output().is_ok_and(|output| output.stdout == b"0\n")
}

/// A cargo subcommand: the one of the user, or one installed into `target/tools`.
///
/// # Errors
/// What is missing and how to install it, when it is not here and crates.io cannot be reached.
pub(super) fn cargo_tool(context: &Context, name: &str, version: &str) -> Result<PathBuf, String> {
    let tools = context.target.join("tools");
    for candidate in [tools.join("bin").join(name), PathBuf::from(name)] {
        if Command::new(&candidate).arg("--version").output().is_ok_and(|output| output.status.success()) {
            return Ok(candidate);
        }
    }
    let mut install = context.cargo(["install", "--locked", "--version", version, "--root"]);
    // Its own target directory, so that cleaning up after it is cleaning up one folder.
    install.arg(&tools).arg("--target-dir").arg(tools.join("build")).arg(name);
    // It runs for a second or two: optimised, cargo-deny takes 100 s to build; so, 35.
    install.envs([
        ("CARGO_PROFILE_RELEASE_OPT_LEVEL", "0"),
        ("CARGO_PROFILE_RELEASE_LTO", "off"),
        ("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16"),
    ]);
    if context.run(&mut install, INSTALL_LIMIT).ok {
        return Ok(tools.join("bin").join(name));
    }
    Err(format!("missing: cargo install --locked {name}"))
}
