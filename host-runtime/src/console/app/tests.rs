mod room;

use super::*;
use crate::console::snapshot::Snapshot;
use crate::console::{Checklist, Token, ViewKind};
use crate::link::Doorbell;
use crate::robot::clock::Clock;
use axum::body::{Body, to_bytes};
use axum::http::{Method, Request};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::sync::atomic::{AtomicU64, Ordering};
use tetrad_core::arm::puma560::Puma560;
use tetrad_core::config::PumaConfig;
use tetrad_core::geometry::Pose;
use tower::ServiceExt as _;

const TOKEN: &str = "0123456789abcdef0123456789abcdef";

fn desk() -> Desk {
    Desk::new(true, vec![("left".to_owned(), ViewKind::Hand)], Clock::given(), Doorbell::default())
}

fn with_token() -> Access {
    Access { token: Some(Token::parse(TOKEN).unwrap()), ..Access::loopback() }
}

/// A request under a name that is the console's own, with these headers beside.
fn request(method: Method, path: &str, headers: &[(&str, &str)]) -> Request<Body> {
    let mut request = Request::builder().method(method).uri(path);
    if !headers.iter().any(|(name, _)| *name == "host") {
        request = request.header("host", "127.0.0.1:8080");
    }
    for (name, value) in headers {
        request = request.header(*name, *value);
    }
    request.body(Body::empty()).unwrap()
}

async fn ask(desk: &Desk, access: &Access, request: Request<Body>) -> Response {
    app(desk.clone(), access.clone(), None).oneshot(request).await.unwrap()
}

async fn get_of(path: &str, headers: &[(&str, &str)], access: &Access) -> StatusCode {
    ask(&desk(), access, request(Method::GET, path, headers)).await.status()
}

async fn text(response: Response) -> String {
    String::from_utf8(to_bytes(response.into_body(), 1 << 20).await.unwrap().to_vec()).unwrap()
}

/// What makes a request one for a WebSocket.
const UPGRADE: [(&str, &str); 4] = [
    ("connection", "upgrade"),
    ("upgrade", "websocket"),
    ("sec-websocket-version", "13"),
    ("sec-websocket-key", "dGhlIHNhbXBsZSBub25jZQ=="),
];

#[tokio::test]
async fn every_page_is_there_and_says_that_nothing_comes_from_elsewhere() {
    for page in &pages::PAGES {
        let response = ask(&desk(), &Access::loopback(), request(Method::GET, page.path, &[])).await;
        assert_eq!(response.status(), StatusCode::OK, "{}", page.path);
        let policy = response.headers()[header::CONTENT_SECURITY_POLICY].to_str().unwrap();
        assert!(policy.starts_with("default-src 'self';") && !policy.contains("unsafe"), "{policy}");
        assert_eq!(response.headers()[header::X_CONTENT_TYPE_OPTIONS], "nosniff");
        let kind = response.headers()[header::CONTENT_TYPE].to_str().unwrap().to_owned();
        let content = text(response).await;
        assert!(!content.contains("http:") || page.path == "/icon.svg", "{}", page.path);
        if kind.starts_with("text/html") {
            let inline = content.matches("<script").count()
                - content.matches("<script type=\"module\" src=\"/").count();
            assert_eq!(inline, 0, "{}", page.path);
            assert!(!content.contains("style=") && !content.contains(" onclick"), "{}", page.path);
        }
    }
    assert_eq!(get_of("/etc/passwd", &[], &Access::loopback()).await, StatusCode::NOT_FOUND);
}

/// What a page or a script names is there.
#[tokio::test]
async fn nothing_is_named_that_is_not_there() {
    for page in &pages::PAGES {
        let content = text(page.answer()).await;
        for (mark, end) in [("src=\"/", '"'), ("href=\"/", '"'), ("from \"./", '"')] {
            for rest in content.split(mark).skip(1) {
                let path = format!("/{}", rest.split(end).next().unwrap());
                assert_eq!(
                    get_of(&path, &[], &Access::loopback()).await,
                    StatusCode::OK,
                    "{path} of {}",
                    page.path
                );
            }
        }
    }
}

/// Whoever has no token yet gets the page where it is asked for whole: a browser asks for its icon elsewhere, in vain,
/// where it names none.
#[tokio::test]
async fn what_the_sign_in_page_names_is_there_without_a_token() {
    let page = ask(&desk(), &with_token(), request(Method::GET, "/sign-in", &[])).await;
    assert_eq!(page.status(), StatusCode::OK);
    let content = text(page).await;
    assert!(content.contains("<link rel=\"icon\" "), "{content}");
    let named = content.split("href=\"/").skip(1).map(|rest| format!("/{}", rest.split('"').next().unwrap()));
    let named: Vec<_> = named.collect();
    assert_eq!(named.len(), 2, "{named:?}");
    for path in named {
        assert_eq!(get_of(&path, &[], &with_token()).await, StatusCode::OK, "{path}");
    }
}

/// Browsers ask for it once, and then whether it has changed.
#[tokio::test]
async fn the_script_of_the_plots_is_kept() {
    let of = async |tags: &[(&str, &str)]| {
        ask(&desk(), &Access::loopback(), request(Method::GET, "/plotly.js", tags)).await
    };
    let whole = of(&[]).await;
    assert_eq!(whole.headers()[header::CACHE_CONTROL], "private, max-age=604800");
    let tag = whole.headers()[header::ETAG].to_str().unwrap().to_owned();
    let content = to_bytes(whole.into_body(), 8 << 20).await.unwrap();
    assert!(content.starts_with(b"/**\n* plotly.js v") && !content.ends_with(b"</script>"));
    assert!(!content.windows(7).any(|part| part == b"MathJax=" || part == b"<script"));
    let known = of(&[("if-none-match", &format!("\"other\", W/{tag}"))]).await;
    assert_eq!((known.status(), text(known).await.len()), (StatusCode::NOT_MODIFIED, 0));
    assert_eq!(of(&[("if-none-match", "\"other\"")]).await.status(), StatusCode::OK);
    let page = ask(&desk(), &Access::loopback(), request(Method::GET, "/drive", &[])).await;
    assert_eq!(page.headers()[header::CACHE_CONTROL], "no-store");
    assert_eq!(get_of("/plotly.js", &[], &with_token()).await, StatusCode::UNAUTHORIZED);
}

/// A page that multiplies the table out has the arm's own kinematics.
#[tokio::test]
async fn the_links_are_those_of_the_arm() {
    let told = text(ask(&desk(), &Access::loopback(), request(Method::GET, "/api/arm", &[])).await).await;
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    let joints = [0.3, 0.4, -0.5, 0.6, 0.7, -0.8];
    let mut pose = Isometry3::identity();
    for (link, angle) in told["links"].as_array().unwrap().iter().zip(joints) {
        let of = |key: &str| link[key].as_f64().unwrap();
        pose *= UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        pose *= Translation3::new(of("a_m"), 0.0, of("d_m"));
        pose *= UnitQuaternion::from_axis_angle(&Vector3::x_axis(), of("alpha_rad"));
    }
    // the flange is the table's last frame, without a tool
    let config = PumaConfig { tool: Pose::identity(), ..PumaConfig::default() };
    let wrist = Puma560::<f64>::new(&config).unwrap().forward(&joints);
    assert!((pose.translation.vector - wrist.translation).amax() < 1e-9, "{pose} {wrist:?}");
    assert!((pose.rotation.to_rotation_matrix().matrix() - wrist.rotation).amax() < 1e-9);
}

#[tokio::test]
async fn the_checklist_is_asked_for_anew() {
    let desk = desk();
    let asked = async |desk: &Desk| {
        let answer = ask(desk, &Access::loopback(), request(Method::GET, "/api/checklist", &[])).await;
        serde_json::from_str::<serde_json::Value>(&text(answer).await).unwrap()
    };
    assert_eq!(asked(&desk).await["notes"], serde_json::json!([]), "nobody looks");
    let times = AtomicU64::new(0);
    desk.check_by(Box::new(move || Checklist {
        file: Some("tetrad.toml".to_owned()),
        notes: vec![format!("note {}", times.fetch_add(1, Ordering::Relaxed))],
        devices: "Cameras:".to_owned(),
    }));
    assert_eq!(asked(&desk).await["notes"][0], "note 0");
    let again = asked(&desk).await;
    assert_eq!((&again["notes"][0], &again["file"]), (&"note 1".into(), &"tetrad.toml".into()));
    assert_eq!(get_of("/api/checklist", &[], &with_token()).await, StatusCode::UNAUTHORIZED);
    assert_eq!(get_of("/api/arm", &[], &with_token()).await, StatusCode::UNAUTHORIZED);
}

#[tokio::test]
async fn only_its_own_names_are_answered() {
    let access = Access { names: vec!["arm.local".to_owned()], ..Access::loopback() };
    for host in ["127.0.0.1:8080", "localhost:8080", "localhost", "[::1]:9", "ARM.local:8080"] {
        assert_eq!(get_of("/", &[("host", host)], &access).await, StatusCode::OK, "{host}");
    }
    for host in [
        "evil.example:8080",
        "127.0.0.1.evil.example",
        "10.0.0.3:8080",
        "",
        "localhost:8080 x",
        "a@localhost",
    ] {
        let status = get_of("/", &[("host", host)], &access).await;
        assert_eq!(status, StatusCode::MISDIRECTED_REQUEST, "{host}");
    }
    let nameless = Request::builder().uri("/").body(Body::empty()).unwrap();
    assert_eq!(ask(&desk(), &access, nameless).await.status(), StatusCode::MISDIRECTED_REQUEST);
    // elsewhere addresses are its own, whichever it has, and names are not
    let access = Access { loopback: false, tls: true, ..with_token() };
    let bearer = format!("Bearer {TOKEN}");
    let with = |host| [("host", host), ("authorization", bearer.as_str())];
    assert_eq!(get_of("/", &with("10.0.0.3:8443"), &access).await, StatusCode::OK);
    assert_eq!(get_of("/", &with("evil.example"), &access).await, StatusCode::MISDIRECTED_REQUEST);
    // nobody makes a name of the certificate's resolve to it whom the authority has not named so
    let made = rcgen::generate_simple_self_signed(["operator".to_owned()]).unwrap();
    let access = Access { certificate: Some(made.cert.der().clone()), ..access };
    assert_eq!(get_of("/", &with("Operator:8443"), &access).await, StatusCode::OK);
    for host in ["operator.evil.example", "evil.example"] {
        assert_eq!(get_of("/", &with(host), &access).await, StatusCode::MISDIRECTED_REQUEST, "{host}");
    }
}

#[tokio::test]
async fn pages_of_other_sites_get_nowhere() {
    let cross: [&[(&str, &str)]; 5] = [
        &[("origin", "http://evil.example")],
        &[("origin", "null")],
        &[("origin", "http://127.0.0.1:3000")],
        &[("origin", "https://127.0.0.1:8080")],
        &[("sec-fetch-site", "cross-site")],
    ];
    for headers in cross {
        let desk = desk();
        let access = Access::loopback();
        let stop = ask(&desk, &access, request(Method::POST, "/api/stop", headers)).await;
        assert_eq!(stop.status(), StatusCode::FORBIDDEN, "{headers:?}");
        assert!(!desk.buttons().stop);
        for socket in ["/live", "/pictures?views=0"] {
            let upgrade = [&UPGRADE[..], headers].concat();
            assert_eq!(
                get_of(socket, &upgrade, &access).await,
                StatusCode::FORBIDDEN,
                "{socket} {headers:?}"
            );
        }
    }
    let link = [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")];
    assert_eq!(get_of("/drive", &link, &Access::loopback()).await, StatusCode::OK, "a link leads here");
    let form = ask(&desk(), &Access::loopback(), request(Method::POST, "/api/stop", &link)).await;
    assert_eq!(form.status(), StatusCode::FORBIDDEN, "a form does not");
    let own = [("origin", "http://127.0.0.1:8080"), ("sec-fetch-site", "same-origin")];
    let desk = desk();
    let stop = ask(&desk, &Access::loopback(), request(Method::POST, "/api/stop", &own)).await;
    assert_eq!(stop.status(), StatusCode::OK);
    assert!(desk.buttons().stop);
}

#[tokio::test]
async fn without_the_token_nothing_but_health_is_told() {
    let access = with_token();
    let wrong = format!("Bearer {}", TOKEN.replace('0', "1"));
    let cut = format!("Bearer {}", &TOKEN[..31]);
    let tries: [&[(&str, &str)]; 6] = [
        &[],
        &[("authorization", "Bearer ")],
        &[("authorization", &wrong)],
        &[("authorization", &cut)],
        &[("authorization", TOKEN)],
        &[("cookie", "tetrad_token=x; other=0123456789abcdef0123456789abcdef")],
    ];
    for headers in tries {
        for path in ["/", "/drive", "/live.js", "/metrics", "/api/snapshot"] {
            assert_eq!(get_of(path, headers, &access).await, StatusCode::UNAUTHORIZED, "{path} {headers:?}");
        }
        let upgrade = [&UPGRADE[..], headers].concat();
        for socket in ["/live", "/pictures?views=0"] {
            assert_eq!(
                get_of(socket, &upgrade, &access).await,
                StatusCode::UNAUTHORIZED,
                "{socket} {headers:?}"
            );
        }
        let desk = desk();
        let stop = ask(&desk, &access, request(Method::POST, "/api/stop", headers)).await;
        assert_eq!(stop.status(), StatusCode::UNAUTHORIZED);
        assert!(!desk.buttons().stop);
    }
    assert_ne!(get_of("/health", &[], &access).await, StatusCode::UNAUTHORIZED);
    let bearer = format!("Bearer {TOKEN}");
    assert_eq!(get_of("/drive", &[("authorization", &bearer)], &access).await, StatusCode::OK);
    let cookie = format!("a=b; tetrad_token={TOKEN}");
    assert_eq!(get_of("/drive", &[("cookie", &cookie)], &access).await, StatusCode::OK);
    let page = ask(&desk(), &access, request(Method::GET, "/drive", &[("accept", "text/html")])).await;
    assert_eq!(
        (page.status(), page.headers()["location"].to_str().unwrap()),
        (StatusCode::SEE_OTHER, "/sign-in")
    );
}

#[tokio::test]
async fn a_browser_signs_in_once() {
    let sign_in = async |body: String, tls| {
        let access = Access { tls, ..with_token() };
        let mut form = request(Method::POST, "/sign-in", &[]);
        *form.body_mut() = Body::from(body);
        ask(&desk(), &access, form).await
    };
    let refused = sign_in("token=wrong".to_owned(), false).await;
    assert_eq!(refused.status(), StatusCode::UNAUTHORIZED);
    assert_eq!(refused.headers().get("set-cookie"), None);
    assert!(text(refused).await.contains("not the token"));
    let taken = sign_in(format!("token={TOKEN}"), true).await;
    assert_eq!(taken.status(), StatusCode::SEE_OTHER);
    let cookie = taken.headers()["set-cookie"].to_str().unwrap().to_owned();
    for word in ["HttpOnly", "SameSite=Strict", "Secure", "Path=/"] {
        assert!(cookie.contains(word), "{cookie}");
    }
    let pair = cookie.split(';').next().unwrap();
    assert_eq!(get_of("/drive", &[("cookie", pair)], &with_token()).await, StatusCode::OK);
}

#[tokio::test]
async fn a_body_that_is_too_large_is_not_read() {
    let desk = desk();
    let mut large = request(Method::POST, "/api/stop", &[("content-length", "65537")]);
    *large.body_mut() = Body::from(vec![0; 65_537]);
    assert_eq!(ask(&desk, &Access::loopback(), large).await.status(), StatusCode::PAYLOAD_TOO_LARGE);
    let nonsense = request(Method::POST, "/api/stop", &[("content-length", "99999999999999999999")]);
    assert_eq!(ask(&desk, &Access::loopback(), nonsense).await.status(), StatusCode::PAYLOAD_TOO_LARGE);
    // nor one whose length nobody tells
    let mut endless = request(Method::POST, "/sign-in", &[]);
    *endless.body_mut() = Body::from(format!("token={}", "x".repeat(MAX_BODY)));
    assert_eq!(ask(&desk, &with_token(), endless).await.status(), StatusCode::PAYLOAD_TOO_LARGE);
    assert!(!desk.buttons().stop);
}

#[tokio::test]
async fn a_body_that_never_comes_is_not_waited_for() {
    let mut slow = request(Method::POST, "/sign-in", &[("content-length", "10")]);
    *slow.body_mut() = Body::from_stream(futures_util::stream::pending::<Result<Vec<u8>, std::io::Error>>());
    let (access, web_sockets) = (Arc::new(with_token()), Arc::new(Semaphore::new(1)));
    let state =
        State { desk: desk(), access, sessions: None, web_sockets, within: Duration::from_millis(10) };
    let answer = routes(state).oneshot(slow).await.unwrap();
    assert_eq!(answer.status(), StatusCode::REQUEST_TIMEOUT);
}

#[tokio::test]
async fn only_a_post_stops() {
    let desk = desk();
    let response = ask(&desk, &Access::loopback(), request(Method::GET, "/api/stop", &[])).await;
    assert_eq!(response.status(), StatusCode::METHOD_NOT_ALLOWED);
    assert!(!desk.buttons().stop);
    let response = ask(&desk, &Access::loopback(), request(Method::POST, "/api/stop", &[])).await;
    assert_eq!(text(response).await, "stopped\n");
    assert!(desk.buttons().stop);
}

#[tokio::test]
async fn health_is_that_of_the_loop() {
    let clock = Clock::given();
    let desk_of = |views| Desk::new(true, views, clock.clone(), Doorbell::default());
    let desk = desk_of(vec![("left".to_owned(), ViewKind::Hand)]);
    let health = async || ask(&desk, &with_token(), request(Method::GET, "/health", &[])).await.status();
    clock.set(5_000_000);
    assert_eq!(health().await, StatusCode::SERVICE_UNAVAILABLE);
    desk.publish(Snapshot { time_us: 4_500_000, ..Snapshot::default() });
    assert_eq!(health().await, StatusCode::OK);
    clock.set(5_500_001);
    assert_eq!(health().await, StatusCode::SERVICE_UNAVAILABLE);
    // no station, no loop
    let alone = ask(&desk_of(Vec::new()), &with_token(), request(Method::GET, "/health", &[])).await;
    assert_eq!(alone.status(), StatusCode::OK);
}

/// What the server goes by when it has to close a connection.
#[tokio::test]
async fn a_connection_is_known_by_what_it_was_trusted_with() {
    use crate::console::room::Room;
    let bearer = format!("Bearer {TOKEN}");
    let (wrong, right) = ("Bearer 0123456789abcdef", bearer.as_str());
    let tries = [
        ("/drive", None, with_token(), false),
        ("/health", None, with_token(), false),
        ("/sign-in", None, with_token(), false),
        ("/drive", Some(("authorization", wrong)), with_token(), false),
        ("/drive", Some(("authorization", right)), with_token(), true),
        ("/health", Some(("authorization", right)), with_token(), true),
        ("/drive", None, Access::loopback(), true),
        ("/drive", Some(("host", "evil.example")), Access::loopback(), false),
    ];
    for (path, header, access, known) in tries {
        let desk = desk();
        let room = Room::new(desk.clone(), 2);
        let from = "10.0.0.1".parse().unwrap();
        let (first, second) = (room.admit(from).await.unwrap(), room.admit(from).await.unwrap());
        let mut asked = request(Method::GET, path, header.as_slice());
        asked.extensions_mut().insert(first.ticket());
        ask(&desk, &access, asked).await;
        // of the two that are here the one that was here longer leaves, unless it is known
        let (first, second) = (leaves(first), leaves(second));
        room.admit(from).await.unwrap();
        let left = tokio::select! { _ = first => "first", _ = second => "second" };
        assert_eq!(left, if known { "second" } else { "first" }, "{path} {header:?}");
    }
}

/// Goes when it is told to.
fn leaves(place: crate::console::room::Place) -> tokio::task::JoinHandle<()> {
    tokio::spawn(async move { place.leave().notified().await })
}
