//! `/metrics` in Prometheus's text, and `/health`.

use super::app::State;
use super::snapshot::Snapshot;
use axum::extract::State as Of;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use std::fmt::{Display, Write as _};
use std::sync::atomic::Ordering;

/// A loop that has published nothing for so long is not well, microseconds.
const SILENT_US: u64 = 1_000_000;

/// The arm's states, as the law names them.
const STATES: [&str; 5] = ["stopped", "armed", "engaged", "hold", "fault"];

/// Whether the operator's loop goes round.
pub(super) async fn health(Of(state): Of<State>) -> Response {
    let age_us = state.desk.now_us().saturating_sub(state.desk.snapshot().time_us);
    if age_us <= SILENT_US {
        (StatusCode::OK, "ok\n").into_response()
    } else {
        let text = format!("the operator's loop has told nothing for {} ms\n", age_us / 1_000);
        (StatusCode::SERVICE_UNAVAILABLE, text).into_response()
    }
}

/// What a monitor collects.
pub(super) async fn metrics(Of(state): Of<State>) -> Response {
    let now_us = state.desk.now_us();
    let mut text = Text::default();
    of_loop(&mut text, &state.desk.snapshot(), now_us);
    let control = state.desk.control().view(None, now_us);
    let counts = state.desk.counts();
    text.gauge(
        "tetrad_console_sockets",
        "connections to the console",
        counts.sockets.load(Ordering::Relaxed),
    );
    text.gauge("tetrad_console_web_sockets", "WebSockets", counts.web_sockets.load(Ordering::Relaxed));
    text.gauge("tetrad_console_in_control", "whether a page drives", u8::from(control.holder.is_some()));
    text.gauge("tetrad_console_pressed", "whether hold-to-run is pressed there", u8::from(control.pressed));
    text.gauge("tetrad_console_stopped", "whether a stop is latched there", u8::from(control.stopped));
    let refused = counts.refused.load(Ordering::Relaxed);
    text.counter("tetrad_console_refused_total", "requests that were refused", refused);
    let pictures = counts.pictures.load(Ordering::Relaxed);
    text.counter("tetrad_console_pictures_total", "pictures made to be looked at", pictures);
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], text.0).into_response()
}

fn of_loop(text: &mut Text, snapshot: &Snapshot, now_us: u64) {
    let seconds = |us: u64| us as f64 * 1e-6;
    let age_s = seconds(now_us.saturating_sub(snapshot.time_us));
    text.gauge("tetrad_snapshot_age_seconds", "since the operator's loop has told anything", age_s);
    text.counter("tetrad_snapshots_total", "what the operator's loop has told", snapshot.sequence);
    text.gauge("tetrad_engaged_share", "share of the time in which the arm followed", snapshot.engaged_share);
    if let Some(arm) = &snapshot.arm {
        text.family("tetrad_arm_state", "the state the arm is in", "gauge");
        for state in STATES {
            text.labelled("tetrad_arm_state", &[("state", state)], u8::from(arm.state == state));
        }
        text.gauge("tetrad_arm_state_age_seconds", "since the arm's state came", seconds(arm.age_us));
        text.gauge("tetrad_arm_limits", "limits that keep the arm from following", arm.limits.len());
    }
    text.family("tetrad_camera_age_seconds", "since a camera's observations came", "gauge");
    for camera in &snapshot.cameras {
        if let Some(age_us) = camera.age_us {
            text.labelled("tetrad_camera_age_seconds", &[("camera", &camera.name)], seconds(age_us));
        }
    }
    text.family("tetrad_ball_visible", "share of a ball's rim that is seen", "gauge");
    for camera in &snapshot.cameras {
        for ball in &camera.balls {
            let labels = [("camera", camera.name.as_str()), ("ball", ball.name)];
            text.labelled("tetrad_ball_visible", &labels, ball.visible);
        }
    }
    text.family("tetrad_link_connected", "whether a station is there", "gauge");
    for link in &snapshot.links {
        text.labelled("tetrad_link_connected", &[("station", &link.name)], u8::from(link.connected));
    }
    text.family("tetrad_delay_seconds", "how long a stage takes", "summary");
    for delay in &snapshot.delays {
        for (quantile, ms) in [("0.5", delay.p50_ms), ("0.99", delay.p99_ms)] {
            let labels = [("stage", delay.stage), ("quantile", quantile)];
            text.labelled("tetrad_delay_seconds", &labels, ms * 1e-3);
        }
        text.labelled("tetrad_delay_seconds_count", &[("stage", delay.stage)], delay.count);
    }
}

#[derive(Default)]
struct Text(String);

impl Text {
    fn family(&mut self, name: &str, help: &str, kind: &str) {
        // writing to a string does not fail
        let _ = writeln!(self.0, "# HELP {name} {help}\n# TYPE {name} {kind}");
    }

    fn gauge(&mut self, name: &str, help: &str, value: impl Display) {
        self.family(name, help, "gauge");
        self.labelled(name, &[], value);
    }

    fn counter(&mut self, name: &str, help: &str, value: impl Display) {
        self.family(name, help, "counter");
        self.labelled(name, &[], value);
    }

    fn labelled(&mut self, name: &str, labels: &[(&str, &str)], value: impl Display) {
        let label = |(key, value): &(&str, &str)| {
            let value = value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            format!("{key}=\"{value}\"")
        };
        let labels = labels.iter().map(label).collect::<Vec<_>>().join(",");
        let labels = if labels.is_empty() { labels } else { format!("{{{labels}}}") };
        let _ = writeln!(self.0, "{name}{labels} {value}");
    }
}
