//! `/metrics` in Prometheus's text, and `/health`.

use super::app::State;
use super::snapshot::{DelayView, LinkView, SILENT_US, Snapshot};
use axum::extract::State as Of;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use std::fmt::{Display, Write as _};
use std::sync::atomic::Ordering;

/// A loop that has published nothing for so long is not well, microseconds.
const LOOP_SILENT_US: u64 = 1_000_000;

/// The arm's states, as the law names them.
const STATES: [&str; 5] = ["stopped", "armed", "engaged", "hold", "fault"];

/// Whether the operator's loop goes round; where sessions alone are shown there is none.
pub(super) async fn health(Of(state): Of<State>) -> Response {
    if state.desk.views().is_empty() {
        return (StatusCode::OK, "ok: sessions are shown, no station runs here\n").into_response();
    }
    let age_us = state.desk.now_us().saturating_sub(state.desk.snapshot().time_us);
    if age_us <= LOOP_SILENT_US {
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
    let crowded_out = counts.crowded_out.load(Ordering::Relaxed);
    text.counter("tetrad_console_crowded_out_total", "connections closed for want of room", crowded_out);
    let pictures = counts.pictures.load(Ordering::Relaxed);
    text.counter("tetrad_console_pictures_total", "pictures made to be looked at", pictures);
    text.family("tetrad_console_shown_total", "pictures that pages have drawn", "counter");
    for view in state.desk.views() {
        let thanked = view.thanked.load(Ordering::Relaxed);
        text.labelled("tetrad_console_shown_total", &[("view", &view.name)], thanked);
    }
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], text.0).into_response()
}

fn seconds(us: u64) -> f64 {
    us as f64 / 1e6
}

fn of_loop(text: &mut Text, snapshot: &Snapshot, now_us: u64) {
    // what a loop that hangs told last grows older with it
    let silent_us = now_us.saturating_sub(snapshot.time_us);
    let age_s = move |age_us: u64| seconds(age_us.saturating_add(silent_us));
    let is_heard = |age_us: u64| age_us.saturating_add(silent_us) <= SILENT_US;
    let help = "since the operator's loop has told anything";
    text.gauge("tetrad_snapshot_age_seconds", help, seconds(silent_us));
    text.counter("tetrad_snapshots_total", "what the operator's loop has told", snapshot.sequence);
    text.gauge("tetrad_engaged_share", "share of the time in which the arm followed", snapshot.engaged_share);
    if let Some(arm) = &snapshot.arm {
        text.family("tetrad_arm_state", "the state the arm is in; none where it is silent", "gauge");
        let known = !arm.silent && is_heard(arm.age_us);
        for state in STATES {
            text.labelled("tetrad_arm_state", &[("state", state)], u8::from(known && arm.state == state));
        }
        text.gauge("tetrad_arm_state_age_seconds", "since the arm's state came", age_s(arm.age_us));
        text.gauge("tetrad_arm_limits", "limits that keep the arm from following", arm.limits.len());
    }
    text.family("tetrad_camera_age_seconds", "since a camera's observations came", "gauge");
    for camera in &snapshot.cameras {
        if let Some(age_us) = camera.age_us {
            text.labelled("tetrad_camera_age_seconds", &[("camera", &camera.name)], age_s(age_us));
        }
    }
    let help = "share of a ball's rim that is seen; none of a camera that is silent";
    text.family("tetrad_ball_visible", help, "gauge");
    for camera in snapshot.cameras.iter().filter(|camera| camera.age_us.is_some_and(is_heard)) {
        for ball in &camera.balls {
            let labels = [("camera", camera.name.as_str()), ("ball", ball.name)];
            text.labelled("tetrad_ball_visible", &labels, ball.visible);
        }
    }
    of_links(text, &snapshot.links, age_s);
    let help = "how long a stage takes: quantiles of about the last 10 s, the count since the start";
    text.family("tetrad_delay_seconds", help, "summary");
    for DelayView { stage, all, lately } in &snapshot.delays {
        for (quantile, ms) in
            lately.iter().flat_map(|lately| [("0.5", lately.p50_ms), ("0.99", lately.p99_ms)])
        {
            let labels = [("stage", *stage), ("quantile", quantile)];
            text.labelled("tetrad_delay_seconds", &labels, ms / 1e3);
        }
        text.labelled("tetrad_delay_seconds_count", &[("stage", *stage)], all.count);
    }
}

/// What of a link, beside its age, is a family of its own: its name, what it is, its kind, and the value
/// where there is one.
type OfLink = (&'static str, &'static str, &'static str, fn(&LinkView) -> Option<f64>);

const LINKS: [OfLink; 7] = [
    ("tetrad_link_connected", "whether a station is there", "gauge", |link| {
        Some(f64::from(u8::from(link.connected)))
    }),
    (
        "tetrad_link_sent_packets_total",
        "QUIC packets sent to a station on this connection",
        "counter",
        |link| link.sent_packets.map(|packets| packets as f64),
    ),
    ("tetrad_link_lost_packets_total", "those of them that did not arrive", "counter", |link| {
        link.lost_packets.map(|packets| packets as f64)
    }),
    (
        "tetrad_link_loss_ratio",
        "lost packets of those sent in about the last 10 s, 0 to 1",
        "gauge",
        |link| link.loss_lately,
    ),
    ("tetrad_link_round_trip_seconds", "the way to a station and back, smoothed", "gauge", |link| {
        link.round_trip_us.map(seconds)
    }),
    ("tetrad_link_clock_offset_seconds", "a station's clock minus the operator's", "gauge", |link| {
        link.clock_offset_us.map(|us| us as f64 / 1e6)
    }),
    ("tetrad_link_clock_error_seconds", "how wrong that offset may be, either way", "gauge", |link| {
        link.clock_error_us.map(seconds)
    }),
];

/// `age_s` is the age now of what was so old when it was told.
fn of_links(text: &mut Text, links: &[LinkView], age_s: impl Fn(u64) -> f64) {
    let help = "since anything that counts was heard of a station";
    text.family("tetrad_link_age_seconds", help, "gauge");
    for link in links {
        if let Some(age_us) = link.age_us {
            text.labelled("tetrad_link_age_seconds", &[("station", &link.name)], age_s(age_us));
        }
    }
    for (name, help, kind, value) in LINKS {
        text.family(name, help, kind);
        for link in links {
            if let Some(value) = value(link) {
                text.labelled(name, &[("station", &link.name)], value);
            }
        }
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

#[cfg(test)]
mod tests;
