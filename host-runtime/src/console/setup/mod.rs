//! Set-up: the balls of each camera found or pointed at, judged, used and kept; and the arms of the frame.
//!
//! ```text
//! page --POST /api/setup/...--> routes: may this page? one piece of work at a time, on a thread of its own
//!                                  |  a whole picture (still), what was learnt from it (draft)
//!                                  +--use--> stop; the cameras' threads look for other balls (CameraHandle),
//!                                            the operator's loop begins with another hand (take_arms)
//! ```
//!
//! A draft changes nothing until it is used. What is used stops the arm first: it moves again after a reset
//! and a fresh press, by the law of every stop. While the arm follows the hand nothing is set up.

mod colour_words;
mod draft;
mod files;
mod keep;
mod looks;
mod refused;
mod routes;
mod scan;
mod teach;
mod told;

use super::desk::Desk;
use super::snapshot::ArmView;
use crate::locked::lock;
use crate::station::camera::CameraHandle;
use draft::Draft;
use refused::Refused;
pub(super) use routes::routes;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tetrad_core::hand::affine::Arms;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

/// Whoever wants work done while other work is done waits at most so long.
const WORK_WITHIN: Duration = Duration::from_secs(5);

/// Scans at once; one more is refused, and the page asks again.
const SCANS: usize = 2;

/// One camera of the hand.
#[derive(Debug)]
pub struct SetUpCamera {
    /// What it is called.
    pub name: String,
    /// Where it is.
    pub place: SetUpPlace,
}

/// Where a camera of the hand is.
#[derive(Debug)]
pub enum SetUpPlace {
    /// At this computer.
    Here {
        /// It is asked for pictures, and taught, there.
        handle: CameraHandle,
        /// SRC.
        source: String,
        /// What keeps its colours.
        file: Option<PathBuf>,
    },
    /// Somewhere else: why it is not taught from here, and where it is.
    Elsewhere(&'static str),
}

/// A camera of this computer.
#[derive(Clone, Copy, Debug)]
struct Local<'a> {
    index: usize,
    name: &'a str,
    handle: &'a CameraHandle,
    source: &'a str,
    file: Option<&'a PathBuf>,
}

/// The set-up of every camera that can be taught while it runs.
#[derive(Debug)]
pub struct SetUp {
    cameras: Vec<SetUpCamera>,
    drafts: Mutex<Vec<Draft>>,
    /// Metres.
    arm_m: Mutex<f32>,
    /// The station's file, which keeps the arms' length.
    file: Option<PathBuf>,
    /// For the operator's loop.
    new_arms: Mutex<Option<Arms>>,
    stills: AtomicU64,
    work: Arc<Semaphore>,
    scans: Arc<Semaphore>,
}

impl SetUp {
    /// What these cameras look for now, with a frame of these arms (metres); `file` is the station's.
    #[must_use]
    pub fn new(cameras: Vec<SetUpCamera>, arm_m: f32, file: Option<PathBuf>) -> Self {
        let draft = |camera: &SetUpCamera| match &camera.place {
            SetUpPlace::Here { handle, .. } => Draft::in_use(&handle.taught()),
            SetUpPlace::Elsewhere(_) => Draft::default(),
        };
        Self {
            drafts: Mutex::new(cameras.iter().map(draft).collect()),
            cameras,
            arm_m: Mutex::new(arm_m),
            file,
            new_arms: Mutex::new(None),
            stills: AtomicU64::new(0),
            work: Arc::new(Semaphore::new(1)),
            scans: Arc::new(Semaphore::new(SCANS)),
        }
    }

    /// The arms of the frame to begin anew with, once.
    pub(super) fn take_arms(&self) -> Option<Arms> {
        lock(&self.new_arms).take()
    }

    /// The operator's loop begins with another hand.
    fn begin_anew(&self, arms: Arms) {
        *lock(&self.new_arms) = Some(arms);
    }

    fn arm_m(&self) -> f32 {
        *lock(&self.arm_m)
    }

    /// The cameras of this computer.
    fn locals(&self) -> impl Iterator<Item = Local<'_>> {
        self.cameras.iter().enumerate().filter_map(|(index, camera)| match &camera.place {
            SetUpPlace::Here { handle, source, file } => {
                Some(Local { index, name: &camera.name, handle, source, file: file.as_ref() })
            }
            SetUpPlace::Elsewhere(_) => None,
        })
    }

    /// A camera that can be set up here.
    fn local(&self, index: usize) -> Result<Local<'_>, Refused> {
        let camera = self.cameras.get(index).ok_or(Refused::NoCamera(index, self.cameras.len()))?;
        match &camera.place {
            SetUpPlace::Elsewhere(why) => Err(Refused::Elsewhere(camera.name.clone(), why)),
            SetUpPlace::Here { handle, source, file } => {
                Ok(Local { index, name: &camera.name, handle, source, file: file.as_ref() })
            }
        }
    }

    /// The one camera that is meant, or all of this computer.
    fn meant(&self, camera: Option<usize>) -> Result<Vec<Local<'_>>, Refused> {
        match camera {
            Some(index) => Ok(vec![self.local(index)?]),
            None => {
                let all: Vec<_> = self.locals().collect();
                if all.is_empty() { Err(Refused::NoneHere) } else { Ok(all) }
            }
        }
    }

    fn draft(&self, index: usize) -> Draft {
        lock(&self.drafts).get(index).cloned().unwrap_or_default()
    }

    fn put(&self, index: usize, draft: Draft) {
        if let Some(place) = lock(&self.drafts).get_mut(index) {
            *place = draft;
        }
    }

    fn next_still(&self) -> u64 {
        self.stills.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// The place of the one who works.
    async fn work(&self) -> Result<OwnedSemaphorePermit, Refused> {
        let permit = timeout(WORK_WITHIN, Arc::clone(&self.work).acquire_owned()).await;
        permit.map_err(|_| Refused::Busy)?.map_err(|_| Refused::Busy)
    }

    fn scan(&self) -> Result<OwnedSemaphorePermit, Refused> {
        Arc::clone(&self.scans).try_acquire_owned().map_err(|_| Refused::Busy)
    }
}

/// Whether this page may set up now: nobody else is in control, and the arm is not known to follow the hand.
fn may_set_up(desk: &Desk, page: Option<u64>) -> Result<(), Refused> {
    let engaged = desk.snapshot().arm.as_ref().is_some_and(ArmView::is_engaged);
    let control = desk.control().view(page.map(super::control::Tab), desk.now_us());
    match control.holder {
        Some(holder) if !control.yours => Err(Refused::AnotherDrives(holder)),
        _ if engaged || control.pressed => Err(Refused::Engaged),
        _ => Ok(()),
    }
}

/// Work that takes long, on a thread of its own; the permit is given back when it ends, whoever waits for it
/// or not.
async fn aside<T: Send + 'static>(
    permit: OwnedSemaphorePermit,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<(T, OwnedSemaphorePermit), Refused> {
    let done = tokio::task::spawn_blocking(move || (work(), permit)).await;
    done.map_err(|_| {
        Refused::Failed("the work has ended without a result; see the console's messages".to_owned())
    })
}

#[cfg(test)]
mod tests;
