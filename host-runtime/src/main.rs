//! The `tetrad` program: parse, run, map to an exit code.

use clap::Parser as _;
use std::io::Write as _;
use std::process::ExitCode;
use tetrad::cli::{self, Cli};
use tetrad::exit::Exit;

fn main() -> ExitCode {
    // wrong usage ends here with code 2, help and version with 0
    let exit = match cli::run(Cli::parse()) {
        Ok(()) => Exit::Done,
        Err(failure) => {
            // where stderr is closed, the exit code still says it
            let _ = writeln!(std::io::stderr(), "{failure}");
            failure.exit
        }
    };
    ExitCode::from(exit.code())
}
