use super::*;
use crate::observation::Ball;
use crate::vision::centre::row_edge_centre;
use crate::vision::colour::Primary;
use crate::vision::edges::{RowEdges, SpiralLimits};
use crate::vision::frame::Rgb;
use crate::vision::painter::Painter;

fn matcher(ball: Ball) -> Matcher {
    Matcher::with_threshold(Primary::of(ball), Painter::colour(ball), 6500)
}

/// The rim of a ball in a picture, from the row edges around (`x`, `y`).
fn rim(
    picture: &Painter,
    ball: Ball,
    (x, y): (i32, i32),
    diameter: f32,
    memory: Option<&RimMemory>,
) -> Result<(Rim, Blob), RimRefusal> {
    let (view, matcher) = (picture.view(), matcher(ball));
    let (mut edges, mut tested) = (RowEdges::new(), 0);
    let limits = SpiralLimits { side: 3.0 * diameter, min_match_256: 12 };
    edges.collect(&view, &matcher, (x, y), limits, &mut tested).unwrap();
    let blob = row_edge_centre(&view, &edges).unwrap();
    let sought =
        Sought { blob: &blob, matcher: &matcher, memory, expected: None, diameter, aspect: 1.0, speed: 0.0 };
    let before = tested;
    let rim = find_rim(&view, &sought, &CentreConfig::default(), &mut tested);
    assert!(tested > before && tested - before < 6000, "{}", tested - before);
    rim.map(|rim| (rim, blob))
}

fn off(rim: &Rim, u: f32, v: f32) -> f32 {
    rim.centre.distance(ImagePoint::new(u, v))
}

#[test]
fn a_disc_anywhere_between_pixels_is_measured_to_a_twentieth() {
    for (diameter, bound) in [(6.0, 0.06), (9.0, 0.03), (16.0, 0.02), (31.0, 0.02), (70.0, 0.02)] {
        for step in 0..12 {
            let (u, v) = (100.0 + 0.083 * step as f32, 90.0 - 0.37 * step as f32);
            for ball in Ball::ALL {
                let mut picture = Painter::new();
                picture.ball(ball, u, v, diameter);
                let (rim, _) = rim(&picture, ball, (u as i32, v as i32), diameter, None).unwrap();
                assert!(off(&rim, u, v) < bound, "{ball:?} {diameter} px at {u}, {v}: {rim:?}");
                assert!((rim.diameter - diameter).abs() < 0.2, "{diameter}: {rim:?}");
                assert!(rim.visible > 0.9, "{rim:?}");
            }
        }
    }
}

#[test]
fn half_of_a_ball_has_the_centre_of_the_whole() {
    let (u, v, diameter) = (100.3, 90.6, 20.0);
    let mut picture = Painter::new();
    picture.ball(Ball::Red, u, v, diameter);
    let (whole, blob) = rim(&picture, Ball::Red, (100, 90), diameter, None).unwrap();
    let memory = RimMemory::after(None, &whole, &blob, &CentreConfig::default());
    let skin = Rgb::new(205, 160, 135);
    picture.block(101, 60, 140, 120, skin);
    let (part, _) = rim(&picture, Ball::Red, (95, 90), diameter, Some(&memory)).unwrap();
    assert!(off(&part, u, v) < 0.25, "{part:?}");
    assert!((0.3..0.65).contains(&part.visible), "{part:?}");
    assert!(part.covariance.uu > whole.covariance.uu);
}

#[test]
fn a_third_of_the_rim_still_has_the_centre() {
    let (u, v, diameter) = (100.3, 90.6, 20.0);
    let mut picture = Painter::new();
    picture.ball(Ball::Green, u, v, diameter);
    let (whole, blob) = rim(&picture, Ball::Green, (100, 90), diameter, None).unwrap();
    let memory = RimMemory::after(None, &whole, &blob, &CentreConfig::default());
    // 120 degrees of it are to the left of column 95.3
    picture.block(95, 60, 140, 120, Rgb::new(205, 160, 135));
    let (part, _) = rim(&picture, Ball::Green, (92, 90), diameter, Some(&memory)).unwrap();
    assert!(off(&part, u, v) < 0.5, "{part:?}");
    assert!((0.15..0.45).contains(&part.visible), "{part:?}");
}

#[test]
fn a_size_remembered_for_half_a_second_is_not_held_against_a_ball_that_came_nearer() {
    let (u, v) = (100.3, 90.6);
    let mut picture = Painter::new();
    picture.ball(Ball::Red, u, v, 40.0);
    let (whole, blob) = rim(&picture, Ball::Red, (100, 90), 40.0, None).unwrap();
    let memory = RimMemory::after(None, &whole, &blob, &CentreConfig::default());
    let mut picture = Painter::new();
    picture.ball(Ball::Red, u, v, 52.0);
    picture.block(112, 50, 150, 130, Rgb::new(205, 160, 135));
    let after = |elapsed_us| {
        let memory = memory.later(elapsed_us);
        let (rim, _) = rim(&picture, Ball::Red, (95, 90), 40.0, Some(&memory)).unwrap();
        off(&rim, u, v)
    };
    let (late, at_once) = (after(560_000), after(33_000));
    assert!(late < 0.3 && at_once > 3.0 * late, "{late} {at_once}");
    assert_eq!(memory.later(33_000), memory, "frames of a video are not far apart");
}

#[test]
fn whole_pixels_do_not_make_square_ones_oblong() {
    assert_eq!(aspect_of_pixels(4.0 / 6.0, 6.0), 1.0);
    assert_eq!(aspect_of_pixels(15.0 / 17.0, 17.0), 1.0);
    assert_eq!(aspect_of_pixels(0.5, 30.0), 0.5);
    assert_eq!(aspect_of_pixels(1.33, 24.0), 1.33);
}

#[test]
fn a_highlight_on_the_rim_is_left_out() {
    let (u, v, diameter) = (100.3, 90.6, 24.0);
    let mut picture = Painter::new();
    picture.ball(Ball::Blue, u, v, diameter);
    picture.block(106, 84, 110, 89, Rgb::new(250, 250, 250));
    let (rim, _) = rim(&picture, Ball::Blue, (97, 92), diameter, None).unwrap();
    assert!(off(&rim, u, v) < 0.08, "{rim:?}");
}

#[test]
fn a_square_is_no_rim_and_black_has_no_colour() {
    let view_of = |colour: Rgb| {
        let mut picture = Painter::new();
        picture.block(90, 80, 93, 110, colour);
        picture
    };
    let thin = view_of(Painter::colour(Ball::Red));
    let refused = rim(&thin, Ball::Red, (91, 95), 20.0, None);
    assert!(refused.is_err(), "{refused:?}");
    let picture = view_of(Rgb::new(0, 0, 0));
    let matcher = Matcher::with_threshold(Primary::Red, Rgb::new(2, 0, 0), -12_240);
    let blob = Blob {
        centre: ImagePoint::new(91.0, 95.0),
        diameter: 3.0,
        height: 30.0,
        area: 90.0,
        matched: 90,
        roundness: 0.5,
        colour: Rgb::new(0, 0, 0),
        bounds: (90, 92, 80, 109),
        cut: false,
    };
    let sought = Sought {
        blob: &blob,
        matcher: &matcher,
        memory: None,
        expected: None,
        diameter: 3.0,
        aspect: 1.0,
        speed: 0.0,
    };
    let refused = find_rim(&picture.view(), &sought, &CentreConfig::default(), &mut 0);
    assert_eq!(refused, Err(RimRefusal::NoColour));
}

#[test]
fn pixels_that_are_not_square_are_allowed_for() {
    // columns twice as dense as rows: an ellipse of 30 x 15 pixels
    let (u, v) = (100.3f32, 90.6f32);
    let mut data = [110u8; 240 * 180 * 3];
    for (i, pixel) in data.chunks_exact_mut(3).enumerate() {
        let (x, y) = ((i % 240) as f32, (i / 240) as f32);
        let mut inside = 0u32;
        for k in 0..64 {
            let (du, dv) = (x + (k % 8) as f32 / 8.0 - 0.4375 - u, y + (k / 8) as f32 / 8.0 - 0.4375 - v);
            inside += u32::from(du * du + 4.0 * dv * dv <= 15.0 * 15.0);
        }
        for (value, of_ball) in pixel.iter_mut().zip([200u32, 30, 35]) {
            *value = ((of_ball * inside + 110 * (64 - inside)) / 64) as u8;
        }
    }
    let view = FrameView::packed(&data, 240, 180, crate::vision::frame::PixelFormat::Rgb888).unwrap();
    let matcher = matcher(Ball::Red);
    let (mut edges, mut tested) = (RowEdges::new(), 0);
    let limits = SpiralLimits { side: 90.0, min_match_256: 12 };
    edges.collect(&view, &matcher, (100, 90), limits, &mut tested).unwrap();
    let blob = row_edge_centre(&view, &edges).unwrap();
    let sought = Sought {
        blob: &blob,
        matcher: &matcher,
        memory: None,
        expected: None,
        diameter: 30.0,
        aspect: 0.5,
        speed: 0.0,
    };
    let rim = find_rim(&view, &sought, &CentreConfig::default(), &mut tested).unwrap();
    assert!(off(&rim, u, v) < 0.03, "{rim:?}");
    assert!((rim.diameter - 30.0).abs() < 0.2, "{rim:?}");
}
