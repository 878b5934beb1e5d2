//! Why a source cannot deliver, and the exit code that deserves.

use std::path::{Path, PathBuf};

use crate::exit::{Exit, Failure};

/// Why there is no (next) picture. Every message names the argument, file or device and says what
/// would mend it.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// The SRC argument, or something given with it, makes no sense.
    #[error("{spec}: {reason}")]
    BadArgument {
        /// SRC as given.
        spec: String,
        /// What is wrong, and what to give instead.
        reason: String,
    },
    /// A file cannot be read or does not hold what it should.
    #[error("{}: {reason}", path.display())]
    BadInput {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what would mend it.
        reason: String,
    },
    /// A recorded session cannot be read.
    #[error(transparent)]
    Session(#[from] crate::session::SessionError),
    /// The camera is there and cannot give pictures that can be used.
    #[error("{device}: {reason}")]
    Unusable {
        /// The camera.
        device: String,
        /// What it lacks, and what it offers instead.
        reason: String,
    },
    /// The camera is not there (any more) or belongs to another program.
    #[error("{device}: {reason}")]
    DeviceLost {
        /// The camera.
        device: String,
        /// What happened.
        reason: String,
    },
    /// The camera is there and no picture came for too long.
    #[error(
        "{device}: no usable picture for {seconds} s ({damaged} damaged ones arrived): check its cable and its USB bandwidth, or unplug it and plug it in again"
    )]
    Stalled {
        /// The camera.
        device: String,
        /// How long was waited.
        seconds: f64,
        /// Pictures that arrived in that time and were marked damaged.
        damaged: u64,
    },
}

impl SourceError {
    /// How a command that meets this error ends.
    #[must_use]
    pub const fn exit(&self) -> Exit {
        match self {
            Self::BadArgument { .. } => Exit::BadArguments,
            Self::BadInput { .. } | Self::Session(_) | Self::Unusable { .. } => Exit::Failed,
            Self::DeviceLost { .. } | Self::Stalled { .. } => Exit::DeviceLost,
        }
    }

    pub(super) fn argument(spec: &str, reason: impl Into<String>) -> Self {
        Self::BadArgument { spec: spec.to_owned(), reason: reason.into() }
    }

    pub(super) fn input(path: &Path, reason: impl Into<String>) -> Self {
        Self::BadInput { path: path.to_owned(), reason: reason.into() }
    }
}

impl From<SourceError> for Failure {
    fn from(error: SourceError) -> Self {
        Self::new(error.exit(), error)
    }
}
