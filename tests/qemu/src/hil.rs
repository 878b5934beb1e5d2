//! Hardware in the loop: a board that a file names is shown the sequences that the file names, in both modes, and has
//! to see what the desktop sees. To this it is all one whether the board is real or QEMU's.

use crate::board_file::{BoardFile, Probe};
use crate::sender::{Failure, Sender};
use crate::tape::{Mode, Tape};
use serialport::SerialPort;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

/// The longest that loading a program may take.
const LOADING: Duration = Duration::from_secs(120);

/// How long a read waits at a time.
const PATIENCE: Duration = Duration::from_millis(20);

/// Shows the board of this file what the file names, and tells of each sequence what was the same.
///
/// # Errors
/// What differs, or what keeps the two from being compared: with the file, and what of it is to be mended.
pub fn run(path: &Path, out: &mut impl Write) -> Result<(), String> {
    let board = BoardFile::read(path)?;
    let wrong = |what: String| format!("{}: {what}", path.display());
    if let Some(probe) = &board.probe {
        load(probe, path).map_err(|what| wrong(format!("probe.run = {:?}: {what}", probe.run)))?;
    }
    let line = open(&board).map_err(wrong)?;
    let mut sender = Sender::new(line);
    for name in &board.sequences {
        for mode in Mode::ALL {
            let tape = Tape { mode, ..board.tape(name).map_err(wrong)? };
            let begun = Instant::now();
            let same = sender.compare(&tape, &tape).map_err(|failure| told(&board, name, mode, &failure));
            let same = same.map_err(wrong)?;
            let line = format!(
                "{name}, {mode:?}: {} pictures, {} packets, the same as on the desktop; shown again {}, noise {}, {:.0} s",
                same.pictures,
                same.packets,
                same.again,
                same.noise,
                begun.elapsed().as_secs_f64()
            );
            writeln!(out, "{line}").map_err(|error| error.to_string())?;
        }
    }
    Ok(())
}

fn told(board: &BoardFile, name: &str, mode: Mode, failure: &Failure) -> String {
    format!("port = {:?}, baud = {}: {name}, {mode:?}: {failure}", board.port, board.baud)
}

fn open(board: &BoardFile) -> Result<Box<dyn SerialPort>, String> {
    let line = serialport::new(board.port.to_string_lossy(), board.baud).timeout(PATIENCE);
    line.open().map_err(|error| {
        format!(
            "port = {:?}: {error}: plug the board in, name its port as the system does (ls /dev/tty*), and end \
             whatever else uses it",
            board.port
        )
    })
}

/// Loads the program, and waits until that is done.
fn load(probe: &Probe, file: &Path) -> Result<(), String> {
    let said = tempfile::NamedTempFile::new().map_err(|error| error.to_string())?;
    let ended = start(probe, file, said.as_file()).and_then(ended);
    let words = || fs::read_to_string(said.path()).unwrap_or_default();
    match ended {
        Ok(Some(status)) if status.success() => Ok(()),
        Ok(Some(status)) => Err(format!("{status}\n{}", words())),
        Ok(None) => Err(format!(
            "not ended after {} s: name a command that loads, starts and ends\n{}",
            LOADING.as_secs(),
            words()
        )),
        Err(error) => Err(format!("{error}: install it, or leave probe out and load the program by hand")),
    }
}

fn start(probe: &Probe, file: &Path, said: &File) -> io::Result<Child> {
    let (program, arguments) = probe.run.split_first().ok_or(io::ErrorKind::InvalidInput)?;
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut command = Command::new(program);
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command.stdout(said.try_clone()?).stderr(said.try_clone()?).spawn()
}

/// How it ended; `None` when it did not, and was ended.
fn ended(mut child: Child) -> io::Result<Option<ExitStatus>> {
    let started = Instant::now();
    while started.elapsed() < LOADING {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        thread::sleep(Duration::from_millis(10));
    }
    child.kill()?;
    child.wait()?;
    Ok(None)
}
