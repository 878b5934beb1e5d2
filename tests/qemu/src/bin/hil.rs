//! Hardware in the loop: `cargo run --release --package tetrad-qemu --bin hil -- board.toml`. firmware/README.md says
//! what the file holds.
//!
//! Exit codes: 0 the board sees what the desktop sees, 1 it does not or cannot be asked, 2 no file was named.

use std::path::Path;
use std::process::ExitCode;
use std::{env, io};

fn main() -> ExitCode {
    let mut arguments = env::args_os().skip(1);
    let (Some(file), None) = (arguments.next(), arguments.next()) else {
        eprintln!("hil BOARD.toml: compares the board of this file with the desktop, bit for bit");
        return ExitCode::from(2);
    };
    match tetrad_qemu::hil::run(Path::new(&file), &mut io::stdout()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(what) => {
            eprintln!("{what}");
            ExitCode::FAILURE
        }
    }
}
