//! A small session, for tests.

use super::configuration::{Beginning, CameraBeginning, Pictures};
use super::picture;
use super::schema::foxglove::Level;
use super::schema::tetrad as msg;
use super::tape::Tape;
use super::topic::Topic;
use crate::pipeline::CameraStart;
use crate::settings::Mode;
use crate::station::arm_words;
use std::collections::BTreeMap;
use std::path::Path;
use tetrad_core::arm::teleop::Note;
use tetrad_core::config::FilterConfig;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::wire::{ArmReason, ArmState, ArmStatePacket};
use tetrad_fixtures::packets;

/// When its first picture was taken, microseconds by its clock.
pub(crate) const BEGAN_US: u64 = 2_000_000;

/// From picture to picture, microseconds.
pub(crate) const PERIOD_US: u64 = 100_000;

/// The pictures of one camera: a quarter of a megabyte each, the shade of their number.
pub(crate) const SIZE: (u16, u16) = (320, 240);

/// The bit of the wrist's singularity, as docs/wire.md lists them.
const WRIST: u64 = 1 << 5;

fn beginning() -> Beginning {
    let pictures = Pictures { size: SIZE, format: PixelFormat::Rgb888, fps: Some(10.0) };
    let camera = |name: &str, pictures| CameraBeginning {
        name: name.to_owned(),
        source: format!("sim:{name}"),
        pictures,
        start: CameraStart::anywhere([None; 4]),
        mode: Mode::Refined,
        rigid: true,
    };
    Beginning {
        chain: msg::Chain::Stations,
        mode: Mode::Refined,
        epoch_us: 5_000_000,
        arm_m: Some(0.08),
        filter: FilterConfig::default(),
        cameras: vec![camera("left", Some(pictures)), camera("afar", None)],
    }
}

/// An arm that is slowed at home by a singularity of its wrist.
fn arm() -> ArmStatePacket {
    let (notes, limits) = (1 << Note::AtHome as u8, WRIST);
    ArmStatePacket { notes, limits, ..packets::arm_state(ArmState::Engaged, ArmReason::None) }
}

/// Writes it: so many pictures with a red ball that wanders, a hand, and an arm that is slowed on its way home
/// from the third picture on.
pub(crate) fn small(path: &Path, pictures: u32) {
    let tape = Tape::start(path, &beginning().message()).unwrap();
    let feed = tape.feed();
    for at in 0..pictures {
        let t_us = BEGAN_US + u64::from(at) * PERIOD_US;
        let pixels = vec![at as u8; usize::from(SIZE.0) * usize::from(SIZE.1) * 3];
        let view = FrameView::packed(&pixels, SIZE.0, SIZE.1, PixelFormat::Rgb888).unwrap();
        let stamp = feed.timestamp(t_us);
        feed.put(Topic::Image(0), t_us, at, |bytes| picture::encode(&view, "left", stamp, bytes));
        let red =
            msg::Observation { u: at as f32, v: 10.0, diameter: 8.0, visible: 1.0, ..Default::default() };
        let seen =
            msg::Observations { frame: at.into(), capture_us: t_us, balls: vec![red], ..Default::default() };
        feed.message(Topic::Observations(0), t_us, at, &seen);
        feed.message(Topic::Observations(1), t_us + 1, at, &seen);
        let pose = msg::Transform {
            translation: vec![at as f32 * 1e-3, 0.0, 0.5],
            rotation: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        };
        let hand = msg::Hand { frame: at.into(), capture_us: t_us, pose: Some(pose), ..Default::default() };
        feed.message(Topic::Hand, t_us, at, &hand);
        if at >= 2 {
            let arm = arm();
            let arm = msg::Arm {
                state: arm_words::state_name(arm.state).to_owned(),
                standing: arm_words::standing(&arm),
                slowed: arm_words::limits(&arm),
                speed_share: 0.5,
                set_point: vec![0.5; 6],
                scale: 0.25,
                ..Default::default()
            };
            feed.message(Topic::Arm, t_us + 2, at, &arm);
            let buttons = msg::Buttons { pressed: true, home: true, scale_percent: 25, ..Default::default() };
            feed.message(Topic::Buttons, t_us + 2, 0, &buttons);
        }
        feed.log(t_us, Level::Info, &format!("line {at}"));
    }
    assert!(tape.finish(BTreeMap::new()).unwrap().left_out.is_empty());
}
