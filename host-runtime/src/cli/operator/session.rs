//! The session that an operator records.

use super::cameras::Cameras;
use crate::exit::{Exit, Failure, OrExit as _};
use crate::pipeline::CameraStart;
use crate::robot::clock::Clock;
use crate::session::schema::tetrad::Chain;
use crate::session::{
    Beginning, CameraBeginning, Pictures, Recorded, SessionError, StationTape, Tape, camera_names,
};
use crate::settings::Mode;
use crate::settings::station::{HandCamera, OperatorSettings};
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};
use tetrad_core::observation::BALLS;

/// Begins the session of these cameras, none of which has begun.
pub(super) fn start(
    path: &Path,
    operator: &OperatorSettings,
    cameras: &Cameras,
    clock: &Clock,
) -> Result<StationTape, Failure> {
    let called = operator.cameras.iter().map(|camera| match &camera.place {
        HandCamera::Local(local) => local.options.view.name(),
        HandCamera::Station(_) | HandCamera::Serial { .. } => camera.source.as_str(),
    });
    let names = camera_names(called);
    let mut begin: Vec<CameraBeginning> = operator
        .cameras
        .iter()
        .zip(&names)
        .map(|(camera, name)| CameraBeginning {
            name: name.clone(),
            source: camera.source.clone(),
            pictures: None,
            start: CameraStart { focal_px: camera.focal_px, ..CameraStart::anywhere([None; BALLS]) },
            mode: match &camera.place {
                HandCamera::Local(local) => local.mode,
                HandCamera::Station(_) | HandCamera::Serial { .. } => Mode::Refined,
            },
            rigid: true,
        })
        .collect();
    for (at, station) in cameras.opened() {
        let Some(camera) = begin.get_mut(at) else { continue };
        let info = station.info();
        let size = (info.width, info.height);
        camera.pictures = Some(Pictures { size, format: info.format, fps: info.fps });
        camera.start = CameraStart { focal_px: camera.start.focal_px, ..*station.start() };
        camera.rigid = station.start().balls.iter().all(Option::is_some);
    }
    let unix_us = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_micros();
    let beginning = Beginning {
        chain: Chain::Stations,
        mode: Mode::Refined,
        epoch_us: u64::try_from(unix_us).unwrap_or(0).saturating_sub(clock.now_us()),
        arm_m: Some(operator.arm_m),
        filter: operator.filter,
        cameras: begin,
    };
    let tape = Tape::start(path, &beginning.message()).or_exit(Exit::BadArguments)?;
    Ok(StationTape::new(tape, names))
}

/// What a recording came to, in lines.
pub(super) fn lines(recorded: &Result<Recorded, SessionError>) -> Vec<String> {
    match recorded {
        Ok(Recorded { written, left_out }) => {
            let megabytes = written.bytes as f64 / 1e6;
            let mut lines = vec![format!("recorded        {} messages, {megabytes:.1} MB", written.messages)];
            let out = left_out.iter();
            lines.extend(out.map(|(topic, count)| {
                format!("left out        {count} of {topic}, for the disk was behind")
            }));
            lines
        }
        Err(error) => vec![format!("not recorded    {error}")],
    }
}
