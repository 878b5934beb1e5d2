//! Promise: the arm is computed as others compute it. Poses, Jacobians, sets of solutions and tracks
//! of the Robotics Toolbox for Python (and rs-opw-kinematics at singularities); where they come from
//! stands in `hil-fixtures/README.md`. A part of the data goes with the repository; the rest is
//! compared where the shared folder is there.

mod puma560;

use puma560::{ALL_PASSAGES, apart, arm, folders, single, tables, tracks, turned};
use std::collections::{BTreeMap, HashMap};
use tetrad_core::arm::puma560::{
    ChangeKind, ChooseRefusal, Configuration, Joints, Policy, Recent, Unreachable,
};
use tetrad_fixtures::puma560::Row;

#[test]
fn forward_jacobian_and_singularities_are_the_same() {
    let arm = arm::<f64>();
    for table in tables("forward_jacobian_and_singularities_are_the_same", "cases.csv") {
        let (mut rows, mut pose_off, mut jacobian_off, mut factors_off) = (0, 0.0f64, 0.0f64, 0.0f64);
        for row in table.rows().filter(|row| !row.is("unreachable")) {
            rows += 1;
            let q = row.joints("");
            pose_off = pose_off.max(apart(&arm.forward(&q), &row.pose()));
            let jacobian = arm.jacobian(&q);
            for i in 0..6 {
                for j in 0..6 {
                    let theirs = row.number(&format!("J{}{}", i + 1, j + 1));
                    jacobian_off = jacobian_off.max((jacobian[(i, j)] - theirs).abs());
                }
            }
            let at = arm.singularities(&q);
            for (ours, theirs) in [
                (at.wrist, row.number("f_wrist")),
                (at.elbow_m, row.number("f_elbow")),
                (at.shoulder_m, row.number("f_shoulder")),
                (arm.determinant(&at).abs(), row.number("manip")),
            ] {
                factors_off = factors_off.max((ours - theirs).abs());
            }
        }
        println!("{rows} rows: pose {pose_off:.1e}, Jacobian {jacobian_off:.1e}, factors {factors_off:.1e}");
        assert!(rows > 60, "{rows} rows");
        assert!(pose_off < 1e-12 && jacobian_off < 1e-12 && factors_off < 1e-12);
    }
}

#[test]
fn the_sets_of_solutions_are_the_same() {
    let arm = arm::<f64>();
    for table in tables("the_sets_of_solutions_are_the_same", "cases.csv") {
        let mut worst: BTreeMap<String, (u32, f64, f64)> = BTreeMap::new();
        for row in table.rows().filter(|row| !row.is("unreachable") && !row.is_singular()) {
            let (q, pose) = (row.joints(""), row.pose());
            let solutions = arm.inverse(&pose, &q).unwrap_or_else(|e| panic!("{}: {e}", row.name()));
            let near = row.text("tag").contains("near");
            let entry = worst.entry(format!("{} {}", row.text("kind"), row.text("tag"))).or_default();
            for configuration in Configuration::ALL {
                let code = configuration.code();
                let ours = solutions.get(configuration).unwrap_or_else(|| panic!("{} {code}", row.name()));
                let back = apart(&arm.forward(&ours.joints), &pose);
                assert!(back < 1e-9, "{} {code}: forward(solution) is {back:.1e} off", row.name());
                let off = turned(&ours.joints, &row.joints(&format!("{code}_")));
                assert!(off < if near { 1e-6 } else { 1e-9 }, "{} {code}: {off:.1e} rad off", row.name());
                *entry = (entry.0 + 1, entry.1.max(off), entry.2.max(back));
                // an angle on the very end of its range is inside or not by rounding
                let on_the_end = row.text("id") == "2404" || row.text("id") == "2405";
                let inside = row.number(&format!("{code}_inlim")) != 0.0;
                assert!(on_the_end || ours.outside.is_empty() == inside, "{} {code}", row.name());
            }
        }
        for (kind, (solutions, off, back)) in worst {
            println!("{kind:30} {solutions:6} solutions: {off:.1e} rad, forward(solution) {back:.1e}");
        }
    }
}

#[test]
fn every_exactly_singular_row_is_solved() {
    let arm = arm::<f64>();
    let name = "every_exactly_singular_row_is_solved";
    for (cases, singular) in tables(name, "cases.csv").iter().zip(tables(name, "singular.csv")) {
        let mut theirs: HashMap<String, Vec<Joints<f64>>> = HashMap::new();
        for row in singular.rows() {
            theirs.entry(row.text("id").to_owned()).or_default().push(row.joints(""));
        }
        let (mut rows, mut back, mut off) = (0, 0.0f64, 0.0f64);
        for row in cases.rows().filter(Row::is_singular) {
            rows += 1;
            let (q, pose) = (row.joints(""), row.pose());
            let solutions = arm.inverse(&pose, &q).unwrap_or_else(|e| panic!("{}: {e}", row.name()));
            assert_eq!(solutions.iter().count(), 8, "{}", row.name());
            for solution in solutions.iter() {
                back = back.max(apart(&arm.forward(&solution.joints), &pose));
            }
            // every posture of the other program is found when asked for what lies near it
            for theirs in theirs.get(row.text("id")).into_iter().flatten() {
                let solutions = arm.inverse(&pose, theirs).expect("solved above");
                let nearest = solutions.iter().map(|s| turned(&s.joints, theirs)).fold(f64::MAX, f64::min);
                assert!(nearest < 1e-5, "{}: {nearest:.1e} rad from {theirs:?}", row.name());
                off = off.max(nearest);
            }
        }
        println!("{rows} rows: forward(solution) {back:.1e}, {off:.1e} rad from the other program's");
        assert!(rows >= 24 && back < 1e-9, "{rows} rows, {back:.1e}");
    }
}

#[test]
fn every_unreachable_row_is_refused_with_its_reason() {
    let arm = arm::<f64>();
    for table in tables("every_unreachable_row_is_refused_with_its_reason", "cases.csv") {
        let mut rows = 0;
        for row in table.rows().filter(|row| row.is("unreachable")) {
            rows += 1;
            let reason = match row.text("tag") {
                "too_far" => Unreachable::TooFar,
                "too_near" => Unreachable::TooNear,
                "inside_shoulder_cylinder" => Unreachable::InsideShoulderCylinder,
                other => panic!("{other}"),
            };
            let refused = arm.inverse(&row.pose(), &[0.0; 6]).map(|_| ());
            assert_eq!(refused, Err(reason), "{}", row.name());
            let refused = self::arm::<f32>().inverse(&single(&row.pose()), &[0.0; 6]).map(|_| ());
            assert_eq!(refused, Err(reason), "{} in single precision", row.name());
        }
        assert!(rows >= 12, "{rows} rows");
    }
}

#[test]
fn the_tracks_are_followed_without_a_wrong_branch() {
    let arm = arm::<f64>();
    for folder in folders("the_tracks_are_followed_without_a_wrong_branch") {
        let (mut worst, mut steps, mut passages) = (0.0f64, 0, 0);
        for (name, track) in tracks(&folder) {
            let mut recent = Recent::at_rest(&arm, &track[0].1);
            for (pose, joints) in &track[1..] {
                let choice =
                    arm.choose(pose, &recent, &ALL_PASSAGES).unwrap_or_else(|e| panic!("{name}: {e}"));
                let off = choice.joints.iter().zip(joints).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-8, "{name}, step {steps}: {off:.1e} rad");
                worst = worst.max(off);
                steps += 1;
                if let Some(change) = choice.change {
                    assert_eq!(change.kind, ChangeKind::Passage);
                    passages += 1;
                }
                recent.push(&arm, &choice.joints);
            }
        }
        println!("{steps} steps: {worst:.1e} rad, {passages} singularities passed");
        assert!(passages >= 8, "{passages} singularities passed");
    }
}

#[test]
fn no_passage_of_a_track_goes_unsaid() {
    let arm = arm::<f64>();
    for folder in folders("no_passage_of_a_track_goes_unsaid") {
        for (name, track) in tracks(&folder) {
            let mut recent = Recent::at_rest(&arm, &track[0].1);
            for (pose, joints) in &track[1..] {
                let passes = arm.configuration(joints) != recent.configuration();
                match arm.choose(pose, &recent, &Policy::default()) {
                    Ok(choice) => assert!(!passes && choice.change.is_none(), "{name}"),
                    Err(ChooseRefusal::Passage { from, to, .. }) => {
                        assert!(passes && from == recent.configuration(), "{name}");
                        assert_eq!(to, arm.configuration(joints), "{name}");
                    }
                    Err(other) => panic!("{name}: {other}"),
                }
                recent.push(&arm, joints);
            }
        }
    }
}
