//! `/api/checklist`: what `tetrad check` and `tetrad devices` say of this computer, asked anew each time.

use super::app::State;
use axum::Json;
use axum::extract::State as Of;
use axum::http::StatusCode;
use serde::Serialize;
use std::fmt;
use std::sync::{Arc, OnceLock};
use tokio::sync::Mutex;

/// What is to be looked at before anything moves.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Checklist {
    /// The station's file; `None` for a demo, which has none.
    pub file: Option<String>,
    /// What is not as it should be at the moment, each with its key and what would mend it.
    pub notes: Vec<String>,
    /// The devices that are plugged in, as `tetrad devices` lists them.
    pub devices: String,
}

/// Who makes one. It may open devices to ask them, so it is asked on a thread that may wait.
pub type Checker = Box<dyn Fn() -> Checklist + Send + Sync>;

/// The one who makes it, once it is known.
#[derive(Default)]
pub(super) struct Checks {
    checker: OnceLock<Checker>,
    /// Devices are not asked twice at once, and who waits keeps no thread.
    asked: Arc<Mutex<()>>,
}

impl Checks {
    /// Says who makes it; the first stays.
    pub(super) fn by(&self, checker: Checker) {
        let _ = self.checker.set(checker);
    }

    fn ask(&self) -> Checklist {
        self.checker.get().map_or_else(Checklist::default, |checker| checker())
    }
}

impl fmt::Debug for Checks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Checks(..)")
    }
}

pub(super) async fn checklist(Of(state): Of<State>) -> Result<Json<Checklist>, StatusCode> {
    // kept until it is done, whether anybody still waits for the answer or not
    let turn = Arc::clone(&state.desk.checks().asked).lock_owned().await;
    let asked = tokio::task::spawn_blocking(move || {
        let checklist = state.desk.checks().ask();
        drop(turn);
        checklist
    })
    .await;
    asked.map(Json).map_err(|_| StatusCode::INTERNAL_SERVER_ERROR)
}
