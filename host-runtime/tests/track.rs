//! `tetrad track` over rendered clips: the files it writes and what they say.

mod common;

use common::{Clip, csv, json};
use tetrad_core::observation::Ball;

/// How near a ball of 16 px must be to be the right one: a quarter of the diameter. How exact centres
/// are is judged elsewhere.
const FOUND_PX: f64 = 4.0;

/// The columns of a row as numbers.
fn numbers(fields: &[String]) -> Vec<f64> {
    fields.iter().map(|field| field.parse().unwrap_or_else(|_| panic!("{field:?} is a number"))).collect()
}

#[test]
fn two_cameras_with_a_scene_give_observations_pose_motion_and_summary() {
    let clip = Clip::of("linear-0.25-10fps", 12);
    clip.tetrad("track --left left --right right --scene scene.json --out out").done();

    let rows = csv(&clip.path("out/observations.csv"));
    assert_eq!(rows[0].join(","), "frame,t,camera,ball,u,v,diameter,state");
    assert_eq!(rows.len(), 1 + 12 * 2 * 4);
    for row in &rows[1..] {
        let [frame, t, camera, ball, u, v, diameter, state] = row.as_slice() else { panic!("{row:?}") };
        let (frame, camera) = (frame.parse::<usize>().unwrap(), usize::from(camera == "right"));
        let ball = Ball::ALL.into_iter().find(|b| b.name() == ball).unwrap();
        let truth = clip.scene.truth(frame, camera)[ball.index()];
        assert_eq!(state, "visible", "{row:?}");
        assert!((t.parse::<f64>().unwrap() - frame as f64 / 10.0).abs() < 1e-6, "{row:?}");
        let seen = (u.parse::<f64>().unwrap(), v.parse::<f64>().unwrap());
        let off = (seen.0 - truth.outline_centre.0).hypot(seen.1 - truth.outline_centre.1);
        assert!(off < FOUND_PX, "{row:?}: {off} px from {truth:?}");
        let diameter = diameter.parse::<f64>().unwrap() / truth.diameter;
        assert!((0.7..1.3).contains(&diameter), "{row:?}: {truth:?}");
    }

    let pose = csv(&clip.path("out/pose.csv"));
    assert_eq!(pose[0].join(","), "frame,t,x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33,state");
    assert_eq!(pose.len(), 1 + 12);
    assert_eq!(numbers(&pose[1][2..14]), [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.]);
    let (first, last) = (clip.scene.hand(0), clip.scene.hand(11));
    let moved = first.rotation.transpose() * (last.translation - first.translation);
    let x = numbers(&pose[12][2..5]);
    let off = (x[0] - moved.x).hypot(x[1] - moved.y).hypot(x[2] - moved.z);
    // weak perspective costs the paper's increments up to a tenth of the way
    assert!(moved.norm() > 0.05 && off < 0.1 * moved.norm(), "{x:?} m, and {moved:?} is true");
    assert!(pose[1..].iter().all(|row| row[14] == "both"), "{pose:?}");

    let motion = csv(&clip.path("out/motion.csv"));
    let header = "frame,t,a1,a2,a3,phi11,phi12,phi13,phi21,phi22,phi23,phi31,phi32,phi33";
    assert_eq!((motion[0].join(",").as_str(), motion.len()), (header, 1 + 12));

    let summary = json(&clip.path("out/summary.json"));
    assert_eq!((summary["frames"].as_u64(), summary["complete"].as_bool()), (Some(12), Some(true)));
    for camera in ["left", "right"] {
        let camera = &summary["cameras"][camera];
        let us = &camera["tracking_us"];
        assert!(us["min"].as_f64() > Some(0.0) && us["p99"].as_f64() >= us["p50"].as_f64(), "{us}");
        assert!(camera["pixels_tested"]["p50"].as_f64() > Some(0.0), "{camera}");
        assert_eq!(camera["states"]["yellow"]["visible"].as_u64(), Some(12));
    }
    assert_eq!(summary["pose"]["both"].as_u64(), Some(12));
}

#[test]
fn colours_that_were_learnt_find_the_balls_without_seeds() {
    let clip = Clip::of("still", 3);
    for (camera, view) in ["left", "right"].into_iter().enumerate() {
        let at = Ball::ALL.map(|ball| {
            let (u, v) = clip.seed(camera, ball);
            format!("--at {}={u},{v}", ball.name())
        });
        clip.tetrad(&format!("learn --source {view} {} --out {view}.toml", at.join(" "))).done();
    }
    clip.tetrad("track --left left --right right --colours-left left.toml --colours-right right.toml --arm-mm 80 --out out")
        .done();
    let last: Vec<_> =
        csv(&clip.path("out/observations.csv")).into_iter().filter(|row| row[0] == "2").collect();
    assert_eq!(last.len(), 8);
    for row in last {
        let ball = Ball::ALL.into_iter().find(|ball| ball.name() == row[3]).unwrap();
        let (u, v) = clip.scene.truth(2, usize::from(row[2] == "right"))[ball.index()].outline_centre;
        let seen = numbers(&row[4..6]);
        assert!((seen[0] - u).hypot(seen[1] - v) < FOUND_PX, "{row:?}: ({u}, {v}) is true");
    }
}

#[test]
fn one_camera_and_two_balls_leave_pose_and_motion_empty() {
    let clip = Clip::of("still", 2);
    let ran = clip.tetrad("track --left left --scene scene.json --balls red,yellow --out new/out").done();
    assert!(
        ran.stderr.contains("one camera: pose.csv, filtered.csv and motion.csv get no rows"),
        "{}",
        ran.stderr
    );
    let rows = csv(&clip.path("new/out/observations.csv"));
    let seen: Vec<_> = rows[1..].iter().map(|row| (row[0].as_str(), row[3].as_str())).collect();
    assert_eq!(seen, [("0", "red"), ("0", "yellow"), ("1", "red"), ("1", "yellow")]);
    assert_eq!(csv(&clip.path("new/out/pose.csv")).len(), 1);
    assert_eq!(csv(&clip.path("new/out/motion.csv")).len(), 1);
}

#[test]
fn a_gap_in_the_numbering_is_tracked_across_and_told() {
    let clip = Clip::of("still", 5);
    for view in ["left", "right"] {
        std::fs::remove_file(clip.frame(view, 2)).unwrap();
    }
    let ran = clip.tetrad("track --left left --right right --scene scene.json --out out").done();
    assert!(ran.stdout.contains("1 frames are missing"), "{}", ran.stdout);
    let frames: Vec<_> = csv(&clip.path("out/pose.csv")).into_iter().map(|row| row[0].clone()).collect();
    assert_eq!(frames, ["frame", "0", "1", "3", "4"]);
    let summary = json(&clip.path("out/summary.json"));
    assert_eq!(summary["cameras"]["right"]["frames_missed"].as_u64(), Some(1));
}

#[test]
fn a_simulated_scene_is_a_source_like_any_other() {
    let dir = tempfile::tempdir().unwrap();
    let run = |arguments: &str| common::tetrad(dir.path(), arguments);
    run("learn --find --yes --source sim:static-16px --right-source sim:static-16px --out l.toml --out-right r.toml")
        .done();
    run("track --left sim:static-16px --right sim:static-16px --colours-left l.toml --colours-right r.toml --arm-mm 80 --out out")
        .done();
    let summary = json(&dir.path().join("out/summary.json"));
    let frames = summary["frames"].as_u64();
    assert!(frames >= Some(1) && summary["pose"]["both"].as_u64() == frames, "{summary}");
}

#[test]
fn the_same_frames_give_the_same_files_twice() {
    let clip = Clip::of("finger", 4);
    let [first, second] = ["one", "two"].map(|out| {
        clip.tetrad(&format!("track --left left --right right --scene scene.json --out {out}")).done();
        ["observations.csv", "pose.csv", "motion.csv"].map(|name| csv(&clip.path(out).join(name)))
    });
    assert_eq!(first, second);
}
