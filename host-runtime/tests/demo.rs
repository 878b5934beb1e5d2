//! `tetrad demo`: the whole chain over a simulated hand.

mod common;

use common::{csv, json, tetrad};

#[test]
fn a_headless_demo_tracks_every_frame_and_saves_what_it_saw() {
    let dir = tempfile::tempdir().unwrap();
    let ran = tetrad(dir.path(), "demo --headless --seconds 2").done();
    assert!(ran.stdout.contains("60 tracked of 60"), "{}", ran.stdout);
    for line in ["centre error", "pose error", "pixels tested"] {
        assert!(ran.stdout.contains(line), "no {line:?} in {}", ran.stdout);
    }
    let out = dir.path().join("demo-out");
    assert_eq!(csv(&out.join("observations.csv")).len(), 1 + 60 * 8);
    assert_eq!(csv(&out.join("truth.csv")).len(), 1 + 60 * 8);
    assert_eq!(csv(&out.join("pose.csv")).len(), 1 + 60);
    assert_eq!(csv(&out.join("truth_pose.csv")).len(), 1 + 60);
    assert_eq!(json(&out.join("summary.json"))["complete"].as_bool(), Some(true));
    let png = std::fs::File::open(out.join("seen.png")).unwrap();
    let info = png::Decoder::new(std::io::BufReader::new(png)).read_info().unwrap().info().size();
    assert_eq!(info, (1280, 480));
}

#[test]
fn without_headless_it_keeps_time_names_its_console_and_nobody_moves_the_arm() {
    let dir = tempfile::tempdir().unwrap();
    let started = std::time::Instant::now();
    let ran = tetrad(dir.path(), "demo --seconds 1.5 --scene still --out out").done();
    assert!(started.elapsed().as_secs_f64() > 1.4, "real time");
    assert!(ran.stdout.starts_with("console         http://127.0.0.1:"), "{}", ran.stdout);
    let out = dir.path().join("out");
    let poses = csv(&out.join("pose.csv")).len() - 1;
    // thirty a second in real time, however much longer than asked for a busy computer had it run
    let most = (started.elapsed().as_secs_f64() * 30.0).ceil() as usize + 1;
    assert!((1..=most).contains(&poses), "{poses} instants, at most {most} in that time");
    let states = csv(&out.join("arm_state.csv"));
    assert!(states.len() > 1 && states[1..].iter().all(|row| row[3] == "stopped"), "{states:?}");
}
