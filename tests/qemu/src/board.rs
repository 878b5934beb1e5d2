//! What a board makes of a tape, in QEMU.

use crate::tape::Tape;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, io, thread};

/// Names the folder of the firmware's programs, one folder a build; `cargo verify` sets it.
pub const PROGRAMS: &str = "TETRAD_FIRMWARE";

/// The longest a run may take.
const LIMIT: Duration = Duration::from_secs(300);

/// One instruction counts as 2^6 ns, and nobody waits for virtual time to pass.
pub(crate) const FAST: &str = "shift=6,sleep=off";

/// A board of QEMU's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// Cortex-M4F.
    An386,
    /// Cortex-M7.
    An500,
}

impl Board {
    const fn machine(self) -> &'static str {
        match self {
            Self::An386 => "mps2-an386",
            Self::An500 => "mps2-an500",
        }
    }
}

/// What the programs were built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Build {
    /// Single precision in the processor, double in a library. It runs on both boards.
    CortexM4F,
    /// Both in the processor.
    CortexM7,
    /// As the first, with a log.
    Logging,
}

impl Build {
    /// Both that are measured.
    pub const ALL: [Self; 2] = [Self::CortexM4F, Self::CortexM7];

    /// The path of a program.
    ///
    /// # Errors
    /// Nobody has said where the programs are.
    pub fn program(self, name: &str) -> io::Result<PathBuf> {
        Ok(self.folder()?.join(name))
    }

    /// The paths of all its programs.
    ///
    /// # Errors
    /// As [`Build::program`], or there is no such folder.
    pub fn programs(self) -> io::Result<Vec<PathBuf>> {
        fs::read_dir(self.folder()?)?.map(|entry| Ok(entry?.path())).collect()
    }

    fn folder(self) -> io::Result<PathBuf> {
        let folder = match self {
            Self::CortexM4F => "cortex-m4f",
            Self::CortexM7 => "cortex-m7",
            Self::Logging => "logging",
        };
        Ok(programs()?.join(folder))
    }
}

/// A build on a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// What runs.
    pub build: Build,
    /// Where.
    pub board: Board,
}

impl Target {
    /// Each build on the board of its processor.
    pub const OWN: [Self; 2] = [
        Self { build: Build::CortexM4F, board: Board::An386 },
        Self { build: Build::CortexM7, board: Board::An500 },
    ];

    /// What is not built for the M7 on a board that has one.
    pub const FOREIGN: Self = Self { build: Build::CortexM4F, board: Board::An500 };

    /// What logs.
    pub const LOGGING: Self = Self { build: Build::Logging, board: Board::An386 };

    /// The bytes that the smart camera wrote to its serial line, and what it said on standard error.
    ///
    /// # Errors
    /// There is no such program or no QEMU, or the run did not end well; with what was said.
    pub fn play(self, tape: &Tape) -> io::Result<(Vec<u8>, String)> {
        self.played(tape, "mps2-camera", "line")
    }

    /// The bytes that the hand and the arm answered.
    ///
    /// # Errors
    /// As [`Target::play`].
    pub fn answers(self, tape: &Tape) -> io::Result<Vec<u8>> {
        self.played(tape, "mps2-probes", "tetrad.answers").map(|(answers, _)| answers)
    }

    /// What a program wrote to a file, and what it said.
    fn played(self, tape: &Tape, program: &str, written: &str) -> io::Result<(Vec<u8>, String)> {
        let folder = tempfile::tempdir()?;
        fs::write(folder.path().join("tetrad.tape"), tape.bytes())?;
        let said = self.run(program, folder.path(), FAST)?;
        Ok((fs::read(folder.path().join(written))?, said))
    }

    /// The bytes that the smart camera wrote to its serial line, and those of its log.
    ///
    /// # Errors
    /// As [`Target::play`].
    pub fn play_logging(self, tape: &Tape) -> io::Result<(Vec<u8>, Vec<u8>)> {
        let folder = tempfile::tempdir()?;
        fs::write(folder.path().join("tetrad.tape"), tape.bytes())?;
        self.run("mps2-camera", folder.path(), FAST)?;
        Ok((fs::read(folder.path().join("line"))?, fs::read(folder.path().join("log"))?))
    }

    /// Runs a program in a folder; what it said on both streams.
    ///
    /// # Errors
    /// As [`Target::play`].
    pub fn run(self, program: &str, folder: &Path, icount: &str) -> io::Result<String> {
        let said_path = folder.join("said");
        let mut qemu = self.qemu(program, folder, icount, "file:line")?;
        let mut child = qemu.spawn()?;
        let started = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break status;
            }
            if started.elapsed() > LIMIT {
                child.kill()?;
                child.wait()?;
                return Err(io::Error::other(format!("{program} did not end within {} s", LIMIT.as_secs())));
            }
            thread::sleep(Duration::from_millis(5));
        };
        let said = fs::read_to_string(said_path)?;
        if status.success() {
            Ok(said)
        } else {
            Err(io::Error::other(format!("{program}: {status}\n{said}")))
        }
    }

    /// QEMU with a program, in a folder whose file `said` gets what it says; `serial` is its serial line.
    pub(crate) fn qemu(
        self,
        program: &str,
        folder: &Path,
        icount: &str,
        serial: &str,
    ) -> io::Result<Command> {
        let said = fs::File::create(folder.join("said"))?;
        let mut qemu = Command::new("qemu-system-arm");
        qemu.args([
            "-machine",
            self.board.machine(),
            "-display",
            "none",
            "-monitor",
            "none",
            "-icount",
            icount,
        ]);
        qemu.args(["-semihosting-config", "enable=on,target=native"]);
        // the serial line, what stands for a CAN bus, and the log
        qemu.args(["-serial", serial, "-serial", "file:bus", "-serial", "file:log", "-kernel"]);
        qemu.arg(self.build.program(program)?).current_dir(folder);
        qemu.stdin(Stdio::null()).stdout(said.try_clone()?).stderr(said);
        Ok(qemu)
    }
}

/// The folder of the builds.
fn programs() -> io::Result<PathBuf> {
    env::var_os(PROGRAMS).map(PathBuf::from).ok_or_else(|| {
        io::Error::other(format!("{PROGRAMS} is not set: run `cargo verify --only firmware-qemu`"))
    })
}
