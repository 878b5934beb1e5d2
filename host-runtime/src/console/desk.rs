//! What the console's server and the loops have in common: the newest of each kind, locked for a copy, and no
//! queue. Whoever brings something never waits for whoever reads it.

use super::checklist::{Checker, Checks};
use super::control::{Control, Refusal, Tab};
use super::setup::SetUp;
use super::snapshot::{BallView, Snapshot};
use crate::link::Doorbell;
use crate::locked::lock;
use crate::robot::clock::Clock;
use crate::station::operator::Buttons;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock};
use tetrad_core::hand::affine::Arms;
use tokio::sync::watch;

/// What a view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewKind {
    /// A camera that sees the hand.
    Hand,
    /// A camera of the slave's scene.
    Eye,
}

/// A picture to be looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Counts the view's pictures, and wraps.
    pub sequence: u32,
    /// When it was taken, by the operator's clock, microseconds; as long ago as it came where nobody
    /// knows.
    pub taken_us: u64,
    /// Pixels.
    pub width: u16,
    /// Pixels.
    pub height: u16,
    /// What was seen in it, where that is known.
    pub balls: Vec<BallView>,
    /// The file.
    pub jpeg: Arc<[u8]>,
}

/// One view: its newest picture, and how many look.
#[derive(Debug)]
pub struct View {
    /// What it is called.
    pub name: String,
    /// What it shows.
    pub kind: ViewKind,
    lookers: AtomicUsize,
    newest: Mutex<Option<Arc<Shown>>>,
    /// Pictures that pages have thanked for.
    pub(super) thanked: AtomicU64,
}

/// What was counted, for /metrics.
#[derive(Debug, Default)]
pub(super) struct Counts {
    pub(super) sockets: AtomicUsize,
    pub(super) web_sockets: AtomicUsize,
    pub(super) refused: AtomicU64,
    pub(super) crowded_out: AtomicU64,
    pub(super) pictures: AtomicU64,
}

#[derive(Debug)]
struct Shared {
    clock: Clock,
    bell: Doorbell,
    control: Mutex<Control>,
    homed: AtomicBool,
    snapshot: Mutex<Arc<Snapshot>>,
    views: Vec<View>,
    /// What can be set up, once the cameras are open.
    set_up: OnceLock<SetUp>,
    /// Changes whenever a view has a new picture.
    pictured: watch::Sender<u64>,
    counts: Counts,
    tabs: AtomicU64,
    checks: Checks,
}

/// See the [module's text](self). Clones are the same desk.
#[derive(Clone, Debug)]
pub struct Desk(Arc<Shared>);

/// Somebody looks at views; not any more where it is dropped.
#[derive(Debug)]
pub(super) struct Look {
    desk: Desk,
    views: Vec<usize>,
}

/// A tab's place at the desk; where it is dropped, the tab drives no longer.
#[derive(Debug)]
pub(super) struct Seat {
    desk: Desk,
    pub(super) tab: Tab,
}

impl Desk {
    /// A desk for these views. `drives`: the buttons are here. The loop that sleeps on `bell` is woken when
    /// they change.
    #[must_use]
    pub fn new(drives: bool, views: Vec<(String, ViewKind)>, clock: Clock, bell: Doorbell) -> Self {
        let view = |(name, kind)| View {
            name,
            kind,
            lookers: AtomicUsize::new(0),
            newest: Mutex::new(None),
            thanked: AtomicU64::new(0),
        };
        Self(Arc::new(Shared {
            clock,
            bell,
            control: Mutex::new(Control::new(drives)),
            homed: AtomicBool::new(false),
            snapshot: Mutex::default(),
            views: views.into_iter().map(view).collect(),
            set_up: OnceLock::new(),
            pictured: watch::Sender::new(0),
            counts: Counts::default(),
            tabs: AtomicU64::new(0),
            checks: Checks::default(),
        }))
    }

    /// Says who looks through this computer for the page that asks what is missing; the first stays.
    pub fn check_by(&self, checker: Checker) {
        self.0.checks.by(checker);
    }

    pub(super) fn checks(&self) -> &Checks {
        &self.0.checks
    }

    /// The operator's clock.
    #[must_use]
    pub fn now_us(&self) -> u64 {
        self.0.clock.now_us()
    }

    /// Puts what the loop knows in place of what it knew before.
    pub fn publish(&self, snapshot: Snapshot) {
        let snapshot = Arc::new(snapshot);
        let before = std::mem::replace(&mut *lock(&self.0.snapshot), snapshot);
        // its memory is given back without the lock
        drop(before);
    }

    /// What the loop knew last.
    #[must_use]
    pub fn snapshot(&self) -> Arc<Snapshot> {
        Arc::clone(&lock(&self.0.snapshot))
    }

    /// What is pressed now.
    #[must_use]
    pub fn buttons(&self) -> Buttons {
        self.control().buttons(self.now_us())
    }

    /// Whether somebody has said that the joints are homed since it was last asked.
    #[must_use]
    pub fn take_homed(&self) -> bool {
        self.0.homed.swap(false, Ordering::Relaxed)
    }

    /// What the set-up page sets up; once.
    pub fn set_up_with(&self, set_up: SetUp) {
        // a second one would be another run's, and there is none
        let _ = self.0.set_up.set(set_up);
    }

    /// What can be set up; `None` while the cameras are being opened.
    pub(super) fn set_up(&self) -> Option<&SetUp> {
        self.0.set_up.get()
    }

    /// The arms of the frame that the operator is to begin anew with, where that was asked for.
    #[must_use]
    pub fn take_arms(&self) -> Option<Arms> {
        self.0.set_up.get()?.take_arms()
    }

    /// The views there are.
    #[must_use]
    pub fn views(&self) -> &[View] {
        &self.0.views
    }

    /// Whether anybody looks at a view.
    #[must_use]
    pub fn is_looked_at(&self, view: usize) -> bool {
        self.0.views.get(view).is_some_and(|view| view.lookers.load(Ordering::Relaxed) > 0)
    }

    /// Puts a picture in place of the one before.
    pub fn show(&self, view: usize, shown: Shown) {
        let Some(view) = self.0.views.get(view) else { return };
        let shown = Arc::new(shown);
        drop(lock(&view.newest).replace(shown));
        self.0.counts.pictures.fetch_add(1, Ordering::Relaxed);
        self.0.pictured.send_modify(|count| *count = count.wrapping_add(1));
    }

    /// The newest picture of a view.
    #[must_use]
    pub fn shown(&self, view: usize) -> Option<Arc<Shown>> {
        lock(&self.0.views.get(view)?.newest).clone()
    }

    /// A page has drawn a picture of a view.
    pub(super) fn thank(&self, view: usize) {
        if let Some(view) = self.0.views.get(view) {
            view.thanked.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Who drives; for as long as nothing else is done.
    pub fn control(&self) -> MutexGuard<'_, Control> {
        lock(&self.0.control)
    }

    /// Stop, by anybody.
    pub fn stop(&self) {
        self.control().stop();
        self.0.bell.ring();
    }

    /// The joints are said to be homed.
    ///
    /// # Errors
    /// [`Refusal::NotInControl`]
    pub(super) fn homed(&self, tab: Tab) -> Result<(), Refusal> {
        if !self.control().is_holder(tab, self.now_us()) {
            return Err(Refusal::NotInControl);
        }
        self.0.homed.store(true, Ordering::Relaxed);
        self.0.bell.ring();
        Ok(())
    }

    /// Does something with the buttons, and wakes the loop where they changed.
    pub(super) fn with_control<R>(&self, act: impl FnOnce(&mut Control, u64) -> R) -> R {
        let now_us = self.now_us();
        let mut control = self.control();
        let before = control.buttons(now_us);
        let result = act(&mut control, now_us);
        let changed = control.buttons(now_us) != before;
        drop(control);
        if changed {
            self.0.bell.ring();
        }
        result
    }

    /// A place for one more tab.
    pub(super) fn seat(&self) -> Seat {
        let tab = Tab(self.0.tabs.fetch_add(1, Ordering::Relaxed) + 1);
        Seat { desk: self.clone(), tab }
    }

    /// Somebody looks at these views; those that are not there are left out.
    pub(super) fn look(&self, views: impl IntoIterator<Item = usize>) -> Look {
        let views: Vec<usize> = views.into_iter().filter(|view| *view < self.0.views.len()).collect();
        for view in views.iter().filter_map(|view| self.0.views.get(*view)) {
            view.lookers.fetch_add(1, Ordering::Relaxed);
        }
        Look { desk: self.clone(), views }
    }

    pub(super) fn watch_pictures(&self) -> watch::Receiver<u64> {
        self.0.pictured.subscribe()
    }

    pub(super) fn counts(&self) -> &Counts {
        &self.0.counts
    }
}

impl Look {
    pub(super) fn views(&self) -> &[usize] {
        &self.views
    }
}

impl Drop for Look {
    fn drop(&mut self) {
        for view in self.views.iter().filter_map(|view| self.desk.0.views.get(*view)) {
            view.lookers.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.desk.with_control(|control, _| control.gone(self.tab));
    }
}
