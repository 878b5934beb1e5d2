//! Every route, in one table, without a socket.

use super::access::{self, Access, MAX_BODY};
use super::desk::Desk;
use super::replay::{self, Sessions};
use super::{arm, checklist, live, metrics, pages, pictures, plotly, setup};
use axum::Router;
use axum::extract::{DefaultBodyLimit, State as Of};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware;
use axum::response::{IntoResponse as _, Response};
use axum::routing::{get, post};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;

/// WebSockets at once: below what is accepted in all (`serve`), for they give way to nobody (`room`), and a stop
/// by POST has to get through.
pub const WEB_SOCKETS: usize = 24;

/// What the handlers have.
#[derive(Clone, Debug)]
pub struct State {
    pub(super) desk: Desk,
    pub(super) access: Arc<Access>,
    /// Where recorded sessions lie, if anybody has said so.
    pub(super) sessions: Option<Arc<Sessions>>,
    pub(super) web_sockets: Arc<Semaphore>,
    /// A request is answered within this time, its body come or not.
    pub(super) within: Duration,
}

/// How long a request's body may take.
const WITHIN: Duration = Duration::from_secs(10);

/// The console's routes. Who may ask is decided before each of them.
pub fn app(desk: Desk, access: Access, sessions: Option<Arc<Sessions>>) -> Router {
    let web_sockets = Arc::new(Semaphore::new(WEB_SOCKETS));
    routes(State { desk, access: Arc::new(access), sessions, web_sockets, within: WITHIN })
}

fn routes(state: State) -> Router {
    let router = Router::new()
        .route("/live", get(live::upgrade))
        .route("/pictures", get(pictures::upgrade))
        .route("/api/room", get(room))
        .route("/api/stop", post(stop))
        .route("/api/snapshot", get(snapshot))
        .route("/api/arm", get(arm::arm))
        .route("/api/checklist", get(checklist::checklist))
        .route("/api/sessions", get(replay::list))
        .route("/api/sessions/{name}", get(replay::about))
        .route("/api/sessions/{name}/moment", get(replay::moment))
        .route("/api/sessions/{name}/picture", get(replay::picture))
        .route("/api/sessions/{name}/whole", get(replay::whole).post(replay::read_whole))
        .route("/api/sessions/{name}/files/{file}", get(replay::file))
        .route("/metrics", get(metrics::metrics))
        .route("/health", get(metrics::health))
        .route("/plotly.js", get(plotly::script))
        .route("/sign-in", get(pages::sign_in).post(sign_in))
        .merge(setup::routes());
    pages::PAGES
        .iter()
        .fold(router, |router, page| router.route(page.path, get(move || async move { page.answer() })))
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .layer(middleware::from_fn_with_state(state.clone(), access::guard))
        .with_state(state)
}

/// Whether a page that opens its sockets now would get them: a browser tells it only that they failed.
async fn room(Of(state): Of<State>) -> Response {
    if state.web_sockets.available_permits() > 0 { "room\n".into_response() } else { full() }
}

pub(super) fn full() -> Response {
    (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open: close one\n").into_response()
}

/// The arm stops, whoever asks for it.
async fn stop(Of(state): Of<State>) -> &'static str {
    tracing::warn!("stop is asked for by POST");
    state.desk.stop();
    "stopped\n"
}

/// What the loop knew last.
async fn snapshot(Of(state): Of<State>) -> Response {
    axum::Json(&*state.desk.snapshot()).into_response()
}

/// Takes the token of a form and leaves it with the browser.
async fn sign_in(Of(state): Of<State>, body: String) -> Response {
    let Some(token) = &state.access.token else { return to_the_beginning(HeaderMap::new()) };
    // a token has no character that a form would write otherwise
    let given = body.split('&').find_map(|field| field.strip_prefix("token=")).unwrap_or_default();
    if !token.is(given) {
        return (StatusCode::UNAUTHORIZED, pages::sign_in_again().await).into_response();
    }
    let mut headers = HeaderMap::new();
    if let Ok(cookie) = access::cookie(given, state.access.tls).parse() {
        headers.insert(header::SET_COOKIE, cookie);
    }
    to_the_beginning(headers)
}

fn to_the_beginning(headers: HeaderMap) -> Response {
    (StatusCode::SEE_OTHER, headers, [(header::LOCATION, "/")]).into_response()
}

#[cfg(test)]
mod tests;
