//! What is wrong with a session's file.

use crate::exit::{Exit, Failure};
use std::io;
use std::path::{Path, PathBuf};

/// Every message names the file and says what would mend it.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The operating system does not let it be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        cause: io::Error,
    },
    /// It cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system or the format said.
        #[source]
        cause: anyhow::Error,
    },
    /// It is no MCAP file at all.
    #[error("{}: no MCAP file, for it does not begin as one: give a recording of `tetrad record`", path.display())]
    NotMcap {
        /// The file.
        path: PathBuf,
    },
    /// It is one of somebody else, or it was cut before anything was in it.
    #[error("{}: {reason}", path.display())]
    NotASession {
        /// The file.
        path: PathBuf,
        /// What it lacks, and what to give instead.
        reason: String,
    },
    /// Bytes in it are not those that were written.
    #[error("{}: damaged at byte {at}: {reason}; copy the file again, what stands before it is good", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where the damaged record begins.
        at: u64,
        /// What does not fit.
        reason: String,
    },
}

impl SessionError {
    pub(super) fn not_a_session(path: &Path, reason: impl Into<String>) -> Self {
        Self::NotASession { path: path.to_owned(), reason: reason.into() }
    }

    pub(super) fn write(path: &Path, cause: impl Into<anyhow::Error>) -> Self {
        Self::Write { path: path.to_owned(), cause: cause.into() }
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        Self::new(Exit::Failed, error)
    }
}
