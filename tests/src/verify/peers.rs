//! Installs the programs of others that tests talk to.

use super::{Context, Outcome};
use crate::peers::{REQUIREMENTS, environment, installed, python_in};
use std::fs;
use std::process::Command;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(300);

pub(super) fn install(context: &Context) -> Outcome {
    let environment = environment(&context.target);
    let stamp = installed(&environment);
    if fs::read_to_string(&stamp).is_ok_and(|text| text == REQUIREMENTS) {
        return Outcome::pass();
    }
    if Command::new("python3")
        .args(["-c", "import venv, ensurepip"])
        .output()
        .is_ok_and(|run| run.status.success())
    {
        let mut venv = Command::new("python3");
        let made = context.run(venv.args(["-m", "venv"]).arg(&environment), LIMIT);
        if !made.ok {
            return made.outcome();
        }
        let mut pip = Command::new(python_in(&environment));
        pip.args(["-m", "pip", "install", "--quiet", "--requirement", "tests/peers/requirements.txt"]);
        let run = context.run(pip.current_dir(&context.repository), LIMIT);
        if !run.ok {
            // the tests that need it are skipped by name as well
            return Outcome::skip(&context.check, format!("pip cannot install them here: {}", run.failure));
        }
        return match fs::write(&stamp, REQUIREMENTS) {
            Ok(()) => Outcome::pass(),
            Err(error) => Outcome::fail(format!("{}: {error}", stamp.display())),
        };
    }
    Outcome::skip(&context.check, "missing: python3 with venv")
}
