//! `refined` mode: the rim takes the place of the row edges, and decides what a part of a ball is worth.
//!
//! Whole balls first: they say where the frame has carried those that a finger covers. A part of a ball
//! is looked at from there, since a sliver's own middle is nearly half a diameter off. What neither
//! shows a rim nor stands behind another ball (eq. 3) is not measured: the prediction is nearer.

use super::CameraTracker;
use crate::config::{CentreMode, TrackerConfig};
use crate::geometry::ImagePoint;
use crate::observation::{BALLS, ImageCovariance};
use crate::vision::centre::Blob;
use crate::vision::detect::Candidate;
use crate::vision::frame::FrameView;
use crate::vision::locate::{Find, Finds};
use crate::vision::reacquire::{Places, suggested};
use crate::vision::rim::{Rim, RimMemory, RimRefusal, Sought, aspect_of_pixels, find_rim};
use crate::vision::track::{BallTrack, Mode};

/// Balls that must be seen to say where the frame has carried another.
const VOICES: usize = 2;

/// They are believed for so many times as long as a ball is said to be predicted.
const CARRIED_FOR: u64 = 3;

/// A part of a ball lies no farther from where the ball must be than so many diameters ...
const PART_REACH: f32 = 0.8;

/// ... and so many standard deviations of that place.
const REACH_SIGMAS: f32 = 3.0;

/// The centre of its rim lies within so many standard deviations of both together, squared.
const MOST_APART2: f32 = 12.0;

/// A rim whose centre is known no better than this, in diameters, is not a measurement.
const VAGUE: f32 = 0.15;

/// From this share of the rim on it says itself where the ball is: more than half of a circle, which a
/// corner or the end of a bar has not.
const CLEAR_RIM: f32 = 0.6;

/// Share of the ball's area under which the middle of a part says nothing of the ball's.
const SLIVER: f32 = 0.35;

/// Where a ball must be.
#[derive(Clone, Copy, Debug)]
struct Expected {
    centre: ImagePoint,
    /// Pixels.
    sigma: f32,
}

impl CameraTracker {
    /// Where a ball's rim is found, its centre takes the place of the row edges' (and of eq. 3). Never a part
    /// of its caller, which has searched before with all the stack that is left.
    #[inline(never)]
    pub(super) fn refine(&mut self, frame: &FrameView<'_>, t_us: u64, finds: &mut Finds, tested: &mut u32) {
        let Self { config, tracks } = self;
        if config.centre.mode == CentreMode::RowEdge {
            return;
        }
        for (find, track) in finds.iter_mut().zip(&mut *tracks) {
            if let (Some(find), Some(track)) = (find, track)
                && find.whole
                && let Ok(rim) = sought_rim(frame, t_us, find, track, None, config, tested)
            {
                take(find, track, &rim, t_us, config);
            }
        }
        let now = whole_places(finds);
        for (find, track) in finds.iter_mut().zip(tracks) {
            if let Some(track) = track
                && !find.as_ref().is_some_and(|find| find.whole)
            {
                let expected = expected(track, &now, t_us, config);
                refine_part(frame, t_us, find, track, expected, config, tested);
            }
        }
    }
}

impl CameraTracker {
    /// A thing of a ball's colour that the search of the whole picture came upon is a ball only if it
    /// shows a ball's rim, or enough of a rigid frame is seen without it: with the hand covered,
    /// everything in the room that has one of four colours is tried, and some of it is of the right size.
    /// Things without a rim do not vouch for each other.
    pub(super) fn drop_unproven(&self, finds: &mut Finds) {
        let taught = self.tracks.iter().flatten().count();
        if self.config.centre.mode == CentreMode::RowEdge || !self.config.rigid || taught < 2 {
            return;
        }
        let proven =
            |find: &Find| find.mode != Mode::Global || find.rim.is_some_and(|rim| rim.visible >= CLEAR_RIM);
        if finds.iter().flatten().filter(|find| proven(find)).count() > VOICES {
            return;
        }
        for slot in finds {
            *slot = slot.take_if(|find| proven(find));
        }
    }
}

/// The places of the balls that are seen whole.
fn whole_places(finds: &Finds) -> Places {
    let mut places = [None; BALLS];
    for (place, find) in places.iter_mut().zip(finds) {
        *place = find.as_ref().filter(|find| find.whole).map(|find| find.centre);
    }
    places
}

/// Where the rest of a rigid frame has carried a ball that was measured a short while ago.
fn expected(track: &BallTrack, now: &Places, t_us: u64, config: &TrackerConfig) -> Option<Expected> {
    let longest = config.occlusion.predict_us.saturating_mul(CARRIED_FOR);
    let absent = track.absent_us(t_us).filter(|us| *us <= longest)?;
    let (centre, voices) = suggested(track, now).filter(|_| config.rigid)?;
    let known = track.carried_to(absent);
    let sigma = libm::sqrtf(known * known + disagreement2(track, now));
    (voices >= VOICES).then_some(Expected { centre, sigma })
}

/// How differently the other balls have moved since this one was measured, as a variance along each
/// axis, pixels squared: a hand that turns carries its balls to different places.
fn disagreement2(track: &BallTrack, now: &Places) -> f32 {
    let shifts = || now.iter().zip(&track.companions).filter_map(|(now, then)| Some((*now)? - (*then)?));
    let (mut squares, mut pairs) = (0.0, 0.0f32);
    for (i, a) in shifts().enumerate() {
        for b in shifts().skip(i + 1) {
            let apart = a.distance(b);
            squares += apart * apart;
            pairs += 1.0;
        }
    }
    // two that differ by chance are apart by twice the variance along each of two axes
    squares / (4.0 * pairs.max(1.0))
}

/// The place that the rim and the expectation give together; `None` where they contradict each other or
/// the rim says too little. A rim that is mostly in sight needs no other word.
fn agreed(mut rim: Rim, expected: &Expected, diameter: f32) -> Option<Rim> {
    if rim.visible >= CLEAR_RIM {
        return Some(rim);
    }
    let ImageCovariance { uu, uv, vv } = rim.covariance;
    let vague = VAGUE * diameter;
    let prior = expected.sigma * expected.sigma;
    let (s_uu, s_vv) = (uu + prior, vv + prior);
    let determinant = s_uu * s_vv - uv * uv;
    // not a number is vague too
    if !(uu.max(vv) <= vague * vague && determinant > 0.0) {
        return None;
    }
    let (i_uu, i_uv, i_vv) = (s_vv / determinant, -uv / determinant, s_uu / determinant);
    let off = rim.centre - expected.centre;
    let weighed = ImagePoint::new(i_uu * off.u + i_uv * off.v, i_uv * off.u + i_vv * off.v);
    let apart2 = off.u * weighed.u + off.v * weighed.v;
    rim.covariance = ImageCovariance {
        uu: prior * (1.0 - prior * i_uu),
        uv: -prior * prior * i_uv,
        vv: prior * (1.0 - prior * i_vv),
    };
    rim.centre = expected.centre + weighed * prior;
    (apart2 <= MOST_APART2).then_some(rim)
}

/// A ball of which a part is seen, or nothing: its rim is sought where it must be.
fn refine_part(
    frame: &FrameView<'_>,
    t_us: u64,
    find: &mut Option<Find>,
    track: &mut BallTrack,
    expected: Option<Expected>,
    config: &TrackerConfig,
    tested: &mut u32,
) {
    if let (Some(found), Some(expected)) = (&find, expected)
        && found.centre.distance(expected.centre) > reach(PART_REACH, track, &expected)
    {
        // something else of its colour
        *find = None;
    }
    let mut part = match (*find, expected) {
        (Some(part), _) => part,
        (None, Some(expected)) if track.rim.is_some() => unseen(track, &expected, config),
        _ => return,
    };
    let from = expected.map(|expected| expected.centre);
    let rim = sought_rim(frame, t_us, &part, track, from, config, tested).ok();
    let rim = rim.and_then(|rim| match expected {
        Some(expected) => agreed(rim, &expected, track.diameter()),
        None => Some(rim),
    });
    if let Some(rim) = rim {
        take(&mut part, track, &rim, t_us, config);
        *find = Some(part);
    } else if let Some(found) = find {
        let explained = found.touching || found.blob.cut;
        let sliver = found.blob.area < SLIVER * track.clean.area;
        if !explained && config.rigid && (expected.is_some() || sliver) {
            *find = None;
        }
    }
}

fn reach(diameters: f32, track: &BallTrack, expected: &Expected) -> f32 {
    diameters * track.diameter() + REACH_SIGMAS * expected.sigma
}

/// A ball too little of which is seen to be found by its colour.
fn unseen(track: &BallTrack, expected: &Expected, config: &TrackerConfig) -> Find {
    let blob = Blob {
        centre: expected.centre,
        diameter: track.clean.diameter,
        height: track.clean.height,
        area: 0.0,
        matched: 0,
        roundness: 0.0,
        colour: track.appearance.current().typical,
        bounds: (0, 0, 0, 0),
        cut: false,
    };
    let matcher = track.appearance.matcher(config.colour.alpha_256);
    Find::new(&Candidate { blob, score: 0.0 }, matcher, Mode::Tracking)
}

/// Never a part of its callers, nor of one of them twice: a rim takes stack that nothing else needs then.
#[inline(never)]
fn sought_rim(
    frame: &FrameView<'_>,
    t_us: u64,
    find: &Find,
    track: &BallTrack,
    expected: Option<ImagePoint>,
    config: &TrackerConfig,
    tested: &mut u32,
) -> Result<Rim, RimRefusal> {
    let learnt = track.appearance.learnt();
    let memory = remembered(track, t_us);
    let sought = Sought {
        blob: &find.blob,
        matcher: &find.matcher,
        memory: memory.as_ref(),
        expected,
        diameter: track.clean.diameter,
        aspect: aspect_of_pixels(learnt.aspect, learnt.diameter),
        speed: track.moved(t_us, expected.unwrap_or(find.blob.centre)),
    };
    find_rim(frame, &sought, &config.centre, tested)
}

fn take(find: &mut Find, track: &mut BallTrack, rim: &Rim, t_us: u64, config: &TrackerConfig) {
    find.centre = rim.centre;
    find.rim = Some(*rim);
    let memory = remembered(track, t_us);
    track.rim = Some(RimMemory::after(memory.as_ref(), rim, &find.blob, &config.centre));
}

/// The last rim, and what it is worth now.
fn remembered(track: &BallTrack, t_us: u64) -> Option<RimMemory> {
    track.rim.zip(track.absent_us(t_us)).map(|(rim, elapsed)| rim.later(elapsed))
}
