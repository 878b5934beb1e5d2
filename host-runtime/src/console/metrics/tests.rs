use super::*;
use crate::console::app::app;
use crate::console::control::Tab;
use crate::console::desk::Desk;
use crate::console::snapshot::{ArmView, BallView, CameraView, SpreadView};
use crate::console::{Access, ViewKind};
use crate::link::clock::ClockEstimate;
use crate::link::{Doorbell, LinkStats};
use crate::robot::clock::Clock;
use axum::body::{Body, to_bytes};
use axum::http::Request;
use std::collections::BTreeSet;
use tetrad_core::observation::Observations;
use tetrad_core::wire::{ArmReason, ArmState};
use tetrad_fixtures::packets;
use tower::ServiceExt as _;

/// What a monitor reads of this as soon as it is told.
async fn read(snapshot: Snapshot) -> String {
    read_at(snapshot, 0).await
}

/// What it reads at this time.
async fn read_at(snapshot: Snapshot, now_us: u64) -> String {
    let views = vec![("left".to_owned(), ViewKind::Hand)];
    let clock = Clock::given();
    clock.set(now_us);
    let desk = Desk::new(true, views, clock, Doorbell::default());
    desk.publish(snapshot);
    desk.control().take(Tab(1), "a", now_us).unwrap();
    let request = Request::builder().uri("/metrics").header("host", "localhost").body(Body::empty()).unwrap();
    let answer = app(desk, Access::loopback(), None).oneshot(request).await.unwrap();
    assert_eq!(answer.headers()[header::CONTENT_TYPE], "text/plain; version=0.0.4; charset=utf-8");
    String::from_utf8(to_bytes(answer.into_body(), 1 << 20).await.unwrap().to_vec()).unwrap()
}

#[track_caller]
fn has(metrics: &str, lines: &[&str]) {
    for line in lines {
        assert!(metrics.lines().any(|told| told == *line), "no {line} in\n{metrics}");
    }
}

/// A link as `LinkStats` knows it.
fn link(name: &str, clock: Option<ClockEstimate>) -> LinkView {
    let stats = LinkStats {
        address: None,
        connected: 1,
        heard_us: Some(4_000_000),
        round_trip_us: Some(1_500),
        clock,
        received: Default::default(),
        sent: Default::default(),
        lost_packets: 3,
        sent_packets: 12,
        pictures_received: 0,
        pictures_sent: Default::default(),
    };
    let link = LinkView::of(name, clock.is_some(), &stats, 4_020_000);
    LinkView { loss_lately: Some(0.5), ..link }
}

#[tokio::test]
async fn metrics_are_what_a_monitor_reads() {
    let camera = CameraView { name: "a \"b\"".to_owned(), age_us: Some(20_000), ..CameraView::default() };
    let metrics = read(Snapshot { sequence: 7, cameras: vec![camera], ..Snapshot::default() }).await;
    has(
        &metrics,
        &[
            "tetrad_snapshots_total 7",
            "tetrad_camera_age_seconds{camera=\"a \\\"b\\\"\"} 0.02",
            "tetrad_console_in_control 1",
            "tetrad_console_crowded_out_total 0",
            "tetrad_console_shown_total{view=\"left\"} 0",
            "# TYPE tetrad_console_refused_total counter",
        ],
    );
}

#[tokio::test]
async fn a_link_is_told_with_its_age_loss_way_and_clock() {
    let clock = ClockEstimate { offset_us: -2_500_000, error_us: 400, drift_ppm: 0.0, round_trip_us: 800 };
    let here = LinkView { name: "slave".to_owned(), connected: true, ..LinkView::default() };
    let links = vec![link("left", Some(clock)), link("right", None), here];
    let metrics = read(Snapshot { links, ..Snapshot::default() }).await;
    has(
        &metrics,
        &[
            "tetrad_link_connected{station=\"left\"} 1",
            "tetrad_link_connected{station=\"right\"} 0",
            "tetrad_link_connected{station=\"slave\"} 1",
            "tetrad_link_age_seconds{station=\"left\"} 0.02",
            "# TYPE tetrad_link_sent_packets_total counter",
            "tetrad_link_sent_packets_total{station=\"left\"} 12",
            "tetrad_link_lost_packets_total{station=\"left\"} 3",
            "tetrad_link_loss_ratio{station=\"left\"} 0.5",
            "tetrad_link_round_trip_seconds{station=\"left\"} 0.0015",
            "tetrad_link_clock_offset_seconds{station=\"left\"} -2.5",
            "tetrad_link_clock_error_seconds{station=\"left\"} 0.0004",
        ],
    );
    // what is not known is not told: a zero would be believed
    for unknown in ["clock_offset_seconds{station=\"right\"}", "round_trip_seconds{station=\"slave\"}"] {
        assert!(!metrics.contains(unknown), "{unknown} in\n{metrics}");
    }
}

/// A loop that hangs tells nothing new: what it told last would else stay fresh for ever.
#[tokio::test]
async fn ages_go_on_while_the_loop_tells_nothing() {
    let camera = |name: &str, age_us| CameraView { name: name.to_owned(), age_us, ..CameraView::default() };
    let arm = packets::arm_state(ArmState::Hold, ArmReason::None);
    let told = Snapshot {
        time_us: 5_000_000,
        cameras: vec![camera("left", Some(20_000)), camera("right", None)],
        arm: Some(ArmView::of(&arm, 4_970_000, true, 5_000_000)),
        links: vec![link("slave", None)],
        ..Snapshot::default()
    };
    let metrics = read_at(told, 8_000_000).await;
    has(
        &metrics,
        &[
            "tetrad_snapshot_age_seconds 3",
            "tetrad_arm_state_age_seconds 3.03",
            "tetrad_camera_age_seconds{camera=\"left\"} 3.02",
            "tetrad_link_age_seconds{station=\"slave\"} 3.02",
        ],
    );
    let unknown = "tetrad_camera_age_seconds{camera=\"right\"}";
    assert!(!metrics.contains(unknown), "one that was never heard has no age:\n{metrics}");
}

/// What a camera saw before it fell silent is not what it sees: a one would be believed.
#[tokio::test]
async fn of_what_is_silent_nothing_is_told() {
    let balls = BallView::all(&Observations::default());
    let camera = |name: &str, age_us| {
        let (name, balls) = (name.to_owned(), balls.clone());
        CameraView { name, age_us, balls, ..CameraView::default() }
    };
    let cameras =
        vec![camera("fresh", Some(SILENT_US)), camera("old", Some(SILENT_US + 1)), camera("never", None)];
    let arm = packets::arm_state(ArmState::Hold, ArmReason::None);
    let told = Snapshot {
        time_us: 5_000_000,
        cameras,
        arm: Some(ArmView::of(&arm, 4_500_000, true, 5_000_000)),
        ..Snapshot::default()
    };
    let seen_by = |metrics: &str, camera: &str| {
        metrics.matches(&format!("tetrad_ball_visible{{camera=\"{camera}\",ball=")).count()
    };
    let metrics = read_at(told.clone(), 5_000_000).await;
    assert_eq!(["fresh", "old", "never"].map(|camera| seen_by(&metrics, camera)), [4, 0, 0], "{metrics}");
    has(
        &metrics,
        &["tetrad_arm_state{state=\"hold\"} 1", "tetrad_camera_age_seconds{camera=\"old\"} 0.500001"],
    );
    // nor where the loop tells nothing new
    let metrics = read_at(told, 5_000_001).await;
    assert_eq!(seen_by(&metrics, "fresh"), 0, "{metrics}");
    has(&metrics, &["tetrad_arm_state{state=\"hold\"} 0"]);
}

/// A monitor reads how long stages take now, not since this morning.
#[tokio::test]
async fn delays_and_the_arm_are_told_as_they_are_now() {
    let spread = |ms: f64, count| SpreadView { count, p50_ms: ms, p99_ms: ms * 2.0, max_ms: ms * 3.0 };
    let delay = |stage, lately| DelayView { stage, all: spread(4.0, 90), lately };
    let arm = packets::arm_state(ArmState::Engaged, ArmReason::None);
    let told = Snapshot {
        arm: Some(ArmView::of(&arm, 0, true, 3_000_000)),
        delays: vec![delay("slow now", Some(spread(80.0, 7))), delay("over", None)],
        ..Snapshot::default()
    };
    let metrics = read(told).await;
    has(
        &metrics,
        &[
            "tetrad_delay_seconds{stage=\"slow now\",quantile=\"0.5\"} 0.08",
            "tetrad_delay_seconds{stage=\"slow now\",quantile=\"0.99\"} 0.16",
            "tetrad_delay_seconds_count{stage=\"slow now\"} 90",
            "tetrad_delay_seconds_count{stage=\"over\"} 90",
            "tetrad_arm_state{state=\"engaged\"} 0",
        ],
    );
    assert!(!metrics.contains("{stage=\"over\",quantile"), "{metrics}");
}

/// Every sample is a number of a family that was told of before it, once.
#[tokio::test]
async fn every_figure_says_what_it_is() {
    let links = vec![link("left", None)];
    let metrics = read(Snapshot { links, cameras: vec![CameraView::default()], ..Snapshot::default() }).await;
    let mut told = BTreeSet::new();
    let mut helped = "";
    for line in metrics.lines() {
        if let Some(help) = line.strip_prefix("# HELP ") {
            helped = help.split_once(' ').expect("words").0;
        } else if let Some(kind) = line.strip_prefix("# TYPE ") {
            let (name, kind) = kind.split_once(' ').unwrap();
            assert!(name == helped && ["gauge", "counter", "summary"].contains(&kind), "{line}");
            assert_eq!(kind == "counter", name.ends_with("_total"), "{line}");
            assert!(told.insert(name), "{line}: twice");
        } else {
            let (name, value) = line.rsplit_once(' ').unwrap();
            let name = name.split('{').next().unwrap();
            assert!(name == helped || name.strip_suffix("_count") == Some(helped), "{line}");
            assert!(name.starts_with("tetrad_") && value.parse::<f64>().is_ok(), "{line}");
        }
    }
    assert!(told.len() > 20, "{told:?}");
    let page = std::fs::read_to_string(tetrad_tests::repository().join("docs/console.md")).unwrap();
    for name in told {
        let named = |end: char| page.contains(&format!("`{name}{end}"));
        assert!(named('`') || named('{'), "docs/console.md does not say what {name} is");
    }
}
