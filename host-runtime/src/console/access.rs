//! Who gets in: the Host and Origin of a request, its token, its size.
//!
//! A page of another site can make a browser send requests here, and with a name that it makes resolve to
//! this computer (DNS rebinding) even read the answers. So a request counts only under a name that this
//! console has, and one that comes from a page only where that page is the console's own. Behind that
//! stands the token, which is needed everywhere where `token_file` is given, and always away from loopback.

use super::app::State;
use super::room::Ticket;
use axum::body::Body;
use axum::extract::{Request, State as Of};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use rustls::client::verify_server_name;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::server::ParsedCertificate;
use std::fmt;
use std::net::IpAddr;
use std::sync::atomic::Ordering;
use subtle::ConstantTimeEq as _;
use tokio::time::timeout;

/// The largest body of a request, bytes.
pub const MAX_BODY: usize = 64 * 1024;

/// The cookie with the token.
pub(super) const COOKIE: &str = "tetrad_token";

/// Lengths a token may have.
const TOKEN_LENGTHS: std::ops::RangeInclusive<usize> = 16..=256;

/// What goes with every answer.
const HEADERS: [(HeaderName, HeaderValue); 7] = [
    (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY)),
    (header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff")),
    // "no-referrer" has browsers send the form of /sign-in with an Origin of null
    (header::REFERRER_POLICY, HeaderValue::from_static("same-origin")),
    (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
    (header::X_FRAME_OPTIONS, HeaderValue::from_static("DENY")),
    (HeaderName::from_static("cross-origin-resource-policy"), HeaderValue::from_static("same-origin")),
    (HeaderName::from_static("cross-origin-opener-policy"), HeaderValue::from_static("same-origin")),
];

/// Nothing from elsewhere, nothing inline; pictures come over the socket.
const POLICY: &str = "default-src 'self'; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'; \
                      form-action 'self'; frame-ancestors 'none'";

/// A secret that lets in. It is never written into messages.
#[derive(Clone)]
pub struct Token(String);

/// A token that nobody should use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a token is one line of {} to {} letters, digits, - and _, as `openssl rand -hex 32` prints it",
    TOKEN_LENGTHS.start(), TOKEN_LENGTHS.end()
)]
pub struct BadToken;

impl Token {
    /// The token of a file's text.
    ///
    /// # Errors
    /// [`BadToken`]
    pub fn parse(text: &str) -> Result<Self, BadToken> {
        let token = text.trim();
        let sound = |c: u8| c.is_ascii_alphanumeric() || c == b'-' || c == b'_';
        if TOKEN_LENGTHS.contains(&token.len()) && token.bytes().all(sound) {
            Ok(Self(token.to_owned()))
        } else {
            Err(BadToken)
        }
    }

    /// Whether it is this one, in a time that does not tell where they differ.
    #[must_use]
    pub fn is(&self, given: &str) -> bool {
        self.0.as_bytes().ct_eq(given.as_bytes()).into()
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(..)")
    }
}

/// Who gets in.
#[derive(Clone, Debug)]
pub struct Access {
    /// Whether only this computer is meant.
    pub loopback: bool,
    /// Whether it is served over TLS.
    pub tls: bool,
    /// Names beside addresses that the console is known by, lower case.
    pub names: Vec<String>,
    /// What it shows to browsers: under its names it is known too.
    pub certificate: Option<CertificateDer<'static>>,
    /// What has to be shown.
    pub token: Option<Token>,
}

/// Whose request is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trust {
    /// Anybody's: it asks for what needs no token.
    Nobody,
    /// One who has the token, or needs none.
    Known,
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Refused {
    /// It is meant for another site.
    ForeignHost,
    /// Another site's page has sent it.
    CrossSite,
    /// Without the token.
    NoToken,
    /// It brings more than is taken.
    TooLarge,
}

impl Access {
    /// This computer alone, without a token.
    #[must_use]
    pub const fn loopback() -> Self {
        Self { loopback: true, tls: false, names: Vec::new(), certificate: None, token: None }
    }

    fn check(&self, method: &Method, uri: &Uri, headers: &HeaderMap) -> Result<Trust, Refused> {
        let host = one(headers, &header::HOST).ok_or(Refused::ForeignHost)?;
        if !self.is_own_host(host) {
            return Err(Refused::ForeignHost);
        }
        let scheme = if self.tls { "https" } else { "http" };
        let origin = headers.get(header::ORIGIN);
        if origin.is_some_and(|origin| *origin != format!("{scheme}://{host}")) {
            return Err(Refused::CrossSite);
        }
        // a link from elsewhere may lead to a page, and to nothing else
        let site = headers.get("sec-fetch-site").map(HeaderValue::as_bytes);
        let navigates =
            method == Method::GET && headers.get("sec-fetch-mode").is_some_and(|mode| mode == "navigate");
        if site.is_some_and(|site| site != b"same-origin" && site != b"none") && !navigates {
            return Err(Refused::CrossSite);
        }
        let length = headers.get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok());
        if length.is_some_and(|length| length.parse().map_or(true, |length: usize| length > MAX_BODY)) {
            return Err(Refused::TooLarge);
        }
        let open = matches!(uri.path(), "/health" | "/sign-in" | "/style.css" | "/icon.svg");
        match &self.token {
            Some(token) if !given(headers).any(|given| token.is(given)) => {
                if open {
                    Ok(Trust::Nobody)
                } else {
                    Err(Refused::NoToken)
                }
            }
            _ => Ok(Trust::Known),
        }
    }

    /// Whether the console is known by this name: one that anybody can make resolve to it does not count.
    fn is_own_host(&self, host: &str) -> bool {
        let Ok(authority) = host.parse::<Authority>() else { return false };
        if host.contains('@') {
            return false;
        }
        let name = authority.host().to_ascii_lowercase();
        let address = name.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
        match address {
            Ok(address) => !self.loopback || address.is_loopback(),
            Err(_) => name == "localhost" || self.names.contains(&name) || self.is_certified(&name),
        }
    }

    /// Whether its certificate is made out to this name, so that browsers would believe it there.
    fn is_certified(&self, name: &str) -> bool {
        let Some(certificate) = &self.certificate else { return false };
        let Ok(name) = ServerName::try_from(name) else { return false };
        ParsedCertificate::try_from(certificate)
            .is_ok_and(|certificate| verify_server_name(&certificate, &name).is_ok())
    }
}

/// The value of a header that is there once.
fn one<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let mut all = headers.get_all(name).iter();
    let value = all.next()?.to_str().ok()?;
    all.next().is_none().then_some(value)
}

/// The tokens that a request shows.
fn given(headers: &HeaderMap) -> impl Iterator<Item = &str> {
    let bearer = headers
        .get(header::AUTHORIZATION)
        .and_then(|value| value.to_str().ok())
        .and_then(|value| value.strip_prefix("Bearer "));
    let cookies = headers.get_all(header::COOKIE).into_iter().filter_map(|value| value.to_str().ok());
    let cookies = cookies.flat_map(|cookies| cookies.split(';')).filter_map(|cookie| {
        let (name, value) = cookie.trim().split_once('=')?;
        (name == COOKIE).then_some(value)
    });
    bearer.into_iter().chain(cookies)
}

/// Stands in front of every route.
pub(super) async fn guard(Of(state): Of<State>, request: Request<Body>, next: Next) -> Response {
    let checked = state.access.check(request.method(), request.uri(), request.headers());
    // without a socket there is none
    let ticket = request.extensions().get::<Ticket>().cloned();
    if let (Ok(Trust::Known), Some(ticket)) = (checked, &ticket) {
        ticket.is_known();
    }
    let mut response = match checked {
        // an upgraded socket is answered at once, and goes on by itself
        Ok(_) => timeout(state.within, next.run(request)).await.unwrap_or_else(|_| {
            (StatusCode::REQUEST_TIMEOUT, "the request took too long to come\n").into_response()
        }),
        Err(refused) => {
            state.desk.counts().refused.fetch_add(1, Ordering::Relaxed);
            tracing::warn!(why = ?refused, method = %request.method(), path = request.uri().path(), "a request is refused");
            refused.answer(request.headers())
        }
    };
    if let Some(ticket) = ticket.filter(|_| response.status() == StatusCode::SWITCHING_PROTOCOLS) {
        ticket.stays();
    }
    for (name, value) in HEADERS {
        // what may be kept says so itself
        if name != header::CACHE_CONTROL || !response.headers().contains_key(&name) {
            response.headers_mut().insert(name, value);
        }
    }
    response
}

impl Refused {
    fn answer(self, headers: &HeaderMap) -> Response {
        let wants_page = headers
            .get(header::ACCEPT)
            .and_then(|accept| accept.to_str().ok())
            .is_some_and(|accept| accept.contains("text/html"));
        match self {
            Self::NoToken if wants_page => {
                (StatusCode::SEE_OTHER, [(header::LOCATION, "/sign-in")]).into_response()
            }
            Self::NoToken => (
                StatusCode::UNAUTHORIZED,
                [(header::WWW_AUTHENTICATE, "Bearer")],
                "a token is needed: Authorization: Bearer TOKEN, or sign in at /sign-in\n",
            )
                .into_response(),
            Self::ForeignHost => (
                StatusCode::MISDIRECTED_REQUEST,
                "this console is not known by that name: use its address, or add the name to [console] names\n",
            )
                .into_response(),
            Self::CrossSite => {
                (StatusCode::FORBIDDEN, "a page of another site has asked for this\n").into_response()
            }
            Self::TooLarge => (
                StatusCode::PAYLOAD_TOO_LARGE,
                format!("at most {MAX_BODY} bytes are taken\n"),
            )
                .into_response(),
        }
    }
}

/// The header that leaves the token with a browser that has shown it.
pub(super) fn cookie(token: &str, tls: bool) -> String {
    let secure = if tls { "; Secure" } else { "" };
    format!("{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict; Max-Age=2592000{secure}")
}
