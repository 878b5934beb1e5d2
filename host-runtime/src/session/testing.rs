//! A small session, for tests.

use super::configuration::{Beginning, CameraBeginning, Pictures};
use super::picture;
use super::schema::foxglove::Level;
use super::schema::tetrad as msg;
use super::tape::Tape;
use super::topic::Topic;
use crate::pipeline::CameraStart;
use crate::settings::Mode;
use std::collections::BTreeMap;
use std::path::Path;
use tetrad_core::config::FilterConfig;
use tetrad_core::vision::frame::{FrameView, PixelFormat};

/// When its first picture was taken, microseconds by its clock.
pub(crate) const BEGAN_US: u64 = 2_000_000;

/// From picture to picture, microseconds.
pub(crate) const PERIOD_US: u64 = 100_000;

/// The pictures of one camera: a quarter of a megabyte each, the shade of their number.
pub(crate) const SIZE: (u16, u16) = (320, 240);

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

/// Writes it: so many pictures with a red ball that wanders, a hand, and an arm that is slowed from the
/// third picture on.
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
            let arm = msg::Arm {
                state: "engaged".to_owned(),
                standing: "engaged: it follows".to_owned(),
                slowed: vec!["near the end of joint 4".to_owned()],
                speed_share: 0.5,
                set_point: vec![0.5; 6],
                ..Default::default()
            };
            feed.message(Topic::Arm, t_us + 2, at, &arm);
            feed.message(Topic::Buttons, t_us + 2, 0, &msg::Buttons { pressed: true, ..Default::default() });
        }
        feed.log(t_us, Level::Info, &format!("line {at}"));
    }
    assert!(tape.finish(BTreeMap::new()).unwrap().left_out.is_empty());
}
