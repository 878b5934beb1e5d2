//! All of a session: read once, from its beginning to its end, for the plots, the CSV files and the report.
//!
//! That takes as long as the disk does, so it has a thread of its own, and whoever waits asks how far it is.
//! The files lie in a folder of their own under the system's for such things, and go with whoever made them.

use crate::session::{Export, ExportError, Reader, Summary};
use serde::Serialize;
use std::fs::{self, DirBuilder, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

/// The report's file.
const REPORT: &str = "report.html";

/// Makes the names of folders different.
static NUMBER: AtomicU64 = AtomicU64::new(0);

/// See the [module's text](self). Where it is dropped, reading ends and the files are removed.
#[derive(Debug)]
pub(super) struct Whole {
    name: String,
    /// The file's length when it was begun.
    bytes: u64,
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    read: AtomicU64,
    given_up: AtomicBool,
    done: OnceLock<Result<Made, String>>,
}

/// What came of it.
#[derive(Debug)]
struct Made {
    told: Arc<str>,
    scratch: Scratch,
}

#[derive(Serialize)]
struct FileMade {
    name: String,
    bytes: u64,
}

impl Whole {
    /// Starts the thread.
    pub(super) fn begin(name: &str, path: &Path, bytes: u64) -> io::Result<Arc<Self>> {
        let scratch = Scratch::make()?;
        let shared = Arc::new(Shared::default());
        let (theirs, title, path) = (Arc::clone(&shared), format!("Session {name}"), path.to_owned());
        std::thread::Builder::new().name("session".to_owned()).spawn(move || {
            let made = theirs.make(&path, &title, scratch);
            // nobody else says so
            let _ = theirs.done.set(made);
        })?;
        Ok(Arc::new(Self { name: name.to_owned(), bytes, shared }))
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is of that session as it is now. One that failed is tried again.
    pub(super) fn is_of(&self, name: &str, bytes: u64) -> bool {
        self.name == name && self.bytes == bytes && !matches!(self.shared.done.get(), Some(Err(_)))
    }

    /// How far it is, or what came of it, JSON.
    pub(super) fn told(&self) -> Arc<str> {
        match self.shared.done.get() {
            None => {
                let read = self.shared.read.load(Ordering::Relaxed);
                let share = read as f64 / self.bytes.max(1) as f64;
                format!("{{\"state\":\"reading\",\"share\":{:.3}}}", share.min(1.0)).into()
            }
            Some(Ok(made)) => Arc::clone(&made.told),
            Some(Err(why)) => serde_json::json!({ "state": "failed", "why": why }).to_string().into(),
        }
    }

    /// Where the files are.
    #[cfg(test)]
    pub(super) fn folder(&self) -> Option<&Path> {
        self.shared.done.get()?.as_ref().ok().map(|made| made.scratch.0.as_path())
    }

    /// A file that was made.
    pub(super) fn file(&self, name: &str) -> Option<File> {
        let Some(Ok(made)) = self.shared.done.get() else { return None };
        made.scratch.files().ok()?.into_iter().find(|file| file.name == name)?;
        File::open(made.scratch.0.join(name)).ok()
    }
}

impl Drop for Whole {
    fn drop(&mut self) {
        self.shared.given_up.store(true, Ordering::Relaxed);
    }
}

impl Shared {
    fn make(&self, path: &Path, title: &str, scratch: Scratch) -> Result<Made, String> {
        let words = |error: anyhow::Error| format!("{error:#}");
        let report = self.read(path, title, &scratch.0).map_err(words)?;
        fs::write(scratch.0.join(REPORT), report.page())
            .map_err(|error| format!("cannot write {}: {error}", scratch.0.display()))?;
        let files = scratch.files().and_then(|files| serde_json::to_string(&files).map_err(io::Error::other));
        let files = files.map_err(|error| error.to_string())?;
        let told = format!("{{\"state\":\"ready\",\"files\":{files},\"sections\":{}}}", report.plots());
        Ok(Made { told: told.into(), scratch })
    }

    fn read(&self, path: &Path, title: &str, dir: &Path) -> Result<crate::report::Report, anyhow::Error> {
        let mut reader = Reader::open(path)?;
        let mut export = Export::new(&reader, dir);
        let mut summary = Summary::default();
        while let Some(entry) = reader.next_entry()? {
            anyhow::ensure!(!self.given_up.load(Ordering::Relaxed), "another session was asked for");
            match export.take(&reader, &entry) {
                Ok(()) => {}
                Err(ExportError::Session(error)) => return Err(error.into()),
                Err(ExportError::Output(error)) => return Err(error.into()),
            }
            summary.take(&reader, &entry)?;
            self.read.store(reader.taken(), Ordering::Relaxed);
        }
        Ok(summary.report(&reader, title))
    }
}

/// A folder that goes with its owner.
#[derive(Debug)]
struct Scratch(PathBuf);

impl Scratch {
    fn make() -> io::Result<Self> {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("tetrad-session-{}-{number}", std::process::id()));
        let mut builder = DirBuilder::new();
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        // one that is there already, whoever made it, is not taken
        builder.create(&path).or_else(|error| match error.kind() {
            // of a program that had this one's number and did not end by itself
            io::ErrorKind::AlreadyExists => fs::remove_dir_all(&path).and_then(|()| builder.create(&path)),
            _ => Err(error),
        })?;
        Ok(Self(path))
    }

    fn files(&self) -> io::Result<Vec<FileMade>> {
        let mut files = Vec::new();
        for entry in fs::read_dir(&self.0)? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            files.push(FileMade { name, bytes: entry.metadata()?.len() });
        }
        files.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(files)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // what cannot be removed is the system's to clear
        let _ = fs::remove_dir_all(&self.0);
    }
}
