//! What pages are told of a session.

use crate::console::snapshot::{BallView, SILENT_US, silence};
use crate::session::schema::tetrad as msg;
use crate::session::{CameraThen, Index, Moment, Topic, moments};
use serde::Serialize;

/// What a session is of.
#[derive(Debug, Serialize)]
pub(super) struct About {
    name: String,
    bytes: u64,
    version: String,
    mode: &'static str,
    arm_mm: Option<f32>,
    /// When it began: Unix time for live cameras, else the scene's own.
    began_unix_us: u64,
    /// From the first message to the last.
    length_us: u64,
    /// Moments that it is stepped through by.
    moments: usize,
    /// When the first of them is, microseconds after it began: another camera may have begun a little before.
    first_us: u64,
    /// Whether the file has no end.
    cut: bool,
    cameras: Vec<CameraAbout>,
    topics: Vec<TopicAbout>,
}

#[derive(Debug, Serialize)]
struct CameraAbout {
    name: String,
    source: String,
    width: u16,
    height: u16,
    pictures: usize,
}

#[derive(Debug, Serialize)]
struct TopicAbout {
    name: String,
    messages: usize,
}

impl About {
    pub(super) fn of(name: &str, bytes: u64, index: &Index) -> Self {
        let beginning = index.beginning();
        let (first_us, last_us) = index.span_us().unwrap_or_default();
        let cameras = beginning.cameras.iter().enumerate().map(|(at, camera)| {
            let (width, height) = camera.pictures.as_ref().map_or((0, 0), |pictures| pictures.size);
            CameraAbout {
                name: camera.name.clone(),
                source: camera.source.clone(),
                width,
                height,
                pictures: index.of(Topic::Image(at)).len(),
            }
        });
        let topics = index
            .topics()
            .map(|(topic, spots)| TopicAbout { name: topic.name(index.names()), messages: spots.len() });
        Self {
            name: name.to_owned(),
            bytes,
            version: index.version().to_owned(),
            mode: beginning.mode.name(),
            arm_mm: beginning.arm_m.map(|m| m * 1e3),
            began_unix_us: beginning.epoch_us.saturating_add(first_us),
            length_us: last_us - first_us,
            moments: moments(index).len(),
            first_us: moments(index).first().map_or(0, |spot| spot.time_us.saturating_sub(first_us)),
            cut: index.cut(),
            cameras: cameras.collect(),
            topics: topics.collect(),
        }
    }
}

/// What was known at a moment. Times are microseconds after the session began, ages before the moment.
#[derive(Debug, Serialize)]
pub(super) struct At {
    t_us: u64,
    /// The place of the step that it is in, from 1; 0 before the first.
    number: usize,
    /// Where the steps around it begin.
    previous_us: Option<u64>,
    next_us: Option<u64>,
    cameras: Vec<CameraAt>,
    hand: Option<HandAt>,
    arm: Option<ArmAt>,
    buttons: Option<ButtonsAt>,
    lines: Vec<LineAt>,
}

#[derive(Debug, Serialize)]
struct CameraAt {
    /// `None`: there is no picture of it.
    age_us: Option<u64>,
    /// What it saw last is old, and not what it saw then.
    stale: bool,
    /// `None`: nothing that was seen in it is recorded.
    balls: Option<Vec<BallView>>,
}

#[derive(Debug, Serialize)]
struct HandAt {
    age_us: u64,
    /// Nothing was known of it any more: the rest is what was known last.
    silent: bool,
    state: &'static str,
    position_mm: Option<[f32; 3]>,
    /// The rotation row by row.
    rotation: Option<[f32; 9]>,
    residual_px: Option<f32>,
    refusal: String,
}

#[derive(Debug, Serialize)]
struct ArmAt {
    age_us: u64,
    /// Nothing was heard of it for so long that nobody knew what it did.
    silent: bool,
    /// While it was silent, what it was last.
    state: String,
    /// That nobody knew, while it was silent.
    standing: String,
    /// What kept it from following as it was asked, and what else there was to tell of it: whole lines, of which
    /// those that are of a slowing say so themselves; nothing while it was silent.
    slowed: Vec<String>,
    /// Metres of the tool for one of the hand; `None` in sessions that do not say.
    scale: Option<f32>,
    /// `None` while it was silent.
    speed_share: Option<f32>,
    command_age_us: Option<u64>,
    joints_deg: Vec<f32>,
    set_point_deg: Vec<f32>,
}

#[derive(Debug, Serialize)]
struct ButtonsAt {
    pressed: bool,
    stop: bool,
    resets: u32,
    /// The press is for the way home.
    home: bool,
    /// Percent of the slave's scale by which the next press follows; `None` in sessions that do not say.
    scale_percent: Option<u32>,
}

#[derive(Debug, Serialize)]
struct LineAt {
    t_us: u64,
    text: String,
}

impl At {
    pub(super) fn of(index: &Index, moment: &Moment, t_us: u64) -> Self {
        let (began_us, _) = index.span_us().unwrap_or_default();
        let at_us = began_us.saturating_add(t_us);
        let age = |time_us: u64| at_us.saturating_sub(time_us);
        let since = |time_us: u64| time_us.saturating_sub(began_us);
        let steps = moments(index);
        let number = steps.partition_point(|spot| spot.time_us <= at_us);
        let step = |at: Option<usize>| at.and_then(|at| steps.get(at)).map(|spot| since(spot.time_us));
        Self {
            t_us,
            number,
            previous_us: step(number.checked_sub(2)),
            next_us: step(Some(number)),
            cameras: moment.cameras.iter().map(|camera| CameraAt::of(camera, at_us)).collect(),
            hand: moment.hand.as_ref().map(|hand| HandAt {
                age_us: age(hand.time_us),
                silent: is_silent(age(hand.time_us)),
                state: hand.state.name(),
                position_mm: hand.pose.map(|pose| (pose.translation * 1e3).into()),
                rotation: hand.pose.map(|pose| {
                    let mut rows = [0.0; 9];
                    rows.iter_mut().zip(pose.rotation.transpose().iter()).for_each(|(to, from)| *to = *from);
                    rows
                }),
                residual_px: hand.residual_px,
                refusal: hand.refusal.clone(),
            }),
            arm: moment.arm.as_ref().map(|(time_us, arm)| ArmAt::of(arm, age(*time_us))),
            buttons: moment.buttons.as_ref().map(|buttons| ButtonsAt {
                pressed: buttons.pressed,
                stop: buttons.stop,
                resets: buttons.resets,
                home: buttons.home,
                scale_percent: Some(buttons.scale_percent).filter(|percent| *percent > 0),
            }),
            lines: moment
                .lines
                .iter()
                .map(|(time_us, text)| LineAt { t_us: since(*time_us), text: text.clone() })
                .collect(),
        }
    }
}

/// As the pages have it while it happens.
const fn is_silent(age_us: u64) -> bool {
    age_us > SILENT_US
}

impl ArmAt {
    fn of(arm: &msg::Arm, age_us: u64) -> Self {
        let degrees = |joints: &[f32]| joints.iter().map(|q| q.to_degrees()).collect();
        let silent = is_silent(age_us);
        Self {
            age_us,
            silent,
            state: arm.state.clone(),
            standing: if silent { silence(age_us) } else { arm.standing.clone() },
            slowed: if silent { Vec::new() } else { arm.slowed.clone() },
            scale: Some(arm.scale).filter(|scale| *scale > 0.0),
            speed_share: (!silent).then_some(arm.speed_share),
            command_age_us: arm.command_age_us,
            joints_deg: degrees(&arm.measured),
            set_point_deg: degrees(&arm.set_point),
        }
    }
}

impl CameraAt {
    fn of(camera: &CameraThen, at_us: u64) -> Self {
        // of a camera of another station there may be what it saw, and no picture
        let last_us = camera.picture_us.or(camera.seen.as_ref().map(|(time_us, _)| *time_us));
        Self {
            age_us: camera.picture_us.map(|time_us| at_us.saturating_sub(time_us)),
            stale: last_us.is_some_and(|time_us| is_silent(at_us.saturating_sub(time_us))),
            balls: camera.seen.as_ref().map(|(_, balls)| BallView::all(balls)),
        }
    }
}
