//! Ctrl-C (and SIGTERM): stop after the present frame, with everything written.

use crate::exit::{Exit, Failure, OrExit as _};
use anyhow::Context as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether somebody asked the program to stop.
#[derive(Clone, Debug)]
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on; once a process.
    pub(super) fn listen() -> Result<Self, Failure> {
        let asked = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&asked);
        ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed))
            .context("cannot listen to Ctrl-C")
            .or_exit(Exit::Failed)?;
        Ok(Self(asked))
    }

    /// Without Ctrl-C.
    #[cfg(test)]
    pub(super) fn by_hand() -> Self {
        Self(Arc::default())
    }

    /// What is set then; whoever sets it asks as well.
    pub(super) fn flag(&self) -> &AtomicBool {
        &self.0
    }

    pub(super) fn asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
