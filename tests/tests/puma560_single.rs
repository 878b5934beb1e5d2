//! Promise: on the microcontroller the arm is the same arm, as far as single precision goes; and in
//! both precisions the same poses give the same bits.

mod puma560;

use puma560::{ALL_PASSAGES, Table, apart, arm, folders, single, tables, tracks, turned};
use std::collections::BTreeMap;
use tetrad_core::arm::puma560::Recent;
use tetrad_core::geometry::Pose;
use tetrad_core::real::Real;
use tetrad_fixtures::golden::Fnv1a;

/// How near the solutions of one kind of row come in single precision.
#[derive(Default)]
struct SinglePrecision {
    solutions: u32,
    /// Within 1e-4 rad.
    kept: u32,
    /// The worst of all, and of those with a smallest singular value of 0.01 and more, radians.
    worst: f64,
    worst_apart: f64,
}

/// What single precision can do is bound by how near to a singularity the solution is: an error of
/// 1e-7 in the pose is one of 1e-7 over the smallest singular value of the Jacobian in the joints,
/// and at the elbow's and the shoulder's singularity the root of it.
#[test]
fn single_precision_keeps_a_ten_thousandth_away_from_singularities() {
    let (arm, exact_arm) = (arm::<f32>(), arm::<f64>());
    for table in tables("single_precision_keeps_a_ten_thousandth_away_from_singularities", "cases.csv") {
        let mut kinds: BTreeMap<String, SinglePrecision> = BTreeMap::new();
        let mut back = 0.0f64;
        for row in table.rows().filter(|row| !row.is("unreachable")) {
            let near = row.joints("").map(|angle| angle as f32);
            let solutions = arm.inverse(&single(&row.pose()), &near);
            let solutions = solutions.unwrap_or_else(|e| panic!("{}: {e}", row.name()));
            assert_eq!(solutions.iter().count(), 8, "{}", row.name());
            let kind = kinds.entry(format!("{} {}", row.text("kind"), row.text("tag"))).or_default();
            for solution in solutions.iter() {
                let pose = arm.forward(&solution.joints);
                let pose = Pose { rotation: pose.rotation.cast(), translation: pose.translation.cast() };
                back = back.max(apart(&pose, &row.pose()));
                if !row.is_singular() {
                    let theirs = row.joints(&format!("{}_", solution.configuration.code()));
                    let off = turned(&solution.joints.map(f64::from), &theirs);
                    kind.solutions += 1;
                    kind.kept += u32::from(off < 1e-4);
                    kind.worst = kind.worst.max(off);
                    // every branch has its own distance from the singularities
                    if exact_arm.jacobian(&theirs).singular_values().min() >= 0.01 {
                        kind.worst_apart = kind.worst_apart.max(off);
                    }
                }
            }
        }
        for (name, k) in kinds.iter().filter(|(_, k)| k.solutions > 0) {
            let (of, worst, apart) = (k.solutions, k.worst, k.worst_apart);
            println!(
                "{name:30} {:5} of {of:5} within 1e-4; worst {worst:.1e}, apart {apart:.1e} rad",
                k.kept
            );
        }
        println!("forward(solution) {back:.1e}");
        assert!(kinds.values().all(|kind| kind.worst_apart < 2e-5));
        assert!(back < 4e-5, "{back:.1e}");
    }
}

#[test]
fn single_precision_follows_the_tracks_without_a_wrong_branch() {
    let arm = arm::<f32>();
    for folder in folders("single_precision_follows_the_tracks_without_a_wrong_branch") {
        let (mut worst, mut steps, mut beyond) = (0.0f64, 0u32, 0u32);
        for (name, track) in tracks(&folder) {
            let mut recent = Recent::at_rest(&arm, &track[0].1.map(|x| x as f32));
            for (pose, joints) in &track[1..] {
                let choice = arm.choose(&single(pose), &recent, &ALL_PASSAGES);
                let choice = choice.unwrap_or_else(|e| panic!("{name}: {e}"));
                let off = choice
                    .joints
                    .iter()
                    .zip(joints)
                    .map(|(a, b)| (f64::from(*a) - b).abs())
                    .fold(0.0, f64::max);
                worst = worst.max(off);
                steps += 1;
                beyond += u32::from(off > 1e-4);
                recent.push(&arm, &choice.joints);
            }
        }
        println!("{steps} steps: {worst:.1e} rad, {beyond} beyond 1e-4");
        // 1e-4 but for the steps beside a singularity
        assert!(worst < 1e-3 && beyond * 100 < steps, "{worst:.1e} rad, {beyond} of {steps}");
    }
}

/// The hash of everything that the arm computes from the repository's own rows.
fn bits<T: Real>() -> u64 {
    let arm = arm::<T>();
    let table = Table::read(&tetrad_fixtures::golden::data("puma560/cases.csv"));
    let mut hash = Fnv1a::default();
    // f32 is a part of f64, so its bits are all there
    let mut write = |x: T| hash.write(&x.to_f64().to_bits().to_le_bytes());
    for row in table.rows().filter(|row| !row.is("unreachable")) {
        let joints = row.joints("").map(T::of);
        let pose = arm.forward(&joints);
        pose.rotation.iter().chain(&pose.translation).for_each(|x| write(*x));
        arm.jacobian(&joints).iter().for_each(|x| write(*x));
        let solutions = arm.inverse(&pose, &joints).unwrap_or_else(|e| panic!("{}: {e}", row.name()));
        solutions.iter().flat_map(|solution| solution.joints).for_each(&mut write);
    }
    hash.finish()
}

/// `TETRAD_BLESS=1 cargo test -p tetrad-tests --test puma560_single` rewrites hil-fixtures/data/arm.txt.
#[test]
fn the_same_poses_give_the_same_bits() {
    let file = tetrad_fixtures::golden::data("arm.txt");
    for (name, hash) in [("puma560-f32", bits::<f32>()), ("puma560-f64", bits::<f64>())] {
        tetrad_fixtures::golden::check(&file, name, hash).unwrap_or_else(|e| panic!("{e}"));
    }
}
