//! What the tracker of one camera starts with: colours from a file, or learnt in a picture where
//! somebody knows the balls to be.

use crate::exit::{Exit, Failure, OrExit as _};
use crate::learning;
use crate::pipeline::CameraStart;
use crate::scene_file;
use crate::settings::Start;
use anyhow::Context as _;
use tetrad_core::config::LearnConfig;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::frame::FrameView;

/// A camera, for messages.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// `left` or `right`, or what a station calls it.
    pub name: &'a str,
    /// SRC as it was given.
    pub source: &'a str,
}

/// What the camera starts with, learnt from its first picture where `start` says so.
///
/// # Errors
/// [`Exit::BadArguments`] for balls larger than the picture and places outside of it, [`Exit::Failed`]
/// where no ball can be learnt.
pub fn camera_start(
    camera: Named<'_>,
    start: &Start,
    picture: &FrameView<'_>,
) -> Result<CameraStart, Failure> {
    match start {
        Start::Colours(colours) => {
            let balls = colours.learnt_balls();
            fits(camera, &balls, (picture.width(), picture.height()))?;
            Ok(CameraStart::anywhere(balls))
        }
        Start::Seeds { seeds, file } => {
            let size = (picture.width(), picture.height());
            scene_file::check_seeds(seeds, camera.name, size, file).or_exit(Exit::BadArguments)?;
            let taught = learning::learn_at(picture, seeds, &LearnConfig::default())
                .with_context(|| format!("{file}: seeds.{}: no ball can be learnt there", camera.name))
                .or_exit(Exit::Failed)?;
            Ok(learning::start_with(&taught))
        }
    }
}

/// Refuses balls that are larger than the picture of `(width, height)` pixels they are searched in.
///
/// # Errors
/// [`Exit::BadArguments`] naming the ball.
pub fn fits(
    camera: Named<'_>,
    balls: &[Option<LearntBall>; BALLS],
    (width, height): (u16, u16),
) -> Result<(), Failure> {
    for (ball, learnt) in Ball::ALL.into_iter().zip(balls) {
        let least_side = f32::from(width.min(height));
        if let Some(learnt) = learnt.filter(|learnt| learnt.diameter > least_side) {
            let (Named { name, source }, diameter) = (camera, learnt.diameter);
            return Err(Failure::bad_arguments(format!(
                "{source}: the {name} pictures are {width}x{height} pixels, and the {} ball is {diameter} px across",
                ball.name()
            ))
            .help("give larger pictures, or colours that were learnt from these"));
        }
    }
    Ok(())
}
