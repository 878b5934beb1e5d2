//! The `tetrad` program: parse, run, map to an exit code.

use clap::Parser as _;
use std::process::ExitCode;
use tetrad::cli::{self, Cli};
use tetrad::exit::Exit;

fn main() -> ExitCode {
    // wrong usage ends here with code 2, help and version with 0
    let exit = match cli::run(Cli::parse()) {
        Ok(()) => Exit::Done,
        Err(failure) => {
            eprintln!("{failure}");
            failure.exit
        }
    };
    ExitCode::from(exit.code())
}
