//! `/api/sessions/`: recorded sessions, to be looked at moment by moment and to be read whole.
//!
//! ```text
//! console's thread --request--> one turn at a time --> blocking thread: Lookup, one moment or one picture
//!                                        |
//!                                        +--> thread "session": reads all of one, for plots, CSV and report
//! ```
//!
//! Nothing of it is the operator's loop's, which goes on whatever is looked at. Sessions lie in one folder, and
//! nothing outside that folder can be named.

mod answer;
mod folder;
mod whole;

pub use folder::Sessions;

use super::app::State;
use answer::{About, At};
use axum::Json;
use axum::body::{Body, Bytes};
use axum::extract::{Path as Named, State as Of};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use folder::{Listed, Refused};
use futures_util::stream;
use std::fs::File;
use std::io::{self, Read as _};
use std::sync::Arc;

/// Bytes of a file that are sent at a time.
const PIECE: usize = 64 * 1024;

/// Where the sessions lie, and which there are.
pub(super) async fn list(Of(state): Of<State>) -> Result<Response, Refused> {
    let listed = match state.sessions {
        Some(_) => in_turn(&state, Sessions::list).await?,
        // nothing is wrong with a page that has none to show
        None => Listed::nowhere(),
    };
    Ok(Json(listed).into_response())
}

/// What a session is of.
pub(super) async fn about(Of(state): Of<State>, Named(name): Named<String>) -> Result<Response, Refused> {
    let about = in_turn(&state, move |sessions| {
        sessions.look_anew(&name, |lookup, bytes| Ok(About::of(&name, bytes, lookup.index())))
    });
    Ok(Json(about.await?).into_response())
}

/// What was known at a moment: `?t_us=N` after the session began.
pub(super) async fn moment(
    Of(state): Of<State>,
    Named(name): Named<String>,
    uri: Uri,
) -> Result<Response, Refused> {
    let t_us = asked(&uri, "t_us")?;
    let at = in_turn(&state, move |sessions| {
        sessions.look(&name, |lookup, _| {
            let (began_us, _) = lookup.index().span_us().unwrap_or_default();
            let moment = lookup.moment(began_us.saturating_add(t_us))?;
            Ok(At::of(lookup.index(), &moment, t_us))
        })
    });
    Ok(Json(at.await?).into_response())
}

/// The picture of a camera at a moment, as JPEG: `?camera=N&t_us=N`.
pub(super) async fn picture(
    Of(state): Of<State>,
    Named(name): Named<String>,
    uri: Uri,
) -> Result<Response, Refused> {
    let (camera, t_us) = (asked(&uri, "camera")?, asked(&uri, "t_us")?);
    let camera = usize::try_from(camera).unwrap_or(usize::MAX);
    let jpeg = in_turn(&state, move |sessions| {
        sessions.look(&name, |lookup, _| {
            let (began_us, _) = lookup.index().span_us().unwrap_or_default();
            lookup.picture(camera, began_us.saturating_add(t_us), crate::station::jpeg)
        })
    });
    match jpeg.await? {
        Some(Ok(jpeg)) => Ok(([(header::CONTENT_TYPE, "image/jpeg")], jpeg).into_response()),
        Some(Err(error)) => Err(Refused::Unreadable(format!("the picture cannot be shown: {error}"))),
        None => Err(Refused::NothingThere),
    }
}

/// Begins to read all of a session; how far that is.
pub(super) async fn read_whole(
    Of(state): Of<State>,
    Named(name): Named<String>,
) -> Result<Response, Refused> {
    let told = in_turn(&state, move |sessions| sessions.read_whole(&name));
    Ok(json(told.await?))
}

/// How far the reading of all of a session is, and what came of it.
pub(super) async fn whole(Of(state): Of<State>, Named(name): Named<String>) -> Result<Response, Refused> {
    let told = in_turn(&state, move |sessions| sessions.whole(&name));
    Ok(json(told.await?))
}

/// A file that was made of all of a session.
pub(super) async fn file(
    Of(state): Of<State>,
    Named((name, file)): Named<(String, String)>,
) -> Result<Response, Refused> {
    let kind = match file.rsplit_once('.') {
        Some((_, "html")) => "text/html; charset=utf-8",
        _ => "text/csv; charset=utf-8",
    };
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
    let called: String = name.trim_end_matches(".mcap").chars().map(plain).collect();
    let saved = format!("attachment; filename=\"{called}-{file}\"");
    let open = in_turn(&state, move |sessions| sessions.file(&name, &file)).await?;
    let mut headers = HeaderMap::new();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    // a report has scripts of its own, which the console's rules do not run: it is saved and opened by itself
    headers.insert(header::CONTENT_DISPOSITION, saved.parse().map_err(|_| Refused::NothingThere)?);
    Ok((headers, piece_by_piece(open)).into_response())
}

/// A file's bytes, read as they are sent.
fn piece_by_piece(file: File) -> Body {
    let pieces = stream::unfold(Some(file), |file: Option<File>| async move {
        let mut file = file?;
        let read = tokio::task::spawn_blocking(move || {
            let mut piece = vec![0; PIECE];
            let read = file.read(&mut piece)?;
            piece.truncate(read);
            Ok::<_, io::Error>((Bytes::from(piece), file))
        });
        match read.await.unwrap_or_else(|error| Err(io::Error::other(error))) {
            Ok((piece, _)) if piece.is_empty() => None,
            Ok((piece, file)) => Some((Ok(piece), Some(file))),
            Err(error) => Some((Err(error), None)),
        }
    });
    Body::from_stream(pieces)
}

fn json(text: Arc<str>) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], text.to_string()).into_response()
}

/// Does what reads files, on a thread that may wait for a disk; one such thing at a time.
async fn in_turn<T: Send + 'static>(
    state: &State,
    work: impl FnOnce(&Sessions) -> Result<T, Refused> + Send + 'static,
) -> Result<T, Refused> {
    let sessions = Arc::clone(state.sessions.as_ref().ok_or(Refused::NoFolder)?);
    let turn = sessions.turn().await;
    let done = tokio::task::spawn_blocking(move || {
        let _turn = turn;
        work(&sessions)
    });
    done.await.unwrap_or_else(|_| Err(Refused::Unreadable("it could not be read".to_owned())))
}

/// A number of the query.
fn asked(uri: &Uri, name: &str) -> Result<u64, Refused> {
    let parts = uri.query().unwrap_or_default().split('&');
    let given = parts.filter_map(|part| part.split_once('=')).find(|(key, _)| *key == name);
    given.and_then(|(_, value)| value.parse().ok()).ok_or_else(|| Refused::Unasked(name.to_owned()))
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        let status = match self {
            Self::NoFolder | Self::NoSession(_) | Self::NothingThere => StatusCode::NOT_FOUND,
            Self::Unasked(_) => StatusCode::BAD_REQUEST,
            Self::Unreadable(_) => StatusCode::UNPROCESSABLE_ENTITY,
        };
        (status, format!("{self}\n")).into_response()
    }
}

#[cfg(test)]
mod tests;
