//! `tetrad learn`: pointing at balls, and being told why a point teaches nothing.

mod common;

use common::{Clip, csv};
use tetrad::colours::Colours;
use tetrad::learning::Refused;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::vision::learn::LearnError;

fn at(clip: &Clip, ball: Ball) -> String {
    let (u, v) = clip.seed(0, ball);
    format!("--at {}={u},{v}", ball.name())
}

#[test]
fn the_file_holds_what_the_picture_shows() {
    let clip = Clip::of("static-24px", 1);
    let points = Ball::ALL.map(|ball| at(&clip, ball)).join(" ");
    let ran = clip.tetrad(&format!("learn --source left {points} --out left.toml")).done();
    for ball in Ball::ALL {
        assert!(ran.stdout.contains(ball.name()), "{}", ran.stdout);
    }
    assert!(ran.stdout.contains("nothing else in the picture looks like it"), "{}", ran.stdout);

    let text = std::fs::read_to_string(clip.path("left.toml")).unwrap();
    let colours = Colours::parse(&text, "left.toml").unwrap();
    let origin = colours.origin.unwrap();
    assert_eq!((origin.source.as_str(), origin.frame), ("left", 0));
    for (ball, truth) in Ball::ALL.into_iter().zip(clip.scene.truth(0, 0)) {
        let learnt = colours.balls[ball.index()].unwrap();
        let at = learnt.at.unwrap();
        let off = (f64::from(at.u) - truth.outline_centre.0).hypot(f64::from(at.v) - truth.outline_centre.1);
        assert!(off < 1.0, "{}: {off} px", ball.name());
        let diameter = f64::from(learnt.learnt.diameter);
        assert!((diameter - truth.diameter).abs() < 2.5, "{}: {diameter} px", ball.name());
    }
}

#[test]
fn a_later_frame_can_be_learnt_from_and_one_beyond_the_end_cannot() {
    let clip = Clip::of("still", 2);
    let point = at(&clip, Ball::Red);
    clip.tetrad(&format!("learn --source left {point} --frame 1 --out c.toml")).done();
    assert!(std::fs::read_to_string(clip.path("c.toml")).unwrap().contains("frame = 1"));
    for frame in [2, 9] {
        clip.tetrad(&format!("learn --source left {point} --frame {frame} --out d.toml"))
            .refused(2, &[&format!("--frame {frame}"), "left has only 2 frames"]);
    }
    assert!(!clip.path("d.toml").exists());
}

#[test]
fn either_camera_of_a_simulated_scene_can_be_taught() {
    let clip = Clip::of("still", 1);
    for (camera, view) in ["left", "right"].into_iter().enumerate() {
        let (u, v) = clip.seed(camera, Ball::Blue);
        clip.tetrad(&format!("learn --source sim:still --view {view} --at blue={u},{v} --out {view}.toml"))
            .done();
    }
    let [left, right] =
        ["left.toml", "right.toml"].map(|file| std::fs::read_to_string(clip.path(file)).unwrap());
    assert_ne!(left, right);
}

#[test]
fn every_ball_that_teaches_nothing_is_named_with_its_reason() {
    let clip = Clip::of("static-24px", 1);
    let red = at(&clip, Ball::Red);
    let learn = |points: &str| clip.tetrad(&format!("learn --source left {points} --out c.toml"));
    let both = ["green at (9, 9): there is no ball", "blue at (30, 9): there is no ball", "640x480"];
    learn(&format!("{red} --at green=9,9 --at blue=30,9")).refused(1, &both);
    learn("--at red=640,9").refused(2, &["red at (640, 9)", "outside the picture", "640x480"]);
    learn("--at red=nan,9").refused(2, &["red=nan,9", "red=412,230"]);
    learn("--at pink=9,9").refused(2, &["`pink`"]);
    learn("").refused(2, &["--at", "--find"]);
    learn("--find --at red=9,9").refused(2, &["cannot be used with"]);
    learn(&format!("{red} {red}")).refused(2, &["red", "twice"]);
    assert!(!clip.path("c.toml").exists());
}

#[test]
fn the_scan_has_the_threshold_between_ball_and_background() {
    let clip = Clip::of("static-24px", 1);
    clip.tetrad(&format!("learn --source left {} --out c.toml --scan scans", at(&clip, Ball::Blue))).done();
    let rows = csv(&clip.path("scans/scan-blue.csv"));
    assert_eq!(rows[0].join(","), "x,r,g,b,v,d,m,threshold,border");
    let borders: Vec<usize> = (1..rows.len()).filter(|&i| !rows[i][8].is_empty()).collect();
    let [first, last] = borders[..] else { panic!("two borders: {borders:?}") };
    assert_eq!((rows[first][8].as_str(), rows[last][8].as_str()), ("first", "last"));
    let passes = |i: usize| rows[i][6].parse::<f32>().unwrap() >= rows[i][7].parse::<f32>().unwrap();
    assert!(passes(first) && passes(last) && !passes(first - 1) && !passes(last + 1));
    assert!(!passes(1) && !passes(rows.len() - 1), "background at both ends");
}

#[test]
fn a_proposal_is_written_only_when_it_is_confirmed() {
    let clip = Clip::of("demo", 1);
    let find = "learn --source left --right-source right --find --out l.toml --out-right r.toml";
    // the test's standard input is no terminal
    clip.tetrad(find).refused(2, &["confirm", "--yes"]);
    assert!(!clip.path("l.toml").exists() && !clip.path("r.toml").exists());

    let ran = clip.tetrad(&format!("{find} --yes --scan scans")).done();
    assert!(
        ran.stdout.contains("left (left): score") && ran.stdout.contains("right (right): score"),
        "{}",
        ran.stdout
    );
    for (camera, file) in ["l.toml", "r.toml"].into_iter().enumerate() {
        let colours = Colours::parse(&std::fs::read_to_string(clip.path(file)).unwrap(), file).unwrap();
        for (ball, truth) in Ball::ALL.into_iter().zip(clip.scene.truth(0, camera)) {
            let at = colours.balls[ball.index()].unwrap().at.unwrap();
            let (u, v) = truth.outline_centre;
            let off = (f64::from(at.u) - u).hypot(f64::from(at.v) - v);
            assert!(off < 2.0, "{file} {}: {off} px", ball.name());
        }
    }
    assert!(clip.path("scans/scan-red.csv").exists() && clip.path("scans/scan-right-yellow.csv").exists());
    clip.tetrad(
        "track --left left --right right --colours-left l.toml --colours-right r.toml --arm-mm 80 --out out",
    )
    .done();
}

#[test]
fn where_there_are_no_balls_nothing_is_proposed() {
    let clip = Clip::of("still", 1);
    let grey = vec![128; 64 * 48 * 3];
    let (rgb, eight) = (png::ColorType::Rgb, png::BitDepth::Eight);
    common::write_png(&clip.frame("left", 0), (64, 48), rgb, eight, &grey);
    let find = "learn --source left --find --yes --out l.toml";
    clip.tetrad(find).refused(1, &["left: no ball found", "red green blue yellow", "--at"]);
    assert!(!clip.path("l.toml").exists());
}

#[test]
fn both_cameras_colours_cannot_go_to_one_file() {
    let clip = Clip::of("demo", 1);
    std::fs::create_dir(clip.path("d")).unwrap();
    for right in ["q", "./q", "d/../q"] {
        let find = "learn --source left --right-source right --find --yes --out q --out-right";
        clip.tetrad(&format!("{find} {right}")).refused(2, &["--out q", "--out-right", "same file"]);
    }
    assert!(!clip.path("q").exists());
}

#[test]
fn a_large_patch_of_the_balls_colour_asks_whether_the_point_is_in_the_ball() {
    let clip = Clip::of("still", 1);
    let red = |i: usize| (20..620).contains(&(i % 640)) && (20..460).contains(&(i / 640));
    let reddish: Vec<u8> =
        (0..640 * 480).flat_map(|i| if red(i) { [150, 40, 40] } else { [120; 3] }).collect();
    let (rgb, eight) = (png::ColorType::Rgb, png::BitDepth::Eight);
    common::write_png(&clip.frame("left", 0), (640, 480), rgb, eight, &reddish);
    clip.tetrad("learn --source left --at red=320,240 --out c.toml")
        .refused(1, &["red at (320, 240)", "is the point inside the red ball?"]);
    let refused = |why| Refused(vec![(Ball::Red, ImagePoint::new(1.0, 1.0), why)]).to_string();
    assert!(refused(LearnError::TooLarge).ends_with("(is the point inside the red ball?)"));
    assert!(!refused(LearnError::TooSmall).contains("is the point"));
}
