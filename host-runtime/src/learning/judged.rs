//! How taught colours do in a whole picture: which balls they find there, and what else they would take for
//! one.

use super::clash_in_words;
use crate::scene_file::Seeds;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::Matcher;
use tetrad_core::vision::frame::{FrameView, Rgb};
use tetrad_core::vision::tracker::CameraTracker;

/// The ball and its soft rim, in radii: left out of what is mistaken for it, as learning does.
const RIM: f32 = 1.3;

/// The part of another ball's disc that is surely its own, in radii.
const INSIDE: f32 = 0.9;

/// Another ball looks like this one from this share on, percent: below it is the light on its rim.
const ALIKE_PERCENT: u8 = 10;

/// A ball in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Pixels.
    pub centre: ImagePoint,
    /// Pixels.
    pub diameter: f32,
}

impl Disc {
    /// Whether a pixel lies within so many radii.
    fn holds(&self, x: i32, y: i32, radii: f32) -> bool {
        self.centre.distance(ImagePoint::new(x as f32, y as f32)) <= 0.5 * self.diameter * radii
    }
}

/// How one ball's colours do in one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// Where the tracker finds the ball; `None`: not at all.
    pub found: Option<Disc>,
    /// Of 1000 pixels elsewhere in the picture, how many pass eq. 1 too.
    pub clash_permille: u16,
    /// Of each other ball, how many percent of its pixels pass, ordered as [`Ball::ALL`].
    pub of_others: [u8; BALLS],
}

impl Judged {
    /// The clash in words.
    #[must_use]
    pub fn words(&self) -> String {
        let alike =
            Ball::ALL.into_iter().zip(self.of_others).filter(|(_, percent)| *percent >= ALIKE_PERCENT);
        let alike: Vec<_> =
            alike.map(|(ball, percent)| format!("{percent} % of the {} ball", ball.name())).collect();
        let background = clash_in_words(self.clash_permille);
        match (alike.is_empty(), self.clash_permille) {
            (true, 0..10) => format!("well apart: {background}"),
            (true, _) => format!("may be mistaken: {background}"),
            (false, 0..10) => format!("may be mistaken: {} would pass for it", alike.join(" and ")),
            (false, _) => {
                format!("may be mistaken: {} would pass for it, and {background}", alike.join(" and "))
            }
        }
    }
}

/// How these balls do in a picture; `places` says where balls are known to be in it.
#[must_use]
pub fn judge(
    frame: &FrameView<'_>,
    balls: &[Option<LearntBall>; BALLS],
    places: &Seeds,
) -> [Option<Judged>; BALLS] {
    let found = find(frame, balls, places);
    Ball::ALL.map(|ball| {
        let learnt = balls[ball.index()].as_ref()?;
        let matcher = matcher(learnt)?;
        let others: [Option<Disc>; BALLS] =
            std::array::from_fn(|at| if at == ball.index() { None } else { found[at] });
        let mut elsewhere = Count::default();
        let mut of_others = [Count::default(); BALLS];
        each_pixel(frame, |x, y, p| {
            let passes = matcher.accepts(p);
            for (count, disc) in of_others.iter_mut().zip(&others) {
                if disc.is_some_and(|disc| disc.holds(x, y, INSIDE)) {
                    count.add(passes);
                }
            }
            if !found[ball.index()].is_some_and(|disc| disc.holds(x, y, RIM)) {
                elsewhere.add(passes);
            }
        });
        Some(Judged {
            found: found[ball.index()],
            clash_permille: elsewhere.share(1000),
            of_others: of_others.map(|count| count.share(100) as u8),
        })
    })
}

/// The picture in grey and dimmed, and in it bright and chequered what would pass for the ball and is none
/// of it; the ball itself as it is. RGB, row by row.
#[must_use]
pub fn mistaken(frame: &FrameView<'_>, learnt: &LearntBall, found: Option<Disc>) -> Vec<u8> {
    let mut rgb = Vec::with_capacity(usize::from(frame.width()) * usize::from(frame.height()) * 3);
    let matcher = matcher(learnt);
    each_pixel(frame, |x, y, p| {
        let shown = if found.is_some_and(|disc| disc.holds(x, y, RIM)) {
            p
        } else if matcher.is_some_and(|matcher| matcher.accepts(p)) {
            if (x / CHEQUER + y / CHEQUER) % 2 == 0 { MARK } else { MARK_BETWEEN }
        } else {
            let grey = (u32::from(p.r) + u32::from(p.g) + u32::from(p.b)) / 3;
            let grey = (grey * 2 / 5) as u8;
            Rgb::new(grey, grey, grey)
        };
        rgb.extend([shown.r, shown.g, shown.b]);
    });
    rgb
}

/// Side of a square of the chequer, pixels.
const CHEQUER: i32 = 2;
const MARK: Rgb = Rgb::new(255, 255, 255);
const MARK_BETWEEN: Rgb = Rgb::new(255, 0, 255);

/// The balls that a tracker finds, each for itself: that they do not stand like one rigid frame is not a
/// matter of colours.
fn find(frame: &FrameView<'_>, balls: &[Option<LearntBall>; BALLS], places: &Seeds) -> [Option<Disc>; BALLS] {
    let config = TrackerConfig { rigid: false, ..TrackerConfig::paper() };
    let Ok(mut tracker) = CameraTracker::new(config, *balls) else { return [None; BALLS] };
    for (ball, place) in Ball::ALL.into_iter().zip(places) {
        if let Some(place) = place {
            tracker.place(ball, *place);
        }
    }
    let report = tracker.step(frame, 0, &[None; BALLS]);
    report
        .observations
        .map(|seen| seen.state.is_measured().then_some(Disc { centre: seen.centre, diameter: seen.diameter }))
}

fn matcher(learnt: &LearntBall) -> Option<Matcher> {
    Matcher::new(&learnt.reference, LearnConfig::default().alpha_256).ok()
}

fn each_pixel(frame: &FrameView<'_>, mut act: impl FnMut(i32, i32, Rgb)) {
    for y in 0..i32::from(frame.height()) {
        for x in 0..i32::from(frame.width()) {
            // every pixel of the picture is in it
            act(x, y, frame.pixel(x, y).unwrap_or_default());
        }
    }
}

#[derive(Clone, Copy, Default)]
struct Count {
    passed: u64,
    all: u64,
}

impl Count {
    fn add(&mut self, passes: bool) {
        self.all += 1;
        self.passed += u64::from(passes);
    }

    fn share(self, of: u64) -> u16 {
        (self.passed * of).checked_div(self.all).unwrap_or(0) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::{learn_at, tracked_as};
    use tetrad_core::vision::frame::PixelFormat;
    use tetrad_fixtures::{Background, Scene};

    struct Taught {
        rgb: Vec<u8>,
        size: (u16, u16),
        balls: [Option<LearntBall>; BALLS],
        at: Seeds,
    }

    fn taught(background: Background) -> Taught {
        let mut scene = Scene::named("static-32px").unwrap();
        scene.background = background;
        let mut rgb = Vec::new();
        scene.render_rgb(0, 1, &mut rgb);
        let at = scene.truth(0, 1).map(|ball| {
            let (u, v) = ball.outline_centre;
            Some(ImagePoint::new(u as f32, v as f32))
        });
        let size = (scene.width, scene.height);
        let frame = FrameView::packed(&rgb, size.0, size.1, PixelFormat::Rgb888).unwrap();
        let balls = learn_at(&frame, &at, &LearnConfig::default()).unwrap();
        let balls = balls.map(|learnt| learnt.as_ref().map(tracked_as));
        Taught { rgb, size, balls, at }
    }

    impl Taught {
        fn frame(&self) -> FrameView<'_> {
            FrameView::packed(&self.rgb, self.size.0, self.size.1, PixelFormat::Rgb888).unwrap()
        }

        /// A square of one colour in a corner of the picture.
        fn paint(&mut self, side: usize, colour: Rgb) {
            for y in 0..side {
                for x in 0..side {
                    let at = (y * usize::from(self.size.0) + x) * 3;
                    self.rgb[at..at + 3].copy_from_slice(&[colour.r, colour.g, colour.b]);
                }
            }
        }
    }

    #[test]
    fn before_grey_all_are_found_and_nothing_is_mistaken() {
        let taught = taught(Background::Plain(110.0));
        for (judged, at) in judge(&taught.frame(), &taught.balls, &[None; BALLS]).iter().zip(taught.at) {
            let judged = judged.unwrap();
            let found = judged.found.expect("it is found without being told where");
            assert!(found.centre.distance(at.unwrap()) < 1.0, "{found:?}");
            assert!(judged.words().starts_with("well apart"), "{judged:?}");
        }
    }

    #[test]
    fn a_patch_of_a_balls_colour_is_marked_and_told() {
        let mut taught = taught(Background::Plain(110.0));
        let red = taught.balls[0].unwrap();
        taught.paint(120, red.reference.typical);
        let judged = judge(&taught.frame(), &taught.balls, &taught.at);
        let of_red = judged[0].unwrap();
        let permille = 120 * 120 * 1000 / (u32::from(taught.size.0) * u32::from(taught.size.1));
        assert!(u32::from(of_red.clash_permille).abs_diff(permille) <= 2, "{of_red:?}, not {permille}");
        assert!(of_red.words().starts_with("may be mistaken: "), "{}", of_red.words());
        assert!(judged[2].unwrap().words().starts_with("well apart"), "blue is no red");

        let picture = mistaken(&taught.frame(), &red, of_red.found);
        let pixel = |x: usize, y: usize| {
            let at = (y * usize::from(taught.size.0) + x) * 3;
            [picture[at], picture[at + 1], picture[at + 2]]
        };
        assert_eq!((pixel(10, 10), pixel(12, 10)), ([255, 255, 255], [255, 0, 255]), "chequered");
        let [r, g, b] = pixel(200, 10);
        assert!(r == g && g == b && r < 60, "the background is grey and dim");
        let own = of_red.found.unwrap().centre;
        let [r, g, _] = pixel(own.u as usize, own.v as usize);
        assert!(r > g, "the ball is as it is");
    }

    #[test]
    fn what_is_not_in_the_picture_is_not_found() {
        let taught = taught(Background::Plain(110.0));
        let grey = vec![110; taught.rgb.len()];
        let frame = FrameView::packed(&grey, taught.size.0, taught.size.1, PixelFormat::Rgb888).unwrap();
        for judged in judge(&frame, &taught.balls, &[None; BALLS]) {
            assert_eq!(judged.map(|judged| (judged.found, judged.clash_permille)), Some((None, 0)));
        }
        assert_eq!(judge(&frame, &[None; BALLS], &[None; BALLS]), [None; BALLS]);
    }

    #[test]
    fn another_ball_that_passes_is_named() {
        let judged = Judged { found: None, clash_permille: 3, of_others: [0, 0, 0, 40] };
        assert_eq!(judged.words(), "may be mistaken: 40 % of the yellow ball would pass for it");
    }
}
