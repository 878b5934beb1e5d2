//! The pages, their style and scripts, as they are embedded in the program.

use axum::http::header;
use axum::response::{Html, IntoResponse as _, Response};

/// One file.
#[derive(Debug)]
pub(super) struct Page {
    pub(super) path: &'static str,
    kind: &'static str,
    content: &'static str,
}

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const PICTURE: &str = "image/svg+xml";

/// Every file, by its path.
pub(super) const PAGES: [Page; 32] = [
    Page { path: "/", kind: HTML, content: include_str!("page/index.html") },
    Page { path: "/setup", kind: HTML, content: include_str!("page/setup.html") },
    Page { path: "/setup.css", kind: STYLE, content: include_str!("page/setup.css") },
    Page { path: "/setup.js", kind: SCRIPT, content: include_str!("page/setup.js") },
    Page { path: "/setup-view.js", kind: SCRIPT, content: include_str!("page/setup-view.js") },
    Page { path: "/scan.js", kind: SCRIPT, content: include_str!("page/scan.js") },
    Page { path: "/drive", kind: HTML, content: include_str!("page/drive.html") },
    Page { path: "/slave", kind: HTML, content: include_str!("page/slave.html") },
    Page { path: "/style.css", kind: STYLE, content: include_str!("page/style.css") },
    Page { path: "/icon.svg", kind: PICTURE, content: include_str!("page/icon.svg") },
    Page { path: "/page.js", kind: SCRIPT, content: include_str!("page/page.js") },
    Page { path: "/plot.css", kind: STYLE, content: include_str!("page/plot.css") },
    Page { path: "/plot.js", kind: SCRIPT, content: include_str!("page/plot.js") },
    Page { path: "/line-clock.js", kind: SCRIPT, content: include_str!("page/line-clock.js") },
    Page { path: "/live.js", kind: SCRIPT, content: include_str!("page/live.js") },
    Page { path: "/hold.js", kind: SCRIPT, content: include_str!("page/hold.js") },
    Page { path: "/views.js", kind: SCRIPT, content: include_str!("page/views.js") },
    Page { path: "/stop.js", kind: SCRIPT, content: include_str!("page/stop.js") },
    Page { path: "/controls.js", kind: SCRIPT, content: include_str!("page/controls.js") },
    Page { path: "/gauges.js", kind: SCRIPT, content: include_str!("page/gauges.js") },
    Page { path: "/palette.js", kind: SCRIPT, content: include_str!("page/palette.js") },
    Page { path: "/pictures.js", kind: SCRIPT, content: include_str!("page/pictures.js") },
    Page { path: "/plot-delays.js", kind: SCRIPT, content: include_str!("page/plot-delays.js") },
    Page { path: "/scene.js", kind: SCRIPT, content: include_str!("page/scene.js") },
    Page { path: "/scene-space.js", kind: SCRIPT, content: include_str!("page/scene-space.js") },
    Page { path: "/slave.js", kind: SCRIPT, content: include_str!("page/slave.js") },
    Page { path: "/stereo.js", kind: SCRIPT, content: include_str!("page/stereo.js") },
    Page { path: "/drive.js", kind: SCRIPT, content: include_str!("page/drive.js") },
    Page { path: "/replay", kind: HTML, content: include_str!("page/replay.html") },
    Page { path: "/replay.css", kind: STYLE, content: include_str!("page/replay.css") },
    Page { path: "/replay.js", kind: SCRIPT, content: include_str!("page/replay.js") },
    Page { path: "/index.js", kind: SCRIPT, content: include_str!("page/index.js") },
];

impl Page {
    pub(super) fn answer(&'static self) -> Response {
        ([(header::CONTENT_TYPE, self.kind)], self.content).into_response()
    }
}

/// Where the token is asked for.
pub(super) async fn sign_in() -> Html<&'static str> {
    Html(include_str!("page/sign-in.html"))
}

/// The same after a token that was not it.
pub(super) async fn sign_in_again() -> Html<String> {
    Html(
        include_str!("page/sign-in.html")
            .replace("<!-- again -->", "<p class=\"bad\">That is not the token.</p>"),
    )
}

#[cfg(test)]
mod tests;
