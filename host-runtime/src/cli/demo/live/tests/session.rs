//! Promise: readers that others wrote find in an operator's session every topic that docs/sessions.md lists, and
//! decode all of it.

use super::*;
use crate::session::Reader;
use std::collections::BTreeMap;
use std::process::Command;
use tetrad_tests::{peers, skip};

/// Pictures a second: enough for every topic, and fewer bytes than a demo's.
const FPS: f64 = 10.0;

/// What a slave waits for that hears from cameras which are as slow as that, microseconds.
const PATIENCE_US: u32 = 4_000_000;

/// The topics of the page's table with their schemas, CAMERA once for each camera.
fn documented(cameras: &[String]) -> BTreeMap<String, String> {
    let page = std::fs::read_to_string(tetrad_tests::repository().join("docs/sessions.md")).unwrap();
    let mut topics = BTreeMap::new();
    for row in page.lines().filter(|line| line.starts_with("| `/")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let schema = cells[2].to_owned();
        for topic in cells[1].split(',').map(|topic| topic.trim().trim_matches('`')) {
            let names: Vec<String> = match topic.strip_prefix("/CAMERA/") {
                Some(what) => cameras.iter().map(|camera| format!("/{camera}/{what}")).collect(),
                None => vec![topic.to_owned()],
            };
            topics.extend(names.into_iter().map(|name| (name, schema.clone())));
        }
    }
    topics
}

/// A run in which everything happens: cameras are taught, the hand is set up, a page drives, lets go and stops.
fn record(out: &Path, path: &Path) {
    let demo = Demo::start_as(out, Some(path), |operator, slave| {
        for camera in &mut operator.cameras {
            if let HandCamera::Local(local) = &mut camera.place {
                local.options.fps = Some(FPS);
            }
        }
        let teleop = &mut slave.arm.slave.teleop;
        teleop.command_timeout_us = PATIENCE_US;
        teleop.hold_to_run_timeout_us = PATIENCE_US;
        teleop.resume_us = PATIENCE_US + 1_000_000;
    });
    let console = demo.console;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let mut page = Tab::open(console).await;
        page.until("both cameras", all_seen).await;
        find(console).await;
        let (status, used) = post(console, "/api/setup/use", &json!({})).await;
        assert_eq!(status, 200, "{used}");
        page.until("what was taught", |live| {
            live["snapshot"]["lines"].to_string().matches("taught anew").count() == 2
        })
        .await;
        let (status, told) = post(console, "/api/setup/arm", &json!({"arm_mm": 81})).await;
        assert_eq!(status, 200, "{told}");
        page.until("the hand", |live| all_seen(live) && live["snapshot"]["hand"]["state"] == "both").await;
        drop(page);
        let mut driver = Driver::open(console).await;
        driver.drive().await;
        driver.tab.release().await;
        driver.tab.say(json!({"type": "stop"})).await;
        driver.tab.until("the stop", |live| live["snapshot"]["arm"]["state"] == "stopped").await;
    });
    demo.end();
}

#[test]
fn others_read_every_topic_of_an_operators_session() {
    let Some(python) = peers::python() else {
        skip("cli::demo::live::others_read_every_topic_of_an_operators_session", peers::MISSING);
        return;
    };
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("session.mcap");
    record(dir.path(), &path);
    let mut reader = Reader::open(&path).unwrap();
    let names = reader.names().to_vec();
    let mut counts: BTreeMap<String, u64> = BTreeMap::from([("/configuration".to_owned(), 1)]);
    while let Some(entry) = reader.next_entry().unwrap() {
        *counts.entry(entry.topic.name(&names)).or_default() += 1;
    }

    let script = tetrad_tests::repository().join("tests/scripts/mcap_check.py");
    let run = Command::new(python).arg(script).arg(&path).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let said: Value = serde_json::from_slice(&run.stdout).unwrap();
    let channels = said["channels"].as_object().unwrap();
    let decoded: BTreeMap<String, u64> = channels
        .iter()
        .map(|(topic, channel)| (topic.clone(), channel["decoded"].as_u64().unwrap()))
        .collect();
    assert_eq!(decoded, counts, "as many messages as this program finds");
    let schemas: BTreeMap<String, String> = channels
        .iter()
        .map(|(topic, channel)| (topic.clone(), channel["schema"].as_str().unwrap().to_owned()))
        .collect();
    assert_eq!(names, ["left", "right"]);
    let documented = documented(&names);
    assert!(documented.len() > 16, "the table of docs/sessions.md is not read: {documented:?}");
    assert_eq!(schemas, documented, "what came, and what docs/sessions.md lists");
}
