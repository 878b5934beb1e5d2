mod room;
mod search;

use super::*;
use crate::colours::Colours;
use crate::console::access::MAX_BODY;
use crate::console::control::Tab;
use crate::console::snapshot::{SILENT_US, Snapshot};
use axum::http::{Method, StatusCode};
use room::{Room, bytes, desk, room};
use serde_json::{Value, json};
use std::time::Instant;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::wire::PressFor;

/// Every POST there is, with a body that would be taken.
fn posts() -> [(&'static str, Value); 8] {
    [
        ("/api/setup/still", json!({})),
        ("/api/setup/find", json!({})),
        ("/api/setup/point", json!({"camera": 0, "ball": "red", "u": 10, "v": 10})),
        ("/api/setup/use", json!({})),
        ("/api/setup/arm", json!({"arm_mm": 70})),
        ("/api/setup/save", json!({"camera": 0})),
        ("/api/setup/load", json!({"camera": 0})),
        ("/api/setup/colours", json!({"camera": 0, "file": "a.toml", "text": ""})),
    ]
}

#[tokio::test]
async fn found_used_and_tracked_on() {
    let room = room();
    let (status, begin) = room.get("/api/setup?page=1").await;
    assert_eq!(status, StatusCode::OK);
    assert_eq!((&begin["arm_mm"], &begin["arm_file"]), (&json!(80.0), &Value::Null));
    assert_eq!(begin["cameras"][0]["balls"][3]["how"], "in use");
    assert_eq!(begin["cameras"][0]["still"], Value::Null);

    let before = room.taught(0);
    let found = room.done("/api/setup/find", json!({"page": 1})).await;
    assert_eq!(found["said"], "the four balls were found by 2 of 2 cameras");
    for (camera, places) in room.places.iter().enumerate() {
        let camera = &found["cameras"][camera];
        assert!(camera["said"].as_str().unwrap().starts_with("all four balls found: "), "{camera}");
        for (ball, place) in camera["balls"].as_array().unwrap().iter().zip(places) {
            let at = |key: &str| ball["found"][key].as_f64().expect("it is found") as f32;
            let off = ImagePoint::new(at("u"), at("v")).distance(*place);
            assert!(off < 2.0, "{ball}: {off} px off");
            assert!(ball["clash"].as_str().unwrap().starts_with("well apart"), "{ball}");
            assert!(!ball["reference"]["name"].as_str().unwrap().is_empty());
        }
    }
    assert_eq!(room.taught(0), before, "a draft changes nothing");
    assert!(!room.desk.buttons().stop);

    let used = room.done("/api/setup/use", json!({"page": 1})).await;
    assert_eq!((&used["cameras"][0]["in_use"], &used["cameras"][1]["in_use"]), (&json!(true), &json!(true)));
    assert!(room.desk.buttons().stop, "the arm stops first");
    assert_eq!(room.desk.take_arms().map(|arms| arms.lengths_m()), Some([0.08; 3]));
    assert!(room.desk.take_arms().is_none(), "once");
    // the next picture is looked at with what was found
    let (send, sent) = std::sync::mpsc::channel();
    room.threads[0].handle().grab(Box::new(move |still| send.send(still).unwrap()));
    let still = sent.recv_timeout(Duration::from_secs(60)).unwrap();
    for (seen, place) in still.packet.balls.iter().zip(room.places[0]) {
        assert!(seen.state.is_measured() && seen.centre.distance(place) < 2.0, "{seen:?}");
    }
    // it is told once that picture is done with
    let told = || room.threads[0].take_notices().iter().any(|line| line.contains("taught anew"));
    let until = Instant::now() + Duration::from_secs(60);
    while !told() {
        assert!(Instant::now() < until, "the operator is not told");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[tokio::test]
async fn pointed_at_one_after_the_other() {
    let room = room();
    let red = room.places[0][0];
    let point = |u: f32, v: f32| json!({"camera": 0, "ball": "red", "u": u, "v": v});
    let early = room.post("/api/setup/point", point(red.u, red.v)).await;
    assert_eq!(Room::why(early, StatusCode::CONFLICT), "left: there is no still picture yet: take one first");
    let still = room.done("/api/setup/still", json!({})).await;
    assert_eq!(
        (&still["cameras"][0]["still"]["width"], &still["cameras"][0]["still"]["number"]),
        (&json!(640), &json!(1))
    );
    let told = room.done("/api/setup/point", point(red.u, red.v)).await;
    let ball = &told["cameras"][0]["balls"][0];
    assert_eq!(
        (&ball["how"], &told["cameras"][0]["balls"][1]["how"]),
        (&json!("pointed at"), &json!("in use"))
    );
    assert_eq!(told["cameras"][0]["in_use"], json!(told["cameras"][0]["in_use"].as_bool().unwrap()));

    let beside =
        Room::why(room.post("/api/setup/point", point(5.0, 5.0)).await, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(beside.starts_with("left: red at (5, 5): "), "{beside}");
    let (_, after) = room.get("/api/setup").await;
    assert_eq!(after["cameras"][0]["balls"][0], *ball, "what was known stays");
    for (u, v) in [(-1.0, 5.0), (5.0, 480.0), (1e9, 5.0)] {
        let outside = room.post("/api/setup/point", point(u, v)).await;
        let why = Room::why(outside, StatusCode::UNPROCESSABLE_ENTITY);
        assert!(why.contains("outside the picture of 640x480 pixels"), "{why}");
    }
}

#[tokio::test]
async fn what_cannot_be_meant_is_refused_with_words() {
    let room = room();
    let bad = [
        ("/api/setup/point", "{", "EOF"),
        ("/api/setup/point", "{\"camera\": 0, \"ball\": \"pink\", \"u\": 1, \"v\": 1}", "pink"),
        ("/api/setup/point", "{\"camera\": -1, \"ball\": \"red\", \"u\": 1, \"v\": 1}", "-1"),
        ("/api/setup/point", "{\"camera\": 0, \"ball\": \"red\", \"u\": \"a\", \"v\": 1}", "string"),
        ("/api/setup/find", "[]", "invalid"),
        ("/api/setup/find", "{\"pages\": 1}", "pages"),
        ("/api/setup/use", "", "EOF"),
        ("/api/setup/arm", "{\"arm_mm\": null}", "null"),
    ];
    for (path, body, word) in bad {
        let (status, answer) = room.bytes(Method::POST, path, body.to_owned()).await;
        let told: Value = serde_json::from_slice(&answer).unwrap();
        let why = Room::why((status, told), StatusCode::BAD_REQUEST);
        assert!(why.starts_with("this is not understood: ") && why.contains(word), "{path} {body}: {why}");
    }
    for path in
        ["/api/setup/scan?camera=0", "/api/setup/still?camera=x", "/api/setup/colours", "/api/setup?page=a"]
    {
        Room::why(room.get(path).await, StatusCode::BAD_REQUEST);
    }
    let nobody = room.post("/api/setup/find", json!({"camera": 7})).await;
    assert_eq!(
        Room::why(nobody, StatusCode::NOT_FOUND),
        "there is no camera 7: they are counted from 0, and there are 3"
    );
    let far = room.post("/api/setup/find", json!({"camera": 2})).await;
    assert_eq!(Room::why(far, StatusCode::UNPROCESSABLE_ENTITY), "far: it is at another computer");
    for mm in [4.0, -80.0, 1e30] {
        let why = Room::why(
            room.post("/api/setup/arm", json!({"arm_mm": mm})).await,
            StatusCode::UNPROCESSABLE_ENTITY,
        );
        assert!(why.starts_with("[operator] arm_mm: a number from 5 to 2000 mm is needed"), "{why}");
    }
    assert!(room.desk.take_arms().is_none() && !room.desk.buttons().stop, "nothing was set up");
}

#[tokio::test]
async fn only_the_page_in_control_sets_up() {
    let room = room();
    room.desk.control().take(Tab(1), "the first", 0).unwrap();
    for (path, mut body) in posts() {
        for page in [None, Some(2)] {
            body["page"] = json!(page);
            let why = Room::why(room.post(path, body.clone()).await, StatusCode::CONFLICT);
            assert!(why.starts_with("the first is in control"), "{path}: {why}");
        }
    }
    let (_, told) = room.get("/api/setup?page=2").await;
    assert!(told["not_now"].as_str().unwrap().starts_with("the first is in control"));
    let (_, told) = room.get("/api/setup?page=1").await;
    assert_eq!(told["not_now"], Value::Null);
    room.done("/api/setup/find", json!({"page": 1})).await;
}

#[tokio::test]
async fn nothing_is_set_up_while_the_arm_follows_the_hand() {
    let room = room();
    let before = [room.taught(0), room.taught(1)];
    room.engage();
    for (path, body) in posts() {
        let why = Room::why(room.post(path, body).await, StatusCode::CONFLICT);
        assert_eq!(why, "the arm follows the hand: let go of the button first, then set up", "{path}");
    }
    // nor where the button is held, and nothing of the arm was heard yet
    room.desk.publish(Snapshot::default());
    {
        let mut control = room.desk.control();
        let now_us = room.clock.now_us();
        control.take(Tab(1), "a", now_us).unwrap();
        control.release(Tab(1), now_us);
        control.hold(Tab(1), 1, PressFor::Follow, now_us, now_us).unwrap();
    }
    for (path, mut body) in posts() {
        body["page"] = json!(1);
        Room::why(room.post(path, body).await, StatusCode::CONFLICT);
    }
    assert!(room.desk.buttons().pressed && !room.desk.buttons().stop, "and it goes on");
    assert_eq!([room.taught(0), room.taught(1)], before);
    assert!(room.desk.take_arms().is_none());
}

#[tokio::test]
async fn an_arm_that_nobody_hears_keeps_nobody_from_setting_up() {
    let room = room();
    room.engaged(SILENT_US);
    assert!(room.get("/api/setup?page=1").await.1["not_now"].is_string());
    room.engaged(SILENT_US + 1);
    assert_eq!(room.get("/api/setup?page=1").await.1["not_now"], Value::Null);
    room.done("/api/setup/find", json!({"page": 1})).await;
}

#[tokio::test]
async fn colours_are_saved_loaded_sent_and_taken() {
    let room = room();
    let file = room.dir.path().join("colours-left.toml");
    let missing = room.post("/api/setup/load", json!({"camera": 0})).await;
    let why = Room::why(missing, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(why.starts_with(&format!("cannot read {}", file.display())), "{why}");
    room.done("/api/setup/find", json!({})).await;
    let without = room.post("/api/setup/save", json!({})).await;
    let why = Room::why(without, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(why.starts_with("right: no file keeps its colours: "), "{why}");
    assert!(!file.exists(), "all or nothing");
    let saved = room.done("/api/setup/save", json!({"camera": 0})).await;
    assert_eq!(saved["said"], format!("saved: {}", file.display()));

    let (status, sent) = room.bytes(Method::GET, "/api/setup/colours?camera=0", String::new()).await;
    let sent = String::from_utf8(sent).unwrap();
    assert_eq!((status, &sent), (StatusCode::OK, &std::fs::read_to_string(&file).unwrap()));
    let colours = Colours::parse(&sent, "sent").unwrap();
    assert_eq!(colours.origin.as_ref().unwrap().source, "left");
    let taken = json!({"camera": 1, "file": "mine.toml", "text": sent});
    let told = room.done("/api/setup/colours", taken).await;
    assert_eq!(told["cameras"][1]["balls"][2]["how"], "from a file");
    assert_eq!(told["said"], "right: loaded from mine.toml; not in use yet");

    let wrong = [
        (sent.replace("[red]", "[rot]"), "mine.toml: [rot]: unknown table"),
        (
            sent.replacen("diameter_px = ", "diameter_px = -", 1),
            "mine.toml: [red] diameter_px: a number from",
        ),
        (
            sent.split_once("[yellow]").unwrap().0.to_owned(),
            "mine.toml: [yellow]: the yellow ball is missing",
        ),
        ("no toml".to_owned(), "mine.toml: not TOML"),
        (String::new(), "mine.toml: it has no ball"),
    ];
    for (text, expected) in wrong {
        let answer =
            room.post("/api/setup/colours", json!({"camera": 0, "file": "mine.toml", "text": text})).await;
        let why = Room::why(answer, StatusCode::UNPROCESSABLE_ENTITY);
        assert!(why.starts_with(expected), "{why}");
    }
    let large = json!({"camera": 0, "file": "a", "text": "#".repeat(MAX_BODY)});
    assert_eq!(room.post("/api/setup/colours", large).await.0, StatusCode::PAYLOAD_TOO_LARGE);

    std::fs::write(&file, sent.replacen("typical", "typisch", 1)).unwrap();
    let why =
        Room::why(room.post("/api/setup/load", json!({"camera": 0})).await, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(why.starts_with(&format!("{}: [red] typisch: unknown key", file.display())), "{why}");
    std::fs::write(&file, &sent).unwrap();
    let told = room.done("/api/setup/load", json!({"camera": 0})).await;
    assert_eq!(told["cameras"][0]["balls"][0]["how"], "from a file");
    assert!(told["cameras"][0]["balls"][0]["clash"].is_string(), "it is judged in the still picture");
}

#[tokio::test]
async fn only_the_camera_that_is_meant_is_taught() {
    let room = room();
    let (_, sent) = room.bytes(Method::GET, "/api/setup/colours?camera=0", String::new()).await;
    let larger = |line: &str| match line.starts_with("diameter_px") {
        true => "diameter_px = 40.5".to_owned(),
        false => line.to_owned(),
    };
    let text: Vec<_> = String::from_utf8(sent).unwrap().lines().map(larger).collect();
    for camera in [0, 1] {
        let body = json!({"camera": camera, "file": "a.toml", "text": text.join("\n")});
        let told = room.done("/api/setup/colours", body).await;
        assert_eq!(told["cameras"][camera]["in_use"], json!(false));
    }
    let used = room.done("/api/setup/use", json!({"camera": 0})).await;
    assert_eq!((&used["cameras"][0]["in_use"], &used["cameras"][1]["in_use"]), (&json!(true), &json!(false)));
    let diameters = [0, 1].map(|camera| room.taught(camera)[0].unwrap().diameter);
    assert!(diameters[0] == 40.5 && diameters[1] < 40.0, "{diameters:?}");
}

#[tokio::test]
async fn the_arms_length_is_used_and_kept() {
    let room = room();
    let told = room.done("/api/setup/arm", json!({"arm_mm": 62.5})).await;
    assert_eq!(
        (&told["arm_mm"], room.desk.take_arms().map(|arms| arms.lengths_m())),
        (&json!(62.5), Some([0.0625; 3]))
    );
    assert!(told["said"].as_str().unwrap().contains("no file keeps it"));
    assert!(room.desk.buttons().stop);

    let (_, desk) = desk();
    let file = room.dir.path().join("tetrad.toml");
    std::fs::write(&file, "[operator]\narm_mm = 80 # of the frame\n").unwrap();
    desk.set_up_with(SetUp::new(Vec::new(), 0.08, Some(file.clone())));
    let body = json!({"arm_mm": 70}).to_string();
    let (status, _) = bytes(&desk, Method::POST, "/api/setup/arm", body.clone()).await;
    assert_eq!(status, StatusCode::OK);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "[operator]\narm_mm = 70 # of the frame\n");
    // it is used too where the file cannot be written, or understood
    let cannot_write = || std::fs::create_dir(room.dir.path().join(".tetrad.toml.new")).unwrap();
    let wrong = || std::fs::write(&file, "[operator]\n").unwrap();
    let failures: [(f64, &dyn Fn(), &str); 2] =
        [(90.0, &cannot_write, "not kept: cannot write "), (100.0, &wrong, "not kept: ")];
    for (mm, fail, why) in failures {
        fail();
        let (before, _) = (std::fs::read_to_string(&file).unwrap(), desk.take_arms());
        let body = json!({ "arm_mm": mm }).to_string();
        let (status, told) = bytes(&desk, Method::POST, "/api/setup/arm", body).await;
        let told: Value = serde_json::from_slice(&told).unwrap();
        assert_eq!((status, &told["arm_mm"]), (StatusCode::OK, &json!(mm)));
        let (said, words) =
            (told["said"].as_str().unwrap(), format!("arms of {mm} mm, until the end of this run; {why}"));
        assert!(said.starts_with(&words) && said.contains("tetrad.toml"), "{said}");
        let arms = desk.take_arms().expect("they are used").lengths_m();
        assert!((f64::from(arms[0]) * 1e3 - mm).abs() < 1e-3, "{arms:?}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), before);
    }
}

#[tokio::test]
async fn pictures_and_scans_are_of_every_pixel() {
    let room = room();
    let red = room.places[0][0];
    let scan = |live| format!("/api/setup/scan?camera=0&ball=red&u={:.1}&v={:.1}&live={live}", red.u, red.v);
    let (status, live) = room.get(&scan(true)).await;
    assert_eq!(status, StatusCode::OK, "{live}");
    room.done("/api/setup/still", json!({})).await;
    let (_, row) = room.get(&scan(false)).await;
    assert_eq!(live, row, "nothing moves");
    assert_eq!(
        (row["row"].as_f64().unwrap(), row["x"].as_array().unwrap().len()),
        (f64::from(red.v.round()), 640)
    );
    let [first, last] = [0, 1].map(|end| row["borders"][end].as_f64().unwrap());
    let middle = (first + last) / 2.0;
    assert!(
        (middle - f64::from(red.u)).abs() < 3.0 && (24.0..40.0).contains(&(last - first)),
        "{first} {last}"
    );
    let m = |x: f64| row["m"][x as usize].as_f64().unwrap();
    let threshold = row["threshold"].as_f64().unwrap();
    assert!(m(middle) >= threshold && m(5.0) < threshold);

    let (status, file) = room.bytes(Method::GET, "/api/setup/still?camera=0", String::new()).await;
    assert_eq!((status, &file[..3]), (StatusCode::OK, &[0xff, 0xd8, 0xff][..]));
    let (status, file) =
        room.bytes(Method::GET, "/api/setup/mistaken?camera=0&ball=red", String::new()).await;
    assert_eq!((status, &file[1..4]), (StatusCode::OK, &b"PNG"[..]));
    let decoder = png::Decoder::new(std::io::Cursor::new(file));
    let reader = decoder.read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (640, 480));
    let none = room.get("/api/setup/mistaken?camera=1&ball=pink").await;
    Room::why(none, StatusCode::BAD_REQUEST);
}

#[tokio::test]
async fn a_camera_without_pictures_keeps_nobody_waiting() {
    let mut room = room();
    room.threads.clear();
    let gone = room.post("/api/setup/find", json!({"camera": 0})).await;
    assert!(
        Room::why(gone, StatusCode::SERVICE_UNAVAILABLE).starts_with("left gives no picture at the moment")
    );
}

#[tokio::test]
async fn before_the_cameras_are_open_there_is_nothing_to_set_up() {
    let (_, desk) = desk();
    for (path, body) in posts() {
        let (status, _) = bytes(&desk, Method::POST, path, body.to_string()).await;
        assert_eq!(status, StatusCode::SERVICE_UNAVAILABLE, "{path}");
    }
    desk.set_up_with(SetUp::new(Vec::new(), 0.08, None));
    let (status, answer) = bytes(&desk, Method::POST, "/api/setup/find", "{}".to_owned()).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(String::from_utf8(answer).unwrap().contains("no camera of the hand is at this computer"));
}

#[tokio::test]
async fn work_is_done_one_after_the_other() {
    let room = room();
    let find = || room.post("/api/setup/find", json!({}));
    let all = futures_util::future::join(find(), futures_util::future::join(find(), find()));
    let (a, (b, c)) = all.await;
    let done = [a, b, c].into_iter().filter(|(status, told)| {
        // on a computer that is too busy the wait for one's turn ends
        assert!([StatusCode::OK, StatusCode::SERVICE_UNAVAILABLE].contains(status), "{told}");
        *status == StatusCode::OK
    });
    assert!(done.count() > 0);
    assert_eq!(room.desk.set_up().unwrap().work.available_permits(), 1, "every permit is given back");
    let names = Ball::ALL.map(Ball::name);
    let (_, told) = room.get("/api/setup").await;
    for (ball, name) in told["cameras"][1]["balls"].as_array().unwrap().iter().zip(names) {
        assert_eq!((&ball["name"], &ball["how"]), (&json!(name), &json!("found")));
    }
}
