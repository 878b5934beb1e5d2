//! Building core for the microcontroller, with whichever compiler here can.
//!
//! With rustup it is the usual way: `rustup target add thumbv7em-none-eabihf`. Debian ships no
//! library for that target, but its sources: then `core` is built from them once into a sysroot of
//! our own, and everything else is a plain stable build on it. That sysroot has no `alloc` at all.

use super::packages;
use super::{Context, Outcome, Run};
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// The target of the firmware: Cortex-M4F and M7.
pub(super) const TRIPLE: &str = "thumbv7em-none-eabihf";

/// Set to anything: use Debian's compiler even where rustup has the target.
const PREFER_DEBIAN: &str = "TETRAD_DEBIAN_RUST";

/// The oldest compiler that builds this: `rust-version` of every manifest here.
const OLDEST: &str = env!("CARGO_PKG_RUST_VERSION");

const LIMIT: Duration = Duration::from_secs(900);

/// rustc-web is Debian's name for the Rust that follows upstream.
const DEBIAN_PACKAGES: [&str; 5] = ["rustc-web", "cargo-web", "rust-web-src", "rust-web-clippy", "lld"];

/// A compiler that can build for [`TRIPLE`].
pub(super) enum Toolchain {
    /// The one that runs this program.
    Own,
    /// Debian's, with this sysroot.
    Debian(PathBuf),
}

impl Toolchain {
    /// The toolchain of this machine, installed if need be.
    ///
    /// # Errors
    /// What is missing.
    pub(super) fn find(context: &Context) -> Result<Self, String> {
        if std::env::var_os(PREFER_DEBIAN).is_none() && has_target() {
            return Ok(Self::Own);
        }
        let mut rustup = Command::new("rustup");
        if std::env::var_os(PREFER_DEBIAN).is_none()
            && context.run(rustup.args(["target", "add", TRIPLE]), LIMIT).ok
            && has_target()
        {
            return Ok(Self::Own);
        }
        packages::debian(context, &DEBIAN_PACKAGES)
            .map_err(|missing| format!("{missing} (or: rustup target add {TRIPLE})"))?;
        let release = debian_release()?;
        if !is_recent_enough(&release, OLDEST) {
            let oldest = OLDEST;
            return Err(format!(
                "Debian's rustc-web is {release}, and this needs {oldest} or later: rustup target add {TRIPLE}"
            ));
        }
        debian_sysroot(context, &release).map(Self::Debian)
    }

    /// Cargo with `arguments`, set up for [`TRIPLE`] and so for every processor of it.
    pub(super) fn cargo(&self, context: &Context, arguments: &[&str]) -> Command {
        self.cargo_for(context, arguments, None)
    }

    /// The same for one processor alone, where rustc's name for it is given.
    pub(super) fn cargo_for(
        &self,
        context: &Context,
        arguments: &[&str],
        processor: Option<&str>,
    ) -> Command {
        let (mut cargo, base) = match self {
            Self::Own => (context.cargo(arguments), std::env::var("RUSTFLAGS").ok()),
            Self::Debian(sysroot) => {
                let mut cargo = debian_cargo(context, "debian");
                cargo.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "ld.lld");
                cargo.args(arguments);
                (cargo, Some(format!("--sysroot {}", sysroot.display())))
            }
        };
        let flag = processor.map(|processor| format!("-Ctarget-cpu={processor}"));
        let flags: Vec<String> = base.into_iter().chain(flag).collect();
        if !flags.is_empty() {
            cargo.env("RUSTFLAGS", flags.join(" "));
        }
        cargo.args(["--target", TRIPLE]);
        cargo
    }
}

fn has_target() -> bool {
    let Ok(output) = Command::new("rustc").args(["--print", "sysroot"]).output() else { return false };
    let sysroot = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    let library = sysroot.join("lib/rustlib").join(TRIPLE).join("lib");
    fs::read_dir(library).is_ok_and(|files| {
        files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
    })
}

/// Debian's cargo, kept apart from the toolchain that runs this program.
fn debian_cargo(context: &Context, target: &str) -> Command {
    let mut cargo = Command::new("/usr/bin/cargo");
    for inherited in ["RUSTUP_TOOLCHAIN", "CARGO", "RUSTC_WRAPPER", "RUSTDOC", "CARGO_ENCODED_RUSTFLAGS"] {
        cargo.env_remove(inherited);
    }
    // cargo-clippy looks for its driver and for cargo on the path.
    let mut path = OsString::from("/usr/bin:");
    path.push(std::env::var_os("PATH").unwrap_or_default());
    cargo.env("PATH", path).env("RUSTC", "/usr/bin/rustc");
    cargo.env("CARGO_TARGET_DIR", context.target.join(target)).current_dir(&context.repository);
    cargo
}

/// The version of Debian's compiler, as "1.85.0".
fn debian_release() -> Result<String, String> {
    let version =
        Command::new("/usr/bin/rustc").arg("-vV").output().map_err(|e| format!("/usr/bin/rustc: {e}"))?;
    let version = String::from_utf8_lossy(&version.stdout);
    let release = version.lines().find_map(|line| line.strip_prefix("release: "));
    release.map(str::to_owned).ok_or_else(|| "/usr/bin/rustc does not tell its version".to_owned())
}

/// Whether a compiler of this version, "1.85.0", is at least `oldest`, "1.89".
fn is_recent_enough(release: &str, oldest: &str) -> bool {
    let numbers = |version: &str| -> Vec<u32> {
        version.split(['.', '-']).map_while(|number| number.parse().ok()).collect()
    };
    numbers(release) >= numbers(oldest)
}

/// Builds `core` from Debian's sources, once for each version of the compiler.
fn debian_sysroot(context: &Context, release: &str) -> Result<PathBuf, String> {
    let sysroot = context.target.join("debian").join(format!("sysroot-{release}"));
    let done = sysroot.join("complete");
    if done.is_file() {
        return Ok(sysroot);
    }
    let build = || -> io::Result<Result<(), String>> {
        let package = context.target.join("debian/mkcore");
        write_empty_library(&package)?;
        let mut cargo = debian_cargo(context, "debian/mkcore/target");
        // Building core from source is what needs the unstable flag; its users are built without.
        cargo.env("RUSTC_BOOTSTRAP", "1").env("RUSTFLAGS", "-Cembed-bitcode=yes").current_dir(&package);
        let run =
            context.run(cargo.args(["build", "--release", "-Zbuild-std=core", "--target", TRIPLE]), LIMIT);
        if !run.ok {
            return Ok(Err(run.tail()));
        }
        let library = sysroot.join("lib/rustlib").join(TRIPLE).join("lib");
        fs::create_dir_all(&library)?;
        for file in fs::read_dir(package.join("target").join(TRIPLE).join("release/deps"))? {
            let file = file?;
            let name = file.file_name().to_string_lossy().into_owned();
            if name.ends_with(".rlib")
                && (name.starts_with("libcore-") || name.starts_with("libcompiler_builtins-"))
            {
                fs::copy(file.path(), library.join(name))?;
            }
        }
        fs::write(&done, release)?;
        Ok(Ok(()))
    };
    build().map_err(|e| format!("{}: {e}", sysroot.display()))??;
    Ok(sysroot)
}

fn write_empty_library(package: &Path) -> io::Result<()> {
    fs::create_dir_all(package.join("src"))?;
    fs::write(package.join("src/lib.rs"), "#![no_std]\n")?;
    fs::write(
        package.join("Cargo.toml"),
        "[package]\nname = \"mkcore\"\nversion = \"0.0.0\"\nedition = \"2024\"\n[workspace]\n\
         [profile.release]\npanic = \"abort\"\ncodegen-units = 1\n",
    )
}

pub(super) fn build(context: &Context) -> Outcome {
    with_toolchain(context, |cargo| {
        cargo(&["build", "--locked", "--release", "--package", "tetrad-core"], &[])
    })
}

pub(super) fn build_defmt(context: &Context) -> Outcome {
    with_toolchain(context, |cargo| {
        cargo(&["build", "--locked", "--release", "--package", "tetrad-core", "--features", "defmt"], &[])
    })
}

/// Core, and the programs that are linked for the target.
pub(super) fn clippy(context: &Context) -> Outcome {
    let lints = ["--", "--deny", "warnings"];
    with_toolchain(context, |cargo| {
        let core = cargo(&["clippy", "--locked", "--package", "tetrad-core", "--features", "defmt"], &lints);
        if !core.ok {
            return core;
        }
        let folder = context.target.join("no-panic").display().to_string();
        let manifest = ["--manifest-path", "tests/no-panic/Cargo.toml", "--target-dir", &folder];
        cargo(&[&["clippy", "--locked", "--bins"][..], &manifest].concat(), &lints)
    })
}

/// Runs cargo with arguments before and after those that choose the target.
type Cargo<'a> = dyn Fn(&[&str], &[&str]) -> Run + 'a;

fn with_toolchain(context: &Context, work: impl FnOnce(&Cargo<'_>) -> Run) -> Outcome {
    match Toolchain::find(context) {
        Err(missing) => Outcome::skip(&context.check, missing),
        Ok(toolchain) => {
            let cargo = |before: &[&str], after: &[&str]| {
                context.run(toolchain.cargo(context, before).args(after), LIMIT)
            };
            work(&cargo).outcome()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_compiler_is_told_from_one_that_will_do() {
        assert!(is_recent_enough("1.89.0", "1.89"));
        assert!(is_recent_enough("1.100.1-nightly", "1.89"));
        assert!(!is_recent_enough("1.85.0", "1.89"));
        assert!(!is_recent_enough("unknown", "1.89"));
    }
}
