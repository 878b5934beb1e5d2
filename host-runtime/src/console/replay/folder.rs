//! The folder where sessions lie, and those of them that are open.

use super::whole::Whole;
use crate::locked::lock;
use crate::session::{Lookup, SessionError};
use serde::Serialize;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::UNIX_EPOCH;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Sessions that stay open after they were looked at: an hour's index is about 15 MB.
const OPEN: usize = 2;

/// Sessions that are listed, the newest first.
const LISTED: usize = 500;

/// Why something is not shown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(in crate::console) enum Refused {
    /// Nobody said where sessions are.
    #[error(
        "no folder with sessions is known: name it as `sessions` under [console] in the station's file, or record with --record"
    )]
    NoFolder,
    /// No such file, or no such name.
    #[error("there is no session `{0}`: GET /api/sessions lists those that there are")]
    NoSession(String),
    /// It has nothing of what was asked for.
    #[error("there is nothing of that in the session")]
    NothingThere,
    /// The query lacks a number.
    #[error("say {0}=N, a whole number")]
    Unasked(String),
    /// The file cannot be read.
    #[error("{0}")]
    Unreadable(String),
}

impl From<SessionError> for Refused {
    fn from(error: SessionError) -> Self {
        Self::Unreadable(format!("{:#}", anyhow::Error::new(error)))
    }
}

/// The sessions of one folder.
#[derive(Debug)]
pub struct Sessions {
    dir: PathBuf,
    open: Mutex<Vec<Open>>,
    whole: Mutex<Option<Arc<Whole>>>,
    turn: Arc<Semaphore>,
}

/// A session that is open.
#[derive(Debug)]
struct Open {
    name: String,
    bytes: u64,
    lookup: Lookup,
}

/// What there is.
#[derive(Debug, Serialize)]
pub(super) struct Listed {
    /// `None`: nobody said where.
    folder: Option<String>,
    /// What would mend that.
    why: Option<String>,
    sessions: Vec<Session>,
}

impl Listed {
    /// Where there is no folder.
    pub(super) fn nowhere() -> Self {
        Self { folder: None, why: Some(Refused::NoFolder.to_string()), sessions: Vec::new() }
    }
}

/// One file.
#[derive(Debug, Serialize)]
struct Session {
    name: String,
    bytes: u64,
    /// Seconds since 1970.
    changed_s: u64,
}

impl Sessions {
    /// Those in `dir`, which need not be there yet.
    #[must_use]
    pub fn new(dir: PathBuf) -> Self {
        Self { dir, open: Mutex::default(), whole: Mutex::default(), turn: Arc::new(Semaphore::new(1)) }
    }

    /// Whoever reads files has it.
    pub(super) async fn turn(&self) -> Option<OwnedSemaphorePermit> {
        // it is never closed
        Arc::clone(&self.turn).acquire_owned().await.ok()
    }

    pub(super) fn list(&self) -> Result<Listed, Refused> {
        let mut sessions: Vec<Session> = match fs::read_dir(&self.dir) {
            Ok(entries) => entries.filter_map(|entry| Session::of(&entry.ok()?.path())).collect(),
            // it is made when something is recorded
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(error) => {
                return Err(Refused::Unreadable(format!(
                    "cannot read the folder {}: {error}",
                    self.dir.display()
                )));
            }
        };
        sessions.sort_by(|a, b| b.changed_s.cmp(&a.changed_s).then_with(|| a.name.cmp(&b.name)));
        sessions.truncate(LISTED);
        Ok(Listed { folder: Some(self.dir.display().to_string()), why: None, sessions })
    }

    /// The file of a session: one of the folder itself, and no link out of it.
    fn path(&self, name: &str) -> Result<(PathBuf, u64), Refused> {
        let none = || Refused::NoSession(name.to_owned());
        let path = self.dir.join(name);
        let plain =
            Path::new(name).file_name() == Some(OsStr::new(name)) && !name.contains(['/', '\\', '\0']);
        let session = Some(path).filter(|_| plain).and_then(|path| Some((Session::of(&path)?.bytes, path)));
        session.map(|(bytes, path)| (path, bytes)).ok_or_else(none)
    }

    /// Looks into a session that may be open already.
    pub(super) fn look<T>(
        &self,
        name: &str,
        look: impl FnOnce(&mut Lookup, u64) -> Result<T, SessionError>,
    ) -> Result<T, Refused> {
        let (path, bytes) = self.path(name)?;
        let mut open = lock(&self.open);
        let known = open.iter().position(|open| open.name == name).map(|at| open.remove(at));
        let mut one = match known {
            Some(known) => known,
            None => Open { name: name.to_owned(), bytes, lookup: Lookup::open(&path)? },
        };
        let seen = look(&mut one.lookup, one.bytes);
        // the newest stands at the end
        open.push(one);
        if open.len() > OPEN {
            open.remove(0);
        }
        Ok(seen?)
    }

    /// The same, with the file gone through again: it may have grown since.
    pub(super) fn look_anew<T>(
        &self,
        name: &str,
        look: impl FnOnce(&mut Lookup, u64) -> Result<T, SessionError>,
    ) -> Result<T, Refused> {
        lock(&self.open).retain(|open| open.name != name);
        self.look(name, look)
    }

    /// Begins to read all of a session, unless that was done already or goes on; whoever asked for another
    /// before is not waited for any more. What [`whole`](Self::whole) tells.
    pub(super) fn read_whole(&self, name: &str) -> Result<Arc<str>, Refused> {
        let (path, bytes) = self.path(name)?;
        let mut whole = lock(&self.whole);
        if let Some(known) = whole.as_ref().filter(|known| known.is_of(name, bytes)) {
            return Ok(known.told());
        }
        let begun = Whole::begin(name, &path, bytes)
            .map_err(|error| Refused::Unreadable(format!("{name} cannot be read whole: {error}")))?;
        let told = begun.told();
        *whole = Some(begun);
        Ok(told)
    }

    /// How far the reading of all of a session is, JSON.
    pub(super) fn whole(&self, name: &str) -> Result<Arc<str>, Refused> {
        self.path(name)?;
        let whole = lock(&self.whole);
        let known = whole.as_ref().filter(|known| known.name() == name);
        Ok(known.map_or_else(|| "{\"state\":\"none\"}".into(), |known| known.told()))
    }

    /// A file that was made of all of a session.
    pub(super) fn file(&self, name: &str, file: &str) -> Result<File, Refused> {
        self.path(name)?;
        let whole = lock(&self.whole);
        let known = whole.as_ref().filter(|known| known.name() == name);
        known.and_then(|known| known.file(file)).ok_or(Refused::NothingThere)
    }
}

impl Session {
    /// A file of that path, where it can be a session.
    fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        // what a link leads to is not looked at
        let found = fs::symlink_metadata(path).ok().filter(fs::Metadata::is_file)?;
        if !name.ends_with(".mcap") || name.starts_with('.') {
            return None;
        }
        let changed = found.modified().ok().and_then(|at| at.duration_since(UNIX_EPOCH).ok());
        let changed_s = changed.map_or(0, |at| at.as_secs());
        Some(Self { name: name.to_owned(), bytes: found.len(), changed_s })
    }
}
