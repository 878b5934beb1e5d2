//! A scene of `tetrad-fixtures` that is played in real time, for stations that have no camera.
//!
//! The pictures are rendered once, when it is opened, and played to and fro, so that the hand never
//! jumps. Which of them is shown is told by the computer's clock alone: two programs on one computer
//! that play the same scene at the same rate show the same moment, as two cameras do. A picture that is
//! not taken before the next is due is missed.

use super::{Frame, Gap, Labels, Options, Source, SourceError, SourceInfo, simulated};
use std::num::NonZero;
use std::ops::RangeInclusive;
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_fixtures::{Scene, to_format};

/// The most pictures that are kept...
const MAX_PICTURES: usize = 300;

/// ...and the most memory they take, bytes. Counted in the largest format there is, so that cameras
/// with different formats still play as many pictures, and with that the same moments.
const MAX_BYTES: usize = 256_000_000;
const LARGEST_PIXEL: usize = 4;

/// The rates a scene is played at, pictures a second: a wait for the next is never long.
const RATES: RangeInclusive<f64> = 1.0..=1000.0;

/// The longest sleep: the clock may be set meanwhile.
const NAP: Duration = Duration::from_millis(50);

/// See the [module's text](self).
pub struct LiveScene {
    info: SourceInfo,
    pictures: Vec<Vec<u8>>,
    playback: Playback,
    delivered: u64,
}

impl LiveScene {
    /// Renders the beginning of the scene `name` in `format`, as the options' camera sees it, at the
    /// options' rate (the scene's own where there is none; the hand moves as fast at any).
    ///
    /// # Errors
    /// [`SourceError::BadArgument`] for a name no scene has, one this camera does not see, a format its
    /// size does not allow, and a rate outside of 1 to 1000.
    pub fn open(spec: &str, name: &str, format: PixelFormat, options: &Options) -> Result<Self, SourceError> {
        let (mut scene, fps) = Self::find(spec, name, format, options)?;
        let lasts_s = scene.frames as f64 / scene.fps;
        scene.frames = ((lasts_s * fps) as usize).max(1);
        scene.fps = fps;
        let count = scene.frames.min(most_pictures(scene.width, scene.height));
        let pictures = render(&scene, options.view.index(), format, count);
        let info = SourceInfo {
            name: spec.to_owned(),
            width: scene.width,
            height: scene.height,
            format,
            fps: Some(fps),
            frames: None,
            live: true,
            labels: Labels::Order,
        };
        Ok(Self { info, playback: Playback::new(pictures.len(), fps), pictures, delivered: 0 })
    }

    /// The scene, and the rate at which it would be played.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub(super) fn find(
        spec: &str,
        name: &str,
        format: PixelFormat,
        options: &Options,
    ) -> Result<(Scene, f64), SourceError> {
        let scene = simulated::find(spec, name, options.view, format)?;
        let fps = options.fps.unwrap_or(scene.fps);
        if !RATES.contains(&fps) {
            let (least, most) = RATES.into_inner();
            let reason = format!("{fps} frames a second: a scene is played at {least} to {most}");
            return Err(SourceError::argument(spec, reason));
        }
        Ok((scene, fps))
    }
}

impl Source for LiveScene {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        let shown = loop {
            match self.playback.next(unix_us()) {
                Next::Shown(shown) => break shown,
                Next::In(wait) => thread::sleep(wait.min(NAP)),
            }
        };
        let pixels = self.pictures.get(shown.picture).map_or(&[][..], Vec::as_slice);
        let SourceInfo { width, height, format, .. } = self.info;
        let view = FrameView::packed(pixels, width, height, format)
            .map_err(|error| SourceError::argument(&self.info.name, error.to_string()))?;
        let index = self.delivered;
        self.delivered += 1;
        Ok(Some(Frame { view, index, number: shown.number, t_s: shown.at_us * 1e-6, gap: shown.gap }))
    }

    fn now_s(&self) -> Option<f64> {
        Some(unix_us() * 1e-6)
    }
}

fn most_pictures(width: u16, height: u16) -> usize {
    let bytes = usize::from(width) * usize::from(height) * LARGEST_PIXEL;
    (MAX_BYTES / bytes.max(1)).clamp(1, MAX_PICTURES)
}

/// Renders the first `count` frames, on all cores there are.
fn render(scene: &Scene, camera: usize, format: PixelFormat, count: usize) -> Vec<Vec<u8>> {
    let mut pictures = vec![Vec::new(); count];
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let share = count.div_ceil(cores).max(1);
    thread::scope(|threads| {
        for (part, pictures) in pictures.chunks_mut(share).enumerate() {
            threads.spawn(move || {
                let mut rgb = Vec::new();
                for (frame, picture) in (part * share..).zip(pictures) {
                    scene.render_rgb(frame, camera, &mut rgb);
                    *picture = if format == PixelFormat::Rgb888 {
                        rgb.clone()
                    } else {
                        to_format(&rgb, scene.width, scene.height, format)
                    };
                }
            });
        }
    });
    pictures
}

/// Microseconds since 1970; a computer that believes to be before shows the first picture.
fn unix_us() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64() * 1e6
}

/// What is to be shown next.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Next {
    Shown(Shown),
    /// Nothing is due before.
    In(Duration),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Shown {
    /// Its place among the pictures.
    picture: usize,
    /// Counts pictures that were due since the first, missed ones included.
    number: u64,
    /// When it was due, by the clock asked with.
    at_us: f64,
    gap: Gap,
}

/// Which picture is due when: number n of the clock at n / fps, to and fro.
#[derive(Clone, Debug)]
struct Playback {
    pictures: usize,
    fps: f64,
    /// The clock's number and ours of the last one, and whether it was shown.
    last: Option<(u64, Option<u64>)>,
}

/// A greater step is no loss: the clock was set.
const MAX_MISSED: u64 = 1 << 16;

impl Playback {
    const fn new(pictures: usize, fps: f64) -> Self {
        Self { pictures, fps, last: None }
    }

    /// The newest picture that is due at a time and was not shown yet.
    fn next(&mut self, now_us: f64) -> Next {
        let newest = (now_us * self.fps * 1e-6) as u64;
        // the one that is due when it is first asked is not new
        let (last, ours) = *self.last.get_or_insert((newest, None));
        // a moment back is the clock being slewed
        if newest == last || newest + 1 == last {
            let wait_us = (self.at_us(last + 1) - now_us).max(1.0);
            return Next::In(Duration::from_secs_f64(wait_us * 1e-6));
        }
        let missed = newest.checked_sub(last + 1).filter(|missed| *missed <= MAX_MISSED);
        let (number, gap) = match (ours, missed) {
            (None, _) => (0, Gap::None),
            (Some(ours), Some(0)) => (ours + 1, Gap::None),
            (Some(ours), Some(missed)) => (ours + 1 + missed, Gap::Missed(missed)),
            (Some(ours), None) => (ours + 1, Gap::Unknown),
        };
        self.last = Some((newest, Some(number)));
        Next::Shown(Shown { picture: self.picture(newest), number, at_us: self.at_us(newest), gap })
    }

    fn at_us(&self, number: u64) -> f64 {
        number as f64 / self.fps * 1e6
    }

    /// To and fro: 0, 1, 2, 3, 2, 1, 0, 1 ...
    fn picture(&self, number: u64) -> usize {
        let turns = self.pictures as u64 - 1;
        let place = number.checked_rem(2 * turns).unwrap_or(0);
        place.min(2 * turns - place) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::View;

    fn shown(next: Next) -> Shown {
        match next {
            Next::Shown(shown) => shown,
            Next::In(wait) => panic!("nothing for {wait:?}"),
        }
    }

    /// 10 pictures a second, 4 of them, first asked a little after one was due.
    fn begun() -> Playback {
        let mut playback = Playback::new(4, 10.0);
        let Next::In(wait) = playback.next(6_030_000.0) else { panic!("none is new") };
        assert_eq!(wait.as_millis(), 70);
        playback
    }

    #[test]
    fn to_and_fro_and_each_when_it_is_due() {
        let mut playback = begun();
        let order: Vec<_> = (61..=70)
            .map(|number| {
                let at_us = f64::from(number) * 1e5;
                let shown = shown(playback.next(at_us + 1.0));
                assert!(matches!(playback.next(at_us + 2.0), Next::In(_)), "once");
                assert!((shown.at_us - at_us).abs() < 0.01 && shown.gap == Gap::None, "{shown:?}");
                (shown.number, shown.picture)
            })
            .collect();
        let pictures = [1, 2, 3, 2, 1, 0, 1, 2, 3, 2];
        assert_eq!(order, (0..).zip(pictures).collect::<Vec<_>>());
    }

    #[test]
    fn a_program_that_is_late_gets_the_newest_and_is_told_what_it_missed() {
        let mut playback = begun();
        assert_eq!(shown(playback.next(6_100_100.0)).gap, Gap::None);
        let late = shown(playback.next(6_430_000.0));
        assert_eq!((late.gap, late.number, late.picture), (Gap::Missed(2), 3, 2));
        assert!((late.at_us - 6_400_000.0).abs() < 0.01);
    }

    #[test]
    fn two_programs_show_the_same_moment_whenever_they_began() {
        let (mut one, mut other) = (begun(), Playback::new(4, 10.0));
        let _ = other.next(1e9);
        let _ = one.next(1e9);
        for step in 1..50 {
            let now_us = 1e9 + f64::from(step) * 1e5;
            let (one, other) = (shown(one.next(now_us + 10.0)), shown(other.next(now_us + 90_000.0)));
            assert_eq!((one.picture, one.at_us), (other.picture, other.at_us));
        }
    }

    #[test]
    fn a_clock_that_is_set_stops_nothing() {
        let mut playback = begun();
        shown(playback.next(6_100_100.0));
        assert!(matches!(playback.next(6_099_000.0), Next::In(_)), "slewed, not set");
        assert_eq!(shown(playback.next(1_000_000.0)).gap, Gap::Unknown);
        assert_eq!(shown(playback.next(1_100_000.0)).gap, Gap::None);
        assert_eq!(shown(playback.next(1e15)).gap, Gap::Unknown);
        // a single picture is shown again and again
        let mut playback = Playback::new(1, 10.0);
        let _ = playback.next(0.0);
        assert_eq!(shown(playback.next(500_000.0)).picture, 0);
    }

    #[test]
    fn memory_is_bounded() {
        assert_eq!(most_pictures(64, 48), MAX_PICTURES);
        assert_eq!(most_pictures(640, 480), 208);
        assert_eq!(most_pictures(8192, 8192), 1);
    }

    #[test]
    fn its_pictures_are_those_of_the_scene_at_any_rate() {
        let options = Options { view: View::Right, fps: Some(4.0), ..Options::default() };
        let mut live =
            LiveScene::open("sim:static-16px", "static-16px", PixelFormat::Yuyv, &options).unwrap();
        assert!(live.info().live && live.info().fps == Some(4.0));
        let scene = Scene::named("static-16px").unwrap();
        assert_eq!(live.pictures.len(), (scene.frames as f64 / scene.fps * 4.0) as usize);
        let mut rgb = Vec::new();
        scene.render_rgb(0, 1, &mut rgb);
        assert_eq!(live.pictures[0], to_format(&rgb, scene.width, scene.height, PixelFormat::Yuyv));
        let before_s = live.now_s().unwrap();
        let frame = live.next().unwrap().unwrap();
        assert_eq!((frame.index, frame.number, frame.gap), (0, 0, Gap::None));
        assert!(frame.t_s > before_s && frame.t_s <= before_s + 0.5, "the next that is due");
        assert!(frame.t_s <= live.now_s().unwrap(), "not before it is due");
    }

    #[test]
    fn what_cannot_be_played_is_refused() {
        let refused = |name: &str, fps| {
            let options = Options { fps, ..Options::default() };
            let spec = format!("sim:{name}");
            LiveScene::open(&spec, name, PixelFormat::Rgb888, &options).err().unwrap().to_string()
        };
        assert!(refused("nothing", None).contains("no scene is called 'nothing'"));
        let message = refused("still", Some(0.5));
        assert!(message.contains("0.5 frames a second") && message.contains("1 to 1000"), "{message}");
    }
}
