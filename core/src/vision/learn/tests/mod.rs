extern crate std;

pub(crate) mod picture;

use super::*;
use crate::vision::colour::Matcher;
use crate::vision::frame::{PixelFormat, Rgb};
use picture::{Ball, Picture, Random};
use proptest::prelude::*;

const RED: Rgb = Rgb::new(190, 30, 36);
const BLUE: Rgb = Rgb::new(30, 60, 190);
const GREY: Rgb = Rgb::new(150, 148, 140);
const SKIN: Rgb = Rgb::new(200, 150, 125);

fn learn_red(picture: &Picture, u: f32, v: f32) -> Result<Learnt, LearnError> {
    picture.frame(|frame| learn(frame, Primary::Red, ImagePoint::new(u, v), &LearnConfig::default()))
}

/// Wood, cloth, paper: colours that differ from pixel to pixel.
fn textured(x: i32, y: i32) -> Rgb {
    let wave = (x * 7 + y * 13) % 31 + if (x / 9 + y / 7) % 2 == 0 { 40 } else { 0 };
    Rgb::new((110 + wave) as u8, (100 + wave) as u8, (80 + wave / 2) as u8)
}

fn assert_found(learnt: &Learnt, ball: &Ball, what: &str) {
    let off = learnt.centre.distance(ImagePoint::new(ball.u, ball.v));
    assert!(off <= 0.6 + 0.03 * ball.diameter, "{what}: centre off by {off} px: {learnt:?}");
    let slack = 1.2 + 0.08 * ball.diameter;
    let d = learnt.diameter;
    assert!((d - ball.diameter).abs() <= slack, "{what}: diameter {d} of {}", ball.diameter);
}

/// Shares of the ball's pixels and of its neighbours' that pass eq. 1.
fn shares(picture: &Picture, learnt: &Learnt, ball: &Ball) -> (f32, f32) {
    let matcher = Matcher::new(&learnt.reference, LearnConfig::default().alpha_256).unwrap();
    let (mut inside, mut around) = ((0, 0), (0, 0));
    for (i, p) in picture.pixels.iter().enumerate() {
        let (x, y) = ((i % picture.width) as f32, (i / picture.width) as f32);
        let q = (x - ball.u).hypot(y - ball.v) / (ball.diameter / 2.0);
        let counter = match q {
            q if q < 0.9 => &mut inside,
            q if q > 1.2 && q < 2.0 => &mut around,
            _ => continue,
        };
        counter.0 += i32::from(matcher.accepts(*p));
        counter.1 += 1;
    }
    (inside.0 as f32 / inside.1 as f32, around.0 as f32 / around.1 as f32)
}

#[test]
fn balls_of_every_size_and_light_are_found_and_told_from_their_surroundings() {
    for diameter in [5.0, 6.5, 8.0, 12.0, 16.0, 25.0, 40.0, 65.0, 90.0, 120.0] {
        for (k, light) in [0.3f32, 1.9, 3.5, 5.2].into_iter().enumerate() {
            let centre = 100.0 + 0.3 * k as f32;
            let ball = Ball { light, ..Ball::new(centre, 99.6, diameter, RED) };
            let picture = Picture::new(200, 200, textured).with(ball).with_noise(6);
            let what = std::format!("{diameter} px lit from {light}");
            let learnt = learn_red(&picture, ball.u, ball.v).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_found(&learnt, &ball, &what);
            let (inside, around) = shares(&picture, &learnt, &ball);
            assert!(inside > 0.85 && around < 0.03, "{what}: {inside} of the ball, {around} around");
            assert!(learnt.blob.is_ok(), "{what}: {:?}", learnt.blob);
        }
    }
}

#[test]
fn every_format_teaches_the_same_ball() {
    use PixelFormat::{Bgr888, Nv12, Rgb565Be, Rgb565Le, Rgb888, Rgba8888, Uyvy, Yuyv};
    let ball = Ball::new(61.3, 47.8, 22.0, BLUE);
    let picture = Picture::new(120, 100, textured).with(ball);
    for format in [Rgb888, Bgr888, Rgba8888, Rgb565Le, Rgb565Be, Yuyv, Uyvy, Nv12] {
        let learnt = picture
            .frame_in(format, |frame| {
                learn(frame, Primary::Blue, ImagePoint::new(60.0, 50.0), &LearnConfig::default())
            })
            .unwrap_or_else(|e| panic!("{format:?}: {e}"));
        assert_found(&learnt, &ball, &std::format!("{format:?}"));
    }
}

#[test]
fn the_point_may_be_anywhere_in_the_ball_even_on_its_highlight() {
    for diameter in [14.0, 40.0, 100.0] {
        let ball = Ball::new(100.0, 100.0, diameter, RED);
        let picture = Picture::new(200, 200, textured).with(ball).with_noise(4);
        let (hu, hv) = ball.highlight_at();
        let learnt = learn_red(&picture, hu, hv).unwrap();
        assert_found(&learnt, &ball, &std::format!("{diameter} px on its highlight"));
        for k in 0..12u8 {
            let (sin, cos) = (f32::from(k) * 0.52).sin_cos();
            let reach = 0.35 * diameter;
            let learnt = learn_red(&picture, ball.u + reach * cos, ball.v + reach * sin).unwrap();
            assert_found(&learnt, &ball, &std::format!("{diameter} px from direction {k}"));
        }
    }
}

#[test]
fn fingers_and_a_like_ball_beside_it_do_not_move_the_outline() {
    let ball = Ball::new(100.0, 100.0, 50.0, RED);
    let finger = |u, v| Ball { shadow: 0.7, highlight: false, ..Ball::new(u, v, 34.0, SKIN) };
    let picture = Picture::new(200, 200, |_, _| GREY)
        .with(finger(72.0, 84.0))
        .with(finger(68.0, 112.0))
        .with(finger(96.0, 140.0))
        .with(ball)
        .with_noise(5);
    assert_found(&learn_red(&picture, 104.0, 96.0).unwrap(), &ball, "fingers");
    let neighbour = Ball::new(152.0, 100.0, 50.0, RED);
    let picture = Picture::new(200, 200, |_, _| GREY).with(ball).with(neighbour).with_noise(5);
    assert_found(&learn_red(&picture, 104.0, 96.0).unwrap(), &ball, "a neighbour");
}

#[test]
fn a_dark_ball_on_a_black_curtain_before_a_white_wall_is_not_the_curtain() {
    let ball = Ball { highlight: false, ..Ball::new(100.0, 100.0, 40.0, Rgb::new(80, 22, 26)) };
    let picture = Picture::new(200, 200, |x, y| {
        let curtain = (x - 100).pow(2) + (y - 100).pow(2) < 50 * 50;
        if curtain { Rgb::new(24, 24, 26) } else { Rgb::new(190, 190, 180) }
    })
    .with(ball)
    .with_noise(4);
    assert_found(&learn_red(&picture, 97.0, 92.0).unwrap(), &ball, "curtain");
}

#[test]
fn blur_of_a_quarter_of_the_diameter_is_borne() {
    let ball = Ball::new(60.0, 60.0, 24.0, RED);
    let mut picture = Picture::new(120, 120, textured).with(ball);
    // A camera moving sideways by 6 pixels while the shutter is open.
    let sharp = picture.pixels.clone();
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let window = &sharp[i.saturating_sub(3)..(i + 4).min(sharp.len())];
        let mean = |c: fn(&Rgb) -> u8| {
            (window.iter().map(|p| u32::from(c(p))).sum::<u32>() / window.len() as u32) as u8
        };
        *pixel = Rgb::new(mean(|p| p.r), mean(|p| p.g), mean(|p| p.b));
    }
    assert_found(&learn_red(&picture, 62.0, 60.0).unwrap(), &ball, "blur");
}

#[test]
fn each_refusal_has_its_reason() {
    let plain = Picture::new(160, 120, |_, _| GREY).with_noise(3);
    assert_eq!(learn_red(&plain, 160.0, 50.0), Err(LearnError::Outside));
    assert_eq!(learn_red(&plain, -3.0, 50.0), Err(LearnError::Outside));
    assert_eq!(learn_red(&plain, f32::NAN, 50.0), Err(LearnError::Outside));
    assert_eq!(learn_red(&plain, 80.0, 60.0), Err(LearnError::Background));
    for level in [255, 0] {
        let flat = Picture::new(160, 120, |_, _| Rgb::new(level, level, level));
        assert_eq!(learn_red(&flat, 80.0, 60.0), Err(LearnError::Saturated));
    }
    let reddish = Picture::new(160, 120, |x, _| Rgb::new(130 + (x / 8) as u8, 90, 90)).with_noise(5);
    assert!(matches!(
        learn_red(&reddish, 80.0, 60.0),
        Err(LearnError::Background | LearnError::TooLarge | LearnError::NoContrast)
    ));
    let all_red = Picture::new(400, 300, |_, _| RED).with_noise(5);
    assert_eq!(learn_red(&all_red, 200.0, 150.0), Err(LearnError::TooLarge));
    let large = Picture::new(400, 400, |_, _| GREY).with(Ball::new(200.0, 200.0, 145.0, RED));
    assert_eq!(learn_red(&large, 200.0, 200.0), Err(LearnError::TooLarge));
    let small = Picture::new(160, 120, |_, _| GREY)
        .with(Ball { highlight: false, ..Ball::new(80.0, 60.0, 2.6, RED) });
    assert_eq!(learn_red(&small, 80.0, 60.0), Err(LearnError::TooSmall));
    // A ball half of whose neighbourhood has its own colour.
    let mut random = Random(7);
    let confetti = Picture::new(160, 120, |_, _| if random.below(20) < 11 { RED } else { GREY }).with(Ball {
        highlight: false,
        shadow: 1.0,
        ..Ball::new(80.0, 60.0, 40.0, RED)
    });
    assert_eq!(learn_red(&confetti, 80.0, 60.0), Err(LearnError::NoContrast));
}

#[test]
fn beside_a_ball_is_background() {
    let ball = Ball::new(80.0, 60.0, 40.0, RED);
    let picture = Picture::new(160, 120, |_, _| GREY).with(ball);
    assert_eq!(learn_red(&picture, 80.0 + 26.0, 60.0), Err(LearnError::Background));
    // The wrong ball.
    let blue = Picture::new(160, 120, |_, _| GREY).with(Ball::new(80.0, 60.0, 40.0, BLUE));
    assert_eq!(learn_red(&blue, 80.0, 60.0), Err(LearnError::Background));
}

#[test]
fn the_clash_score_is_the_share_of_the_rest_that_matches() {
    let ball = Ball::new(80.0, 60.0, 30.0, RED);
    let alone = Picture::new(320, 120, |_, _| GREY).with(ball);
    assert_eq!(learn_red(&alone, 80.0, 60.0).unwrap().clash_permille, 0);
    let wall = Picture::new(320, 120, |x, _| if x >= 160 { RED } else { GREY }).with(ball);
    let clash = learn_red(&wall, 80.0, 60.0).unwrap().clash_permille;
    assert!((500..=540).contains(&clash), "{clash}");
}

#[test]
fn the_work_is_bounded_whatever_the_picture() {
    let mut random = Random(3);
    let mut any = || Rgb::new(random.below(256) as u8, random.below(256) as u8, random.below(256) as u8);
    let noise = Picture::new(400, 300, |_, _| any());
    let ball = Picture::new(400, 300, textured).with(Ball::new(200.0, 150.0, 120.0, RED));
    if let Ok(learnt) = learn_red(&noise, 200.0, 150.0) {
        assert!(learnt.pixels_tested <= 1_000_000, "{}", learnt.pixels_tested);
    }
    let learnt = learn_red(&ball, 200.0, 150.0).unwrap();
    assert!(learnt.pixels_tested <= 400_000, "{}", learnt.pixels_tested);
}

#[test]
fn the_same_picture_teaches_the_same_twice() {
    let picture = Picture::new(120, 100, textured).with(Ball::new(60.0, 50.0, 22.0, RED)).with_noise(6);
    assert_eq!(learn_red(&picture, 61.0, 50.0), learn_red(&picture, 61.0, 50.0));
}

proptest! {
    /// Any small picture, any point, any numbers in the configuration: an answer, never a panic.
    #[test]
    fn nothing_panics(
        bytes in prop::collection::vec(any::<u8>(), 24 * 18 * 3),
        u in prop::num::f32::ANY,
        v in -2.0f32..20.0,
        least in prop::num::f32::ANY,
        most in prop::num::f32::ANY,
        alpha_256 in any::<u16>(),
        chroma in any::<i16>(),
    ) {
        let frame = FrameView::packed(&bytes, 24, 18, PixelFormat::Rgb888).unwrap();
        let config = LearnConfig {
            alpha_256: alpha_256 % 300,
            least_diameter: least,
            most_diameter: most,
            least_chroma: i32::from(chroma),
            least_support: 0,
            least_rim: 0.0,
            least_separation: 0.0,
            ..LearnConfig::default()
        };
        for primary in Primary::ALL {
            let _ = learn(&frame, primary, ImagePoint::new(u, v), &config);
            let _ = learn(&frame, primary, ImagePoint::new(v, v), &config);
        }
    }
}

mod scan {
    use super::*;

    fn learnt_picture() -> (Picture, Learnt) {
        let ball = Ball::new(100.0, 60.0, 40.0, RED);
        let picture = Picture::new(200, 120, |_, _| Rgb::new(220, 220, 215)).with(ball);
        let learnt = learn_red(&picture, 95.0, 60.0).unwrap();
        (picture, learnt)
    }

    fn scan<const N: usize>(picture: &Picture, learnt: &Learnt) -> HorizontalScan<N> {
        picture.frame(|frame| {
            HorizontalScan::through(frame, &learnt.reference, 128, learnt.centre, learnt.diameter).unwrap()
        })
    }

    #[test]
    fn it_shows_what_figures_1_and_2_show() {
        let (picture, learnt) = learnt_picture();
        let scan = scan::<256>(&picture, &learnt);
        assert_eq!((scan.row, scan.step), (60, 1));
        let (first, last) = scan.borders.unwrap();
        assert!((79..=82).contains(&first) && (118..=121).contains(&last), "{first} {last}");
        for c in &scan.columns {
            assert!((c.m - (c.v - c.d)).abs() < 1e-3, "{c:?}");
            let p = picture.pixels[60 * 200 + usize::from(c.x)];
            assert_eq!(c.r, f32::from(p.r) / 255.0);
            // Figure 2: M tells the ball from the white beside it, on either side of the threshold.
            let x = f32::from(c.x);
            if !(78.0..=122.0).contains(&x) {
                assert!(c.m < scan.threshold, "{c:?}");
            } else if (84.0..=86.0).contains(&x) || (110.0..=116.0).contains(&x) {
                assert!(c.m > scan.threshold, "{c:?}");
            }
        }
        let x = |c: Option<&ScanColumn>| c.map(|c| c.x);
        assert!(x(scan.columns.first()) <= Some(40) && x(scan.columns.last()) >= Some(160));
    }

    #[test]
    fn a_wide_window_leaves_columns_out_and_says_so() {
        let (picture, learnt) = learnt_picture();
        let (wide, narrow) = (scan::<256>(&picture, &learnt), scan::<50>(&picture, &learnt));
        assert_eq!(narrow.step, 3);
        assert!(narrow.columns.len() > 35);
        assert_eq!(narrow.borders, wide.borders);
        let every_third: std::vec::Vec<_> = wide.columns.iter().step_by(3).copied().collect();
        assert_eq!(narrow.columns.as_slice(), every_third.as_slice());
    }

    #[test]
    fn the_window_ends_with_the_picture_and_a_bad_centre_is_refused() {
        let (picture, learnt) = learnt_picture();
        picture.frame(|frame| {
            let at = |u, v| {
                HorizontalScan::<300>::through(frame, &learnt.reference, 128, ImagePoint::new(u, v), 40.0)
            };
            let corner = at(2.0, 119.0).unwrap();
            assert_eq!(corner.columns.first().map(|c| c.x), Some(0));
            assert_eq!(corner.borders, None);
            assert_eq!(at(2.0, 120.0), Err(LearnError::Outside));
            assert_eq!(at(f32::INFINITY, 1.0), Err(LearnError::Outside));
            let grey = Reference { typical: GREY, background: RED, ..learnt.reference };
            let none = HorizontalScan::<9>::through(frame, &grey, 128, learnt.centre, 40.0);
            assert_eq!(none, Err(LearnError::NoContrast));
            let none = HorizontalScan::<0>::through(frame, &learnt.reference, 128, learnt.centre, 40.0);
            assert!(none.unwrap().columns.is_empty());
        });
    }
}
