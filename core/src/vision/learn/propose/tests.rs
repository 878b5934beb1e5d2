extern crate std;

use super::*;
use crate::geometry::ImagePoint;
use crate::vision::frame::Rgb;
use crate::vision::learn::tests::picture::{Ball as Drawn, Picture, Random};
use nalgebra::{Rotation3, Vector3};
use std::vec::Vec as List;

const COLOURS: [Rgb; BALLS] =
    [Rgb::new(200, 36, 40), Rgb::new(38, 158, 62), Rgb::new(34, 72, 186), Rgb::new(228, 196, 44)];
const GREY: Rgb = Rgb::new(160, 158, 150);

/// Where the four balls of a frame appear, seen from afar: red at `origin`, arms of `arm` pixels.
fn seen(turn: [f32; 3], arm: f32, origin: (f32, f32)) -> [ImagePoint; BALLS] {
    let rotation = Rotation3::from_euler_angles(turn[0], turn[1], turn[2]);
    [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()].map(|end| {
        let x = rotation * (end * arm);
        ImagePoint::new(origin.0 + x.x, origin.1 + x.y)
    })
}

/// A turn that keeps the four balls apart in the picture.
const TURN: [f32; 3] = [0.7, -0.5, 0.3];

fn picture_of(centres: &[ImagePoint; BALLS], diameter: f32) -> Picture {
    let mut picture = Picture::new(320, 240, |_, _| GREY);
    for (centre, colour) in centres.iter().zip(COLOURS) {
        picture = picture.with(Drawn::new(centre.u, centre.v, diameter, colour));
    }
    picture.with_noise(4)
}

fn propose_in(pictures: &[&Picture]) -> Proposal {
    let bytes: List<_> =
        pictures.iter().map(|p| p.encode(crate::vision::frame::PixelFormat::Rgb888)).collect();
    let frames: List<_> = pictures
        .iter()
        .zip(&bytes)
        .map(|(p, bytes)| {
            let format = crate::vision::frame::PixelFormat::Rgb888;
            FrameView::packed(bytes, p.width as u16, p.height as u16, format).unwrap()
        })
        .collect();
    propose(&frames, &ProposeConfig::default())
}

fn candidate(centre: ImagePoint, diameter: f32) -> Candidate {
    Candidate { seed: centre, centre, diameter, quality: 0.6 }
}

fn candidates_at(centres: [ImagePoint; BALLS], diameter: f32) -> Candidates {
    centres.map(|centre| Vec::from_slice(&[candidate(centre, diameter)]).unwrap())
}

#[test]
fn the_four_balls_are_proposed_in_both_views() {
    let views = [seen(TURN, 70.0, (150.0, 120.0)), seen([0.9, 0.2, -0.2], 60.0, (170.0, 110.0))];
    let pictures = [picture_of(&views[0], 16.0), picture_of(&views[1], 14.0)];
    let proposal = propose_in(&[&pictures[0], &pictures[1]]);
    assert!(proposal.is_complete(), "{proposal:?}");
    for (view, centres) in proposal.views.iter().zip(&views) {
        for ((learnt, centre), ball) in view.balls.as_ref().unwrap().iter().zip(centres).zip(Ball::ALL) {
            assert!(learnt.centre.distance(*centre) < 1.0, "{ball:?}: {learnt:?}");
            assert_eq!(learnt.reference.primary, Primary::of(ball));
        }
    }
    assert!(proposal.pixels_tested < 6_000_000, "{}", proposal.pixels_tested);
}

#[test]
fn what_is_missing_is_named() {
    let mut centres = seen(TURN, 70.0, (150.0, 120.0));
    centres[Ball::Green.index()] = ImagePoint::new(-50.0, -50.0);
    let proposal = propose_in(&[&picture_of(&centres, 16.0)]);
    assert_eq!(proposal.views[0].balls, Err(ProposeError::Missing([false, true, false, false])));
    assert!(!proposal.is_complete());
    let said = std::format!("{}", ProposeError::Missing([false, true, false, true]));
    assert!(said.contains("green yellow"), "{said}");
}

#[test]
fn four_balls_in_a_row_are_no_frame() {
    let row = [80.0, 130.0, 180.0, 230.0].map(|u| ImagePoint::new(u, 120.0));
    let proposal = propose_in(&[&picture_of(&row, 16.0)]);
    assert_eq!(proposal.views[0].balls, Err(ProposeError::NoFrame));
    assert_eq!(proposal.views[0].candidates, [1; BALLS]);
}

#[test]
fn a_second_ball_that_fits_as_well_is_ambiguous_and_one_that_does_not_is_left_out() {
    let centres = seen(TURN, 70.0, (150.0, 120.0));
    let yellow = Ball::Yellow.index();
    // The arm turned round: sum z^2 is the same, so nothing tells which of the two it is.
    let turned = centres[0] + (centres[0] - centres[yellow]);
    let colour = COLOURS[yellow];
    let fits = picture_of(&centres, 16.0).with(Drawn::new(turned.u, turned.v, 16.0, colour));
    let proposal = propose_in(&[&fits]);
    assert_eq!(proposal.views[0].balls, Err(ProposeError::Ambiguous(Ball::Yellow)));
    assert!(proposal.views[0].runner_up > 0.0);
    let astray = picture_of(&centres, 16.0).with(Drawn::new(40.0, 200.0, 16.0, colour));
    let proposal = propose_in(&[&astray]);
    let learnt = proposal.views[0].balls.unwrap()[yellow];
    assert!(learnt.centre.distance(centres[yellow]) < 1.0, "{learnt:?}");
}

#[test]
fn views_whose_arms_differ_disagree() {
    let near = picture_of(&seen(TURN, 70.0, (150.0, 120.0)), 16.0);
    let other = picture_of(&seen(TURN, 90.0, (150.0, 120.0)), 10.0);
    let proposal = propose_in(&[&near, &near, &other]);
    assert!(proposal.views[0].balls.is_ok() && proposal.views[1].balls.is_ok());
    assert_eq!(proposal.views[2].balls, Err(ProposeError::ViewsDisagree));
}

#[test]
fn the_arm_in_ball_diameters_does_not_depend_on_the_view() {
    let config = ProposeConfig::default();
    let mut random = Random(11);
    let mut tried = 0;
    for _ in 0..200 {
        let turn = [(); 3].map(|()| random.below(6283) as f32 / 1000.0);
        let scale = 0.5 + random.below(100) as f32 / 50.0;
        let quartets =
            quartet::best(&candidates_at(seen(turn, 70.0 * scale, (0.0, 0.0)), 14.0 * scale), &config);
        // Where two balls hide each other there is none.
        if let Some(quartet) = quartets.first() {
            assert!((quartet.arm_diameters - 5.0).abs() < 0.01, "{quartet:?}");
            assert!((quartet.score - 0.6).abs() < 0.01, "{quartet:?}");
            tried += 1;
        }
    }
    assert!(tried > 120, "{tried}");
}

#[test]
fn each_rule_of_a_quartet_refuses() {
    let config = ProposeConfig::default();
    let centres = seen(TURN, 70.0, (150.0, 120.0));
    let ok = candidates_at(centres, 14.0);
    assert_eq!(quartet::best(&ok, &config).len(), 1);
    // Three times the size.
    let mut sizes = ok.clone();
    sizes[2][0].diameter = 42.0;
    assert!(quartet::best(&sizes, &config).is_empty());
    // Two colours of one ball.
    let mut same = ok.clone();
    same[1][0].centre = same[0][0].centre + ImagePoint::new(3.0, 0.0);
    assert!(quartet::best(&same, &config).is_empty());
    // All at one point.
    assert!(quartet::best(&candidates_at([centres[0]; BALLS], 14.0), &config).is_empty());
    // Too far apart for their size.
    assert!(quartet::best(&candidates_at(centres, 2.0), &config).is_empty());
    // Arms of other lengths than the frame has.
    let arms = ProposeConfig { arms: [1.0, 3.0, 1.0], ..config };
    assert!(quartet::best(&ok, &arms).is_empty());
    let no_arms = ProposeConfig { arms: [0.0; 3], ..config };
    assert!(quartet::best(&ok, &no_arms).is_empty());
}

#[test]
fn the_best_of_all_combinations_come_first() {
    let config = ProposeConfig::default();
    let mut random = Random(5);
    let mut candidates = Candidates::default();
    for list in &mut candidates {
        while !list.is_full() {
            let centre = ImagePoint::new(random.below(300) as f32, random.below(200) as f32);
            let quality = random.below(1000) as f32 / 1000.0;
            list.push(Candidate { quality, ..candidate(centre, 14.0) }).unwrap();
        }
    }
    let best = quartet::best(&candidates, &config);
    assert!(best.is_full());
    assert!(best.windows(2).all(|pair| pair[0].score >= pair[1].score));
    let single =
        |q: &Quartet| quartet::best(&q.balls.map(|ball| Vec::from_slice(&[ball]).unwrap()), &config)[0].score;
    // Every combination, one by one: none is better than the first, and three are between.
    let mut scores: List<f32> = List::new();
    for red in &candidates[0] {
        for green in &candidates[1] {
            for blue in &candidates[2] {
                for yellow in &candidates[3] {
                    let one = [*red, *green, *blue, *yellow].map(|b| Vec::from_slice(&[b]).unwrap());
                    scores.extend(quartet::best(&one, &config).first().map(|q| q.score));
                }
            }
        }
    }
    scores.sort_by(|a, b| b.total_cmp(a));
    let found: List<f32> = best.iter().map(|q| q.score).collect();
    assert_eq!(found, scores[..MAX_QUARTETS]);
    assert_eq!(single(&best[0]), scores[0]);
}

#[test]
fn any_picture_is_answered_within_the_bound() {
    let mut random = Random(3);
    let mut any = || Rgb::new(random.below(256) as u8, random.below(256) as u8, random.below(256) as u8);
    let noise = Picture::new(160, 120, |_, _| any());
    let proposal = propose_in(&[&noise]);
    assert!(proposal.pixels_tested < 160 * 120 * 41 + 36 * 1_000_000, "{}", proposal.pixels_tested);
    let one = Picture::new(1, 1, |_, _| COLOURS[0]);
    assert!(propose_in(&[&one]).views[0].balls.is_err());
    let none = propose_in(&[]);
    assert!(none.views.is_empty() && !none.is_complete());
    assert_eq!(propose_in(&[&one; MAX_VIEWS + 2]).views.len(), MAX_VIEWS);
}
