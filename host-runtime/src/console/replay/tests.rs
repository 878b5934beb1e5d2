use super::*;
use crate::console::app::app;
use crate::console::snapshot::SILENT_US;
use crate::console::{Access, Desk, Token};
use crate::link::Doorbell;
use crate::robot::clock::Clock;
use crate::session::testing::{PERIOD_US, SIZE, small};
use axum::Router;
use axum::body::to_bytes;
use axum::http::{Method, Request};
use serde_json::Value;
use std::fs;
use std::time::Duration;
use tempfile::TempDir;
use tower::ServiceExt as _;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;

/// A console that shows the sessions of a folder.
struct Page {
    dir: TempDir,
    routes: Router,
}

impl Page {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let sessions = Arc::new(Sessions::new(dir.path().to_owned()));
        Self { dir, routes: app(desk(), Access::loopback(), Some(sessions)) }
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.dir.path().join(name)
    }

    async fn ask(&self, method: Method, path: &str) -> Response {
        let request = Request::builder().method(method).uri(path).header("host", "127.0.0.1:8080");
        self.routes.clone().oneshot(request.body(Body::empty()).unwrap()).await.unwrap()
    }

    async fn get(&self, path: &str) -> (StatusCode, String) {
        let answer = self.ask(Method::GET, path).await;
        (answer.status(), String::from_utf8(bytes(answer).await).unwrap())
    }

    async fn json(&self, path: &str) -> Value {
        let (status, text) = self.get(path).await;
        assert_eq!(status, StatusCode::OK, "{path}: {text}");
        serde_json::from_str(&text).unwrap()
    }
}

async fn bytes(answer: Response) -> Vec<u8> {
    to_bytes(answer.into_body(), 64 << 20).await.unwrap().to_vec()
}

fn desk() -> Desk {
    Desk::new(false, Vec::new(), Clock::given(), Doorbell::default())
}

#[tokio::test]
async fn sessions_are_listed_and_nothing_else() {
    let page = Page::new();
    for name in ["a.mcap", "b b.mcap"] {
        small(&page.path(name), 3);
    }
    fs::write(page.path("notes.txt"), "x").unwrap();
    fs::write(page.path(".hidden.mcap"), "x").unwrap();
    fs::create_dir(page.path("folder.mcap")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("/etc/hostname", page.path("link.mcap")).unwrap();
    let listed = page.json("/api/sessions").await;
    let mut names: Vec<&str> =
        listed["sessions"].as_array().unwrap().iter().filter_map(|one| one["name"].as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["a.mcap", "b b.mcap"]);
    assert!(listed["sessions"][0]["bytes"].as_u64().unwrap() > 600_000);
    assert_eq!(page.json("/api/sessions/b%20b.mcap").await["moments"], 3);
    // a folder that is not there yet has none
    let routes = app(desk(), Access::loopback(), Some(Arc::new(Sessions::new(page.path("later")))));
    let later = Page { dir: tempfile::tempdir().unwrap(), routes };
    assert_eq!(later.json("/api/sessions").await["sessions"], serde_json::json!([]));
}

#[tokio::test]
async fn a_session_is_shown_moment_by_moment() {
    let page = Page::new();
    small(&page.path("a.mcap"), 30);
    let about = page.json("/api/sessions/a.mcap").await;
    assert_eq!(
        (&about["moments"], &about["cut"], &about["mode"]),
        (&30.into(), &false.into(), &"refined".into())
    );
    assert_eq!(about["first_us"], 0);
    assert_eq!(about["length_us"], 29 * PERIOD_US + 2);
    assert_eq!(about["cameras"][0]["pictures"], 30);
    assert_eq!((&about["cameras"][1]["name"], &about["cameras"][1]["pictures"]), (&"afar".into(), &0.into()));
    let t_us = 12 * PERIOD_US + 30_000;
    let at = page.json(&format!("/api/sessions/a.mcap/moment?t_us={t_us}")).await;
    assert_eq!((&at["number"], &at["previous_us"]), (&13.into(), &(11 * PERIOD_US).into()));
    assert_eq!(at["next_us"], 13 * PERIOD_US);
    assert_eq!(at["cameras"][0]["age_us"], 30_000);
    assert_eq!(at["cameras"][1]["age_us"], Value::Null);
    let red = &at["cameras"][0]["balls"][0];
    assert_eq!(
        (&red["name"], &red["state"], &red["centre"][0]),
        (&"red".into(), &"visible".into(), &12.0.into())
    );
    assert_eq!(at["hand"]["position_mm"], serde_json::json!([12.0, 0.0, 500.0]));
    assert_eq!((&at["arm"]["standing"], &at["arm"]["scale"]), (&"engaged".into(), &0.25.into()));
    let told =
        ["the arm is home; let go", "slowed: wrist singularity (joints 4 and 6 in line); turn the tool away"];
    assert_eq!(
        at["arm"]["slowed"],
        serde_json::json!(told),
        "what slows it says so itself, and a note does not"
    );
    let buttons =
        serde_json::json!({"pressed": true, "stop": false, "resets": 0, "home": true, "scale_percent": 25});
    assert_eq!((&at["buttons"], &at["lines"][4]["text"]), (&buttons, &"line 12".into()));
    let picture = page.ask(Method::GET, &format!("/api/sessions/a.mcap/picture?camera=0&t_us={t_us}")).await;
    assert_eq!(picture.headers()[header::CONTENT_TYPE], "image/jpeg");
    let jpeg = bytes(picture).await;
    let mut decoder = JpegDecoder::new(ZCursor::new(&jpeg));
    let pixels = decoder.decode().unwrap();
    assert_eq!(decoder.dimensions(), Some((usize::from(SIZE.0), usize::from(SIZE.1))));
    assert!(pixels.iter().all(|shade| shade.abs_diff(12) <= 2), "the shade of picture 12");
    let first = page.json("/api/sessions/a.mcap/moment?t_us=0").await;
    assert_eq!(
        (&first["number"], &first["previous_us"], &first["arm"]),
        (&1.into(), &Value::Null, &Value::Null)
    );
    let last = page.json("/api/sessions/a.mcap/moment?t_us=99999999999").await;
    assert_eq!((&last["number"], &last["next_us"]), (&30.into(), &Value::Null));
}

/// An arm that was engaged when its slave died is not shown as engaged ever after.
#[tokio::test]
async fn what_was_silent_is_shown_as_not_known() {
    let page = Page::new();
    small(&page.path("a.mcap"), 3);
    let last_us = 2 * PERIOD_US;
    let at = async |t_us: u64| page.json(&format!("/api/sessions/a.mcap/moment?t_us={t_us}")).await;
    let fresh = at(last_us + SILENT_US).await;
    let arm = &fresh["arm"];
    assert_eq!((&arm["silent"], &arm["standing"]), (&false.into(), &"engaged".into()));
    assert_eq!((&arm["speed_share"], &arm["slowed"][1].is_string()), (&0.5.into(), &true));
    assert_eq!(fresh["hand"]["silent"], false);
    // the arm and what the other station's camera saw came a little later than the hand and the picture
    let between = at(last_us + SILENT_US + 1).await;
    assert_eq!((&between["arm"]["silent"], &between["hand"]["silent"]), (&false.into(), &true.into()));
    let old = at(last_us + 3_200_002).await;
    let arm = &old["arm"];
    assert_eq!((&arm["silent"], &arm["state"]), (&true.into(), &"engaged".into()));
    assert_eq!(arm["standing"], "silent for 3.2 s: nobody knows what the arm does");
    assert_eq!((&arm["speed_share"], &arm["slowed"]), (&Value::Null, &serde_json::json!([])));
    for (moment, stale) in [(&fresh, [false, false]), (&between, [true, false]), (&old, [true, true])] {
        let told = [0, 1].map(|camera| &moment["cameras"][camera]["stale"]);
        assert_eq!(told, stale.map(Value::from).each_ref());
    }
}

#[tokio::test]
async fn no_other_file_can_be_named() {
    let page = Page::new();
    small(&page.path("a.mcap"), 2);
    let outside = tempfile::tempdir().unwrap();
    small(&outside.path().join("b.mcap"), 2);
    let away = outside.path().file_name().unwrap().to_str().unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(outside.path().join("b.mcap"), page.path("link.mcap")).unwrap();
    fs::create_dir(page.path("in")).unwrap();
    small(&page.path("in/c.mcap"), 2);
    let names = [
        format!("..%2F{away}%2Fb.mcap"),
        format!("../{away}/b.mcap"),
        format!("%2E%2E%2F{away}%2Fb.mcap"),
        outside.path().join("b.mcap").to_str().unwrap().replace('/', "%2F"),
        "link.mcap".to_owned(),
        "in%2Fc.mcap".to_owned(),
        "in/c.mcap".to_owned(),
        ".%2Fa.mcap".to_owned(),
        "a.mcap%2F".to_owned(),
        "a.mcap%00".to_owned(),
        "%ff.mcap".to_owned(),
        "..".to_owned(),
        "a".to_owned(),
    ];
    for name in names {
        for rest in ["", "/moment?t_us=0", "/picture?camera=0&t_us=0", "/whole", "/files/report.html"] {
            let (status, text) = page.get(&format!("/api/sessions/{name}{rest}")).await;
            assert!(
                status.is_client_error() && status != StatusCode::UNPROCESSABLE_ENTITY,
                "{name}{rest}: {text}"
            );
        }
        let begun = page.ask(Method::POST, &format!("/api/sessions/{name}/whole")).await.status();
        assert!(begun.is_client_error(), "{name}: {begun}");
    }
    assert_eq!(page.json("/api/sessions/a.mcap").await["moments"], 2, "and its own is there");
}

/// Asks until all of it was read.
async fn read(page: &Page, name: &str) -> Value {
    let address = format!("/api/sessions/{name}/whole");
    let mut told: Value =
        serde_json::from_slice(&bytes(page.ask(Method::POST, &address).await).await).unwrap();
    for _ in 0..1_200 {
        if told["state"] != "reading" {
            return told;
        }
        assert!((0.0..=1.0).contains(&told["share"].as_f64().unwrap()), "{told}");
        tokio::time::sleep(Duration::from_millis(50)).await;
        told = page.json(&address).await;
    }
    panic!("{name} is not read in a minute: {told}");
}

#[tokio::test]
async fn all_of_it_becomes_plots_and_files() {
    let page = Page::new();
    small(&page.path("a.mcap"), 30);
    small(&page.path("b.mcap"), 2);
    assert_eq!(page.json("/api/sessions/a.mcap/whole").await["state"], "none");
    let told = read(&page, "a.mcap").await;
    assert_eq!(told["state"], "ready", "{told}");
    let titles: Vec<_> =
        told["sections"].as_array().unwrap().iter().map(|one| one["title"].clone()).collect();
    assert_eq!(titles, ["The balls", "The hand", "The arm"]);
    let place = &told["sections"][1]["panels"][0];
    assert_eq!(place["data"][0]["x"].as_array().unwrap().len(), 30);
    assert!(place["layout"]["xaxis"].is_object());
    let named: Vec<_> = told["files"].as_array().unwrap().iter().map(|one| one["name"].clone()).collect();
    for file in
        ["observations.csv", "pose.csv", "filtered.csv", "arm.csv", "buttons.csv", "log.csv", "report.html"]
    {
        assert!(named.iter().any(|name| name == file), "{file} of {named:?}");
    }
    let saved = page.ask(Method::GET, "/api/sessions/a.mcap/files/pose.csv").await;
    assert_eq!(saved.headers()[header::CONTENT_DISPOSITION], "attachment; filename=\"a-pose.csv\"");
    let pose = String::from_utf8(bytes(saved).await).unwrap();
    assert_eq!(pose.lines().count(), 1 + 30);
    let (status, report) = page.get("/api/sessions/a.mcap/files/report.html").await;
    assert_eq!(status, StatusCode::OK);
    assert!(report.contains("<h1>Session a.mcap</h1>") && report.ends_with("</html>\n"));
    for named in ["(balls.svg)", "(hand.svg)", "(channels.csv)"] {
        assert!(!report.contains(named), "there is no such file beside it: {named}");
    }
    for file in ["nothing.csv", "..%2Fa.mcap", "%2Fetc%2Fhostname"] {
        let (status, text) = page.get(&format!("/api/sessions/a.mcap/files/{file}")).await;
        assert_eq!(status, StatusCode::NOT_FOUND, "{file}: {text}");
    }
    // one at a time is kept
    assert_eq!(read(&page, "b.mcap").await["state"], "ready");
    assert_eq!(page.get("/api/sessions/a.mcap/files/pose.csv").await.0, StatusCode::NOT_FOUND);
}

fn refused(name: &str, status: StatusCode, text: &str, words: &[&str]) {
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "{name}: {text}");
    for word in words {
        assert!(text.contains(word), "{name}: no {word} in {text}");
    }
}

#[tokio::test]
async fn files_that_are_no_sessions_say_why() {
    let page = Page::new();
    small(&page.path("whole.mcap"), 30);
    let whole = fs::read(page.path("whole.mcap")).unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(page.path(name), bytes).unwrap();
    write("words.mcap", b"no film");
    write("empty.mcap", b"");
    write("short.mcap", &whole[..100]);
    write("cut.mcap", &whole[..whole.len() - 1_000_000]);
    let mut flipped = whole.clone();
    let middle = flipped.len() - 500_000;
    flipped[middle] ^= 1;
    write("flipped.mcap", &flipped);
    for (name, words) in
        [("words.mcap", "no MCAP file"), ("empty.mcap", "no MCAP file"), ("short.mcap", "cut short")]
    {
        for rest in ["", "/moment?t_us=0", "/picture?camera=0&t_us=0"] {
            let (status, text) = page.get(&format!("/api/sessions/{name}{rest}")).await;
            refused(name, status, &text, &[name, words]);
        }
        let told = read(&page, name).await;
        assert_eq!(told["state"], "failed");
        assert!(told["why"].as_str().unwrap().contains(words), "{told}");
    }
    let cut = page.json("/api/sessions/cut.mcap").await;
    assert_eq!(cut["cut"], true);
    assert!((1..30).contains(&cut["moments"].as_u64().unwrap()), "{cut}");
    let told = read(&page, "cut.mcap").await;
    assert_eq!(told["state"], "ready", "as far as it goes");
    let last = "/api/sessions/flipped.mcap/moment?t_us=99999999";
    let (status, text) = page.get(last).await;
    refused("flipped.mcap", status, &text, &["damaged at byte", "check sum"]);
    assert_eq!(
        page.get("/api/sessions/flipped.mcap/moment?t_us=0").await.0,
        StatusCode::OK,
        "what is good is shown"
    );
    assert!(read(&page, "flipped.mcap").await["why"].as_str().unwrap().contains("damaged at byte"));
}

#[tokio::test]
async fn questions_that_make_no_sense_are_answered_in_words() {
    let page = Page::new();
    small(&page.path("a.mcap"), 2);
    for (rest, word) in [
        ("moment", "t_us=N"),
        ("moment?t_us=", "t_us=N"),
        ("moment?t_us=-1", "t_us=N"),
        ("moment?t_us=99999999999999999999", "t_us=N"),
        ("picture?t_us=0", "camera=N"),
        ("picture?camera=left&t_us=0", "camera=N"),
    ] {
        let (status, text) = page.get(&format!("/api/sessions/a.mcap/{rest}")).await;
        assert_eq!(status, StatusCode::BAD_REQUEST, "{rest}");
        assert!(text.contains(word), "{rest}: {text}");
    }
    for camera in ["1", "2", "18446744073709551615"] {
        let (status, _) = page.get(&format!("/api/sessions/a.mcap/picture?camera={camera}&t_us=0")).await;
        assert_eq!(status, StatusCode::NOT_FOUND, "camera {camera}");
    }
    let late = page.get("/api/sessions/a.mcap/moment?t_us=18446744073709551615").await;
    assert_eq!(late.0, StatusCode::OK, "after the end is the end");
    let nowhere = app(desk(), Access::loopback(), None);
    let nowhere = Page { dir: tempfile::tempdir().unwrap(), routes: nowhere };
    let (status, text) = nowhere.get("/api/sessions/a.mcap").await;
    assert_eq!(status, StatusCode::NOT_FOUND);
    assert!(text.contains("[console]") && text.contains("--record"), "{text}");
    let listed = nowhere.json("/api/sessions").await;
    assert_eq!((&listed["folder"], &listed["sessions"]), (&Value::Null, &serde_json::json!([])));
    assert_eq!(listed["why"].as_str(), Some(text.trim_end()));
}

#[tokio::test]
async fn sessions_are_shown_to_whom_the_console_is() {
    let dir = tempfile::tempdir().unwrap();
    small(&dir.path().join("a.mcap"), 2);
    let token = Token::parse("0123456789abcdef0123456789abcdef").unwrap();
    let access = Access { token: Some(token), ..Access::loopback() };
    let sessions = Arc::new(Sessions::new(dir.path().to_owned()));
    let page = Page { dir, routes: app(desk(), access, Some(sessions)) };
    for path in ["", "/a.mcap", "/a.mcap/moment?t_us=0", "/a.mcap/picture?camera=0&t_us=0", "/a.mcap/files/x"]
    {
        assert_eq!(page.get(&format!("/api/sessions{path}")).await.0, StatusCode::UNAUTHORIZED, "{path}");
    }
}

/// What was read whole is not left behind.
#[tokio::test]
async fn files_go_with_the_console() {
    let page = Page::new();
    small(&page.path("a.mcap"), 2);
    let whole = whole::Whole::begin("a.mcap", &page.path("a.mcap"), 1).unwrap();
    for _ in 0..1_200 {
        if whole.file("pose.csv").is_some() {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let folder = whole.folder().expect("it is read").to_owned();
    assert!(folder.join("report.html").is_file());
    drop(whole);
    // the thread that made it may still be ending
    for _ in 0..1_200 {
        if !folder.exists() {
            return;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    panic!("{} is left behind", folder.display());
}
