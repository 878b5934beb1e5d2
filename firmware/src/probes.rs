//! Poses of the hand and joints of the arm as bytes out of bytes: what boards and the desktop are compared by.
//!
//! One file of two programs: `mps2-probes`, and the tests that run it and compute the same. What comes in and
//! what goes out is so the same in both; what lies between is core's.
//!
//! | | in | out |
//! |---|---|---|
//! | [`Hand`] | frames of the line: observations of two cameras, and buttons | a motion packet's frame for each observation of the second camera |
//! | [`Arm`] | a case: joints, then a pose of the tool | where the joints bring the tool, and the joints that bring it to the pose |

use tetrad_core::arm::puma560::{Joints, Puma560, Solutions, Unreachable};
use tetrad_core::config::{HandConfig, PumaConfig};
use tetrad_core::geometry::Pose;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::hand::report::HandReport;
use tetrad_core::hand::state::PoseState;
use tetrad_core::hand::tracker::{HandMode, HandTracker};
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::{BALLS, Observation};
use tetrad_core::wire::{Decoder, MAX_FRAME_LEN, MotionPacket, ObservationPacket, Packet, encode};

/// How many look at the hand.
const CAMERAS: usize = 2;

/// The arms of the fixtures' hand, metres.
const ARM_M: f32 = 0.08;

/// The session of what is played from a tape.
const SESSION: u32 = 1;

/// A hand before two smart cameras, as a station follows it: solved for, filtered and told.
pub struct Hand {
    decoder: Decoder,
    follower: Follower,
}

struct Follower {
    tracker: HandTracker,
    filter: PoseFilter,
    views: [HandView; CAMERAS],
    pressed: bool,
    told: u32,
}

impl Hand {
    /// A hand that nobody has seen yet.
    ///
    /// # Panics
    /// When core refuses its own settings.
    #[must_use]
    pub fn new(mode: HandMode) -> Self {
        let arms = Arms::equal(ARM_M).expect("a length");
        let nothing =
            HandView { balls: [Observation::default(); BALLS], camera: CameraModel::nominal(320, 240) };
        let follower = Follower {
            tracker: HandTracker::new(mode, arms, HandConfig::default()),
            filter: PoseFilter::default(),
            views: [nothing; CAMERAS],
            pressed: false,
            told: 0,
        };
        Self { decoder: Decoder::new(), follower }
    }

    /// Takes bytes of the line, and tells the frames that answer them.
    pub fn take(&mut self, bytes: &[u8], mut answer: impl FnMut(&[u8])) {
        for packet in self.decoder.packets(bytes) {
            if let Ok(packet) = packet
                && let Some(motion) = self.follower.packet(&packet)
            {
                let mut frame = [0; MAX_FRAME_LEN];
                // what is not finite would be missing
                let length = encode(&motion.into(), &mut frame).unwrap_or_default();
                answer(frame.get(..length).unwrap_or_default());
            }
        }
    }
}

impl Follower {
    fn packet(&mut self, packet: &Packet) -> Option<MotionPacket> {
        match packet {
            Packet::Observation(seen) => {
                let camera = usize::from(seen.camera);
                let camera_model = CameraModel::nominal(seen.width, seen.height);
                *self.views.get_mut(camera)? = HandView { balls: seen.balls, camera: camera_model };
                (camera + 1 == CAMERAS).then(|| self.step(seen))
            }
            Packet::Buttons(buttons) => {
                if buttons.pressed && !self.pressed {
                    self.latch(HandTracker::engage);
                }
                self.pressed = buttons.pressed;
                None
            }
            _ => None,
        }
    }

    /// Does what may latch the hand: then the pose is told in other axes, and the filter begins anew.
    fn latch<T>(&mut self, work: impl FnOnce(&mut HandTracker) -> T) -> T {
        let engagements = self.tracker.engagements();
        let done = work(&mut self.tracker);
        if self.tracker.engagements() != engagements {
            self.filter.reset();
        }
        done
    }

    fn step(&mut self, last: &ObservationPacket) -> MotionPacket {
        let views = self.views;
        let report = self.latch(|tracker| tracker.update(&views, last.capture_us));
        let pose = self.filtered(&report, last.capture_us).or(report.pose);
        let motion = report.motion.as_ref().ok();
        let mut seen_in = [0; BALLS];
        for (count, place) in seen_in.iter_mut().zip(0..) {
            let sees = |view: &&HandView| view.balls.get(place).is_some_and(|ball| ball.state.is_measured());
            *count = views.iter().filter(sees).count() as u8;
        }
        let packet = MotionPacket {
            session: SESSION,
            sequence: self.told,
            capture_us: last.capture_us,
            engaged: self.pressed,
            engagements: self.tracker.engagements(),
            state: if pose.is_some() { report.state } else { PoseState::Lost },
            spans: motion.map_or(0, |motion| motion.spans),
            views: CAMERAS as u8,
            seen_in,
            residual_px: motion.map_or(0.0, |motion| motion.residual_px),
            increment: motion.map_or_else(Pose::identity, |motion| motion.increment()).into(),
            since_engage: pose.unwrap_or_else(Pose::identity).into(),
            covariance: report.covariance.map(Into::into),
        };
        self.told += 1;
        packet
    }

    fn filtered(&mut self, report: &HandReport, t_us: u64) -> Option<Pose> {
        if report.state == PoseState::Lost {
            self.filter.reset();
            return None;
        }
        let measured = report.pose.filter(|_| report.state.is_measured());
        measured.and_then(|pose| self.filter.measure(t_us, &pose).ok()).or_else(|| self.filter.coast(t_us))
    }
}

/// Bytes of a case: six joints in single precision; nine numbers of a rotation, row by row, and three of a
/// place in double precision. Lowest byte first; radians and metres.
pub const CASE_BYTES: usize = 6 * 4 + 12 * 8;

/// A PUMA 560 in single precision, without a tool.
pub struct Arm(Puma560<f32>);

impl Arm {
    /// The arm of the fixtures' cases.
    ///
    /// # Panics
    /// When core refuses its own settings.
    #[must_use]
    pub fn new() -> Self {
        Self(Puma560::new(&PumaConfig::bare()).expect("the arm as it is"))
    }

    /// Answers a case: 12 numbers of where its joints bring the tool; then the solutions of its pose, told in
    /// single precision, and in double. What is no case has no answer.
    pub fn answer(&self, case: &[u8], mut answer: impl FnMut(&[u8])) {
        let (numbers, []) = case.as_chunks::<4>() else { return };
        let (angles, doubles) = numbers.split_at_checked(6).unwrap_or_default();
        let (Ok(angles), ([r @ .., x, y, z], [])) =
            (<[[u8; 4]; 6]>::try_from(angles), doubles.as_flattened().as_chunks::<8>())
        else {
            return;
        };
        if r.len() != 9 {
            return;
        }
        let near = angles.map(f32::from_le_bytes);
        let pose = Pose {
            rotation: nalgebra::Matrix3::from_row_iterator(r.iter().copied().map(f64::from_le_bytes)),
            translation: [x, y, z].map(|number| f64::from_le_bytes(*number)).into(),
        };
        let single =
            Pose { rotation: pose.rotation.cast::<f32>(), translation: pose.translation.cast::<f32>() };
        let there = self.0.forward(&near);
        for number in there.rotation.iter().chain(&there.translation) {
            answer(&number.to_le_bytes());
        }
        tell(&self.0.inverse(&single, &near), &mut answer);
        tell(&self.0.inverse(&pose, &near), &mut answer);
    }
}

impl Default for Arm {
    fn default() -> Self {
        Self::new()
    }
}

/// Each solution's posture, joints out of range and angles; or a zero and why there is none.
fn tell(solved: &Result<Solutions<f32>, Unreachable>, answer: &mut impl FnMut(&[u8])) {
    match solved {
        Err(why) => answer(&[0, *why as u8]),
        Ok(solutions) => {
            answer(&[solutions.iter().count() as u8]);
            for solution in solutions.iter() {
                answer(solution.configuration.code().as_bytes());
                answer(&[solution.outside.numbers().fold(0, |set, number| set | 1 << number)]);
                let joints: &Joints<f32> = &solution.joints;
                joints.iter().for_each(|angle| answer(&angle.to_le_bytes()));
            }
        }
    }
}
