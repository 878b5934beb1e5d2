//! The firmware: built for its target, and run on QEMU's boards.

use super::target::{TRIPLE, Toolchain};
use super::{Context, Outcome, Run, packages, program, suite};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use std::{fs, io};

const LIMIT: Duration = Duration::from_secs(900);

pub(super) const MANIFEST: &str = "firmware/Cargo.toml";

/// Every board's features.
const BOARDS: [&str; 4] = ["mps2", "mps2,defmt", "stm32h743", "stm32h743,defmt"];

/// What is built of the firmware, to be run or measured.
struct Build {
    /// The folder for its programs.
    folder: &'static str,
    /// rustc's name of the processor, where it is not built for all of the target.
    processor: Option<&'static str>,
    /// Where it is another level than that of firmware/Cargo.toml, which says for what.
    optimisation: Option<&'static str>,
    programs: &'static [&'static str],
    /// Whether they log.
    logs: bool,
}

/// Camera and slave for each processor of QEMU's boards. What is built for the M4F runs on the M7 too, which
/// computes in double precision besides; poses and the arm are measured for the M7 alone, and compared with the
/// desktop on both, built for size and for speed.
const BUILDS: [Build; 4] = [
    Build {
        folder: "cortex-m4f",
        processor: None,
        optimisation: None,
        programs: &ALL_BUT_THE_HAND,
        logs: false,
    },
    Build { folder: "logging", processor: None, optimisation: None, programs: &["mps2-camera"], logs: true },
    Build {
        folder: "cortex-m7",
        processor: Some("cortex-m7"),
        optimisation: None,
        programs: &CAMERA,
        logs: false,
    },
    Build {
        folder: "cortex-m7",
        processor: Some("cortex-m7"),
        optimisation: Some("3"),
        programs: &["mps2-hand", "mps2-probes", "mps2-slave"],
        logs: false,
    },
];

const CAMERA: [&str; 4] = ["mps2-camera", "mps2-streamed", "mps2-figures", "core-alone"];

const ALL_BUT_THE_HAND: [&str; 6] =
    ["mps2-camera", "mps2-streamed", "mps2-figures", "core-alone", "mps2-probes", "mps2-slave"];

impl Build {
    fn run(&self, context: &Context, toolchain: &Toolchain) -> Run {
        let base = ["build", "--locked", "--release", "--manifest-path", MANIFEST, "--features", "mps2"];
        let mut cargo = toolchain.cargo_for(context, &base, self.processor);
        cargo.args(self.programs.iter().flat_map(|name| ["--bin", name]));
        if self.logs {
            cargo.args(["--features", "defmt"]).env("DEFMT_LOG", "info");
        }
        if let Some(level) = self.optimisation {
            cargo.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", level);
        }
        let target = context.target.join("firmware");
        let mut run = context.run(cargo.env("CARGO_TARGET_DIR", &target), LIMIT);
        if run.ok
            && let Err(error) = self.keep(&target.join(TRIPLE).join("release"), &programs(context))
        {
            (run.ok, run.failure) = (false, format!("{}: {error}", self.folder));
        }
        run
    }

    /// Cargo has one place for the programs of all builds: they are kept before the next are built.
    fn keep(&self, built: &Path, programs: &Path) -> io::Result<()> {
        let folder = programs.join(self.folder);
        fs::create_dir_all(&folder)?;
        self.programs.iter().try_for_each(|name| fs::copy(built.join(name), folder.join(name)).map(|_| ()))
    }
}

fn programs(context: &Context) -> PathBuf {
    context.target.join("firmware").join("programs")
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
    for build in BUILDS {
        let built = build.run(context, &toolchain);
        if !built.ok {
            return built.outcome();
        }
    }
    // it tracks through a board
    let program = match program::build(context) {
        Ok(program) => program,
        Err(failure) => return failure,
    };
    let programs = programs(context);
    let (Some(folder), Some(program)) = (programs.to_str(), program.to_str()) else {
        return Outcome::fail(format!("{}: the path has to be UTF-8", programs.display()));
    };
    let arguments =
        ["test", "--locked", "--package", "tetrad-qemu", "--features", "boards", "--no-fail-fast"];
    let figures = context.log_path(&context.check).with_extension("figures");
    // Left over from the last run; that it is not there is the usual case.
    let _ = fs::remove_file(&figures);
    let told = [
        ("TETRAD_FIRMWARE", folder),
        ("TETRAD_PROGRAM", program),
        ("TETRAD_FIGURES", figures.to_str().unwrap_or_default()),
    ];
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
