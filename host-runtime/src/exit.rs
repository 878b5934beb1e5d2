//! How a command ends: the exit codes scripts depend on, and the failure that carries one.
//!
//! Library code returns a [`Failure`]; only `main` prints it and ends the process.

use std::borrow::Cow;
use std::fmt;

/// The exit codes of `tetrad`. Stable: scripts depend on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// The command did what was asked.
    Done = 0,
    /// The work was begun and could not be finished.
    Failed = 1,
    /// An argument or a configuration file is wrong; nothing was begun.
    BadArguments = 2,
    /// A camera, a robot or a link went away.
    DeviceLost = 3,
    /// A safety rule stopped it.
    Safety = 4,
}

impl Exit {
    /// The number given to the operating system.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }
}

/// A command that did not end well: the exit code, the cause, and what would mend it.
///
/// Its `Display` is the whole message for a person: the error, its causes one a line, and the help.
#[derive(Debug)]
pub struct Failure {
    /// How the process ends.
    pub exit: Exit,
    /// What went wrong, with its chain of causes.
    pub cause: anyhow::Error,
    /// What would mend it, where the cause does not say so itself.
    pub help: Option<Cow<'static, str>>,
}

impl Failure {
    /// A failure with this exit code.
    pub fn new(exit: Exit, cause: impl Into<anyhow::Error>) -> Self {
        Self { exit, cause: cause.into(), help: None }
    }

    /// Wrong arguments or configuration, said in words.
    pub fn bad_arguments(message: impl fmt::Display + fmt::Debug + Send + Sync + 'static) -> Self {
        Self::new(Exit::BadArguments, anyhow::Error::msg(message))
    }

    /// Adds what would mend it.
    #[must_use]
    pub fn help(mut self, help: impl Into<Cow<'static, str>>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.cause)?;
        for cause in self.cause.chain().skip(1) {
            write!(f, "\n  because: {cause}")?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

/// Turns any error into a [`Failure`] where the exit code is known.
pub trait OrExit<T> {
    /// The value, or a failure with this exit code.
    ///
    /// # Errors
    /// The error it was called on, with the exit code.
    fn or_exit(self, exit: Exit) -> Result<T, Failure>;
}

impl<T, E: Into<anyhow::Error>> OrExit<T> for Result<T, E> {
    fn or_exit(self, exit: Exit) -> Result<T, Failure> {
        self.map_err(|cause| Failure::new(exit, cause))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context as _;

    #[test]
    fn the_message_has_the_error_its_causes_and_the_help() {
        let cause =
            Err::<(), _>(std::io::Error::other("disk full")).context("cannot write pose.csv").unwrap_err();
        let failure = Failure::new(Exit::Failed, cause).help("free some space");
        assert_eq!(
            failure.to_string(),
            "error: cannot write pose.csv\n  because: disk full\n  help: free some space"
        );
    }

    #[test]
    fn the_codes_are_the_published_ones() {
        let all = [Exit::Done, Exit::Failed, Exit::BadArguments, Exit::DeviceLost, Exit::Safety];
        assert_eq!(all.map(Exit::code), [0, 1, 2, 3, 4]);
    }
}
