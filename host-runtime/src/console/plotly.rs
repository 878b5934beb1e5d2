//! `/plotly.js`: the script that draws plots, for the pages that have some. It is the one that the `plotly`
//! crate embeds, so that plots need nothing from elsewhere.

use crate::report::plotly_script;
use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::sync::LazyLock;

/// Browsers keep it for a week, and ask then whether it is still the same. It is 4.6 MB, and nobody's
/// secret; it is behind the token like all else, so that it is kept by the browser alone.
const KEPT: HeaderValue = HeaderValue::from_static("private, max-age=604800");

/// The script, and the tag by which browsers know whether they have it.
struct Script {
    text: Bytes,
    tag: String,
}

/// Made when it is first asked for: who plots nothing has no copy of it.
static SCRIPT: LazyLock<Script> = LazyLock::new(|| {
    let text = plotly_script();
    let mut hash = DefaultHasher::new();
    text.hash(&mut hash);
    Script { tag: format!("\"{:016x}\"", hash.finish()), text: text.into() }
});

pub(super) async fn script(headers: HeaderMap) -> Response {
    let script = &*SCRIPT;
    let about = [
        (header::CACHE_CONTROL, KEPT),
        // a tag of digits and quotes always is one
        (header::ETAG, HeaderValue::from_str(&script.tag).unwrap_or(HeaderValue::from_static("\"\""))),
    ];
    let known = headers.get_all(header::IF_NONE_MATCH).iter().filter_map(|tags| tags.to_str().ok());
    if known.flat_map(|tags| tags.split(',')).any(|tag| tag.trim().trim_start_matches("W/") == script.tag) {
        return (StatusCode::NOT_MODIFIED, about).into_response();
    }
    let kind = (header::CONTENT_TYPE, "text/javascript; charset=utf-8");
    (about, [kind], script.text.clone()).into_response()
}
