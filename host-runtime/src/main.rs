//! The `tetrad` program: parse, run, map to an exit code.

use clap::Parser as _;
use std::io::Write as _;
use std::process::ExitCode;
use tetrad::cli::{self, Cli};
use tetrad::exit::Exit;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        // wrong usage ends here with code 2, help and version with 0 once they are printed
        Err(usage) => return usage_exit(&usage),
    };
    let exit = match cli::run(cli) {
        Ok(()) => Exit::Done,
        Err(failure) => {
            // where stderr is closed, the exit code still says it
            let _ = writeln!(std::io::stderr(), "{failure}");
            failure.exit
        }
    };
    ExitCode::from(exit.code())
}

fn usage_exit(usage: &clap::Error) -> ExitCode {
    let flushed = usage.print().and_then(|()| std::io::stdout().flush());
    let unprinted = flushed.is_err_and(|error| error.kind() != std::io::ErrorKind::BrokenPipe);
    let exit = match (usage.use_stderr(), unprinted) {
        (true, _) => Exit::BadArguments,
        (false, true) => Exit::Failed,
        (false, false) => Exit::Done,
    };
    ExitCode::from(exit.code())
}
