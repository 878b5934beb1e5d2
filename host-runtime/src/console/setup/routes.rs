//! The routes of the set-up, all under /api/setup.
//!
//! Every POST has a JSON object with `page` (the number that /live told the page; it may be left out where
//! nobody is in control) and answers with the whole set-up, or with `why` it was refused.

use super::refused::Refused;
use super::told::Told;
use super::{SetUp, keep, looks, teach};
use crate::console::app::State;
use axum::Json;
use axum::Router;
use axum::extract::State as Of;
use axum::http::Uri;
use axum::routing::{get, post};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use tetrad_core::observation::Ball;

pub(in crate::console) fn routes() -> Router<State> {
    Router::new()
        .route("/api/setup", get(all))
        .route("/api/setup/still", get(looks::still_picture).post(teach::take_still))
        .route("/api/setup/find", post(teach::find_balls))
        .route("/api/setup/point", post(teach::point))
        .route("/api/setup/mistaken", get(looks::mistaken_picture))
        .route("/api/setup/scan", get(looks::scan_row))
        .route("/api/setup/use", post(teach::use_it))
        .route("/api/setup/arm", post(teach::arm))
        .route("/api/setup/save", post(keep::save))
        .route("/api/setup/load", post(keep::load))
        .route("/api/setup/colours", get(keep::download).post(keep::upload))
}

/// Who asks, and of which camera: all of this computer where none is named.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Asked {
    pub(super) page: Option<u64>,
    pub(super) camera: Option<usize>,
}

#[derive(Debug, Deserialize)]
struct Reader {
    page: Option<u64>,
}

#[derive(Debug, Deserialize)]
pub(super) struct OfCamera {
    pub(super) camera: usize,
}

/// A ball by its name.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum BallName {
    Red,
    Green,
    Blue,
    Yellow,
}

impl From<BallName> for Ball {
    fn from(name: BallName) -> Self {
        match name {
            BallName::Red => Self::Red,
            BallName::Green => Self::Green,
            BallName::Blue => Self::Blue,
            BallName::Yellow => Self::Yellow,
        }
    }
}

pub(super) type Answer = Result<Json<Told>, Refused>;

pub(super) fn set_up(state: &State) -> Result<&SetUp, Refused> {
    state.desk.set_up().ok_or(Refused::TooEarly)
}

pub(super) fn read<T: DeserializeOwned>(body: &str) -> Result<T, Refused> {
    serde_json::from_str(body).map_err(|error| Refused::Unreadable(error.to_string()))
}

/// What stands behind the question mark: numbers and plain words.
pub(super) fn query<T: DeserializeOwned>(uri: &Uri) -> Result<T, Refused> {
    let pairs = uri.query().unwrap_or_default().split('&').filter(|pair| !pair.is_empty());
    let pairs = pairs.map(|pair| {
        let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
        (key.to_owned(), serde_json::from_str(value).unwrap_or_else(|_| Value::from(value)))
    });
    let object = Value::Object(pairs.collect::<Map<_, _>>());
    serde_json::from_value(object).map_err(|error| Refused::Unreadable(error.to_string()))
}

pub(super) fn told(state: &State, set_up: &SetUp, page: Option<u64>, said: impl Into<String>) -> Answer {
    Ok(Json(Told::of(set_up, &state.desk, page, said.into())))
}

/// Everything as it is now.
async fn all(Of(state): Of<State>, uri: Uri) -> Answer {
    let reader: Reader = query(&uri)?;
    told(&state, set_up(&state)?, reader.page, "")
}
