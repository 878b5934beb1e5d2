//! One moment of a session: what stood on the screen then, and what the program knew.

use super::convert;
use super::error::SessionError;
use super::index::{Index, Lookup, Spot};
use super::picture;
use super::schema::foxglove::{Log, RawImage};
use super::schema::tetrad as msg;
use super::topic::Topic;
use std::io::{Read, Seek};
use tetrad_core::geometry::Pose;
use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::Observations;
use tetrad_core::vision::frame::FrameView;

/// Lines that were told last.
const LINES: usize = 5;

/// What was known at one moment. Times are microseconds by the session's clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// The cameras, in their order.
    pub cameras: Vec<CameraThen>,
    /// The hand.
    pub hand: Option<HandThen>,
    /// When the slave's last word came, and the word.
    pub arm: Option<(u64, msg::Arm)>,
    /// The operator's buttons.
    pub buttons: Option<msg::Buttons>,
    /// What the program said last, the newest at the end.
    pub lines: Vec<(u64, String)>,
}

/// A camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CameraThen {
    /// When its last picture was taken.
    pub picture_us: Option<u64>,
    /// What was seen in that picture; where there are none, what was seen last.
    pub seen: Option<(u64, Observations)>,
}

/// The hand.
#[derive(Clone, Debug, PartialEq)]
pub struct HandThen {
    /// The instant it is of.
    pub time_us: u64,
    /// How it is known.
    pub state: PoseState,
    /// As it was filtered, else as it was measured.
    pub pose: Option<Pose>,
    /// How far balls were from where the pose has them, px.
    pub residual_px: Option<f32>,
    /// Why there is no motion, where there is none.
    pub refusal: String,
}

/// The messages that a session is stepped through by: its first camera's pictures, or what there is.
#[must_use]
pub fn steps(index: &Index) -> &[Spot] {
    let cameras = 0..index.names().len();
    let topics = cameras.clone().map(Topic::Image).chain(cameras.map(Topic::Observations));
    let mut all = topics.chain([Topic::Hand, Topic::Arm, Topic::Log]).map(|topic| index.of(topic));
    all.find(|spots| !spots.is_empty()).unwrap_or_default()
}

impl<F: Read + Seek> Lookup<F> {
    /// The moment at that time.
    ///
    /// # Errors
    /// What cannot be read.
    pub fn moment(&mut self, time_us: u64) -> Result<Moment, SessionError> {
        let mut moment = Moment::default();
        for camera in 0..self.index().names().len() {
            moment.cameras.push(self.camera(camera, time_us)?);
        }
        if let Some(spot) = self.index().last(Topic::Hand, time_us) {
            let (_, hand): (_, msg::Hand) = self.message(spot)?;
            moment.hand = Some(HandThen {
                time_us: spot.time_us,
                state: convert::pose_state(hand.state),
                pose: hand.filtered.as_ref().or(hand.pose.as_ref()).and_then(convert::pose),
                residual_px: hand.motion.map(|motion| motion.residual_px),
                refusal: hand.refusal,
            });
        }
        if let Some(spot) = self.index().last(Topic::Arm, time_us) {
            moment.arm = Some((spot.time_us, self.message(spot)?.1));
        }
        if let Some(spot) = self.index().last(Topic::Buttons, time_us) {
            moment.buttons = Some(self.message(spot)?.1);
        }
        let told = self.index().of(Topic::Log);
        let after = told.partition_point(|spot| spot.time_us <= time_us);
        let newest: Vec<Spot> = told.iter().take(after).skip(after.saturating_sub(LINES)).copied().collect();
        for spot in newest {
            let (_, log): (_, Log) = self.message(spot)?;
            moment.lines.push((spot.time_us, log.message));
        }
        Ok(moment)
    }

    fn camera(&mut self, camera: usize, time_us: u64) -> Result<CameraThen, SessionError> {
        let picture = self.index().last(Topic::Image(camera), time_us);
        // a picture and what was seen in it have the same time
        let wanted = picture.map_or(time_us, |picture| picture.time_us);
        let seen = self.index().last(Topic::Observations(camera), wanted);
        let seen = seen.filter(|seen| picture.is_none_or(|picture| picture.time_us == seen.time_us));
        let seen = match seen {
            Some(spot) => {
                let (_, seen): (_, msg::Observations) = self.message(spot)?;
                Some((spot.time_us, convert::observations(&seen.balls)))
            }
            None => None,
        };
        Ok(CameraThen { picture_us: picture.map(|picture| picture.time_us), seen })
    }

    /// Gives `look` the picture of a camera that was the newest at that time; `None` where there is none.
    ///
    /// # Errors
    /// What cannot be read, or is no picture.
    pub fn picture<T>(
        &mut self,
        camera: usize,
        time_us: u64,
        look: impl FnOnce(&FrameView<'_>) -> T,
    ) -> Result<Option<T>, SessionError> {
        let Some(spot) = self.index().last(Topic::Image(camera), time_us) else { return Ok(None) };
        let (_, image): (_, RawImage) = self.message(spot)?;
        let view = picture::view(&image).map_err(|reason| self.wrong(spot, reason))?;
        Ok(Some(look(&view)))
    }
}
