//! The workspace holds the tool: driven against its faces, edges and corners, straight, by the joints
//! and where the goal is not to be reached. [`Checked`] looks at every set-point.

use super::*;
use crate::config::Workspace;

/// One that the arm fills, so that its joints and its faces are met together.
const SMALL: Workspace = Workspace { min_m: [-0.5, -0.5, 0.3], max_m: [0.5, 0.5, 1.1] };

/// A goal past one, two or three faces, or at random joints anywhere, in the box or not.
fn somewhere(random: &mut Random, arm: &Checked<f64>, config: &GovernorConfig) -> Pose<f64> {
    if random.chance(0.5) {
        let joints = core::array::from_fn(|i| {
            let range = &arm.arm.config().joints[i];
            random.within(range.min_rad, range.max_rad)
        });
        return arm.arm.forward(&joints);
    }
    let w = &config.workspace;
    let faces = 1 + random.bits() % 7;
    let mut goal = *arm.governor.pose();
    for axis in 0..3 {
        goal.translation[axis] = if faces >> axis & 1 == 0 {
            random.within(w.min_m[axis], w.max_m[axis])
        } else if random.chance(0.5) {
            w.max_m[axis] + random.within(0.0, 0.3)
        } else {
            w.min_m[axis] - random.within(0.0, 0.3)
        };
    }
    goal.rotation = random.rotation(1.5) * goal.rotation;
    goal
}

#[test]
fn wherever_it_is_driven_the_tool_stays_in_and_comes_back() {
    let mut random = Random::new(41);
    let config = GovernorConfig { workspace: SMALL, ..GovernorConfig::default() };
    let (mut held, mut other_ways, mut detours, mut nearest) = (0, 0, 0, 0);
    let (mut out, mut fastest, mut slowest) = (0.0f64, 0.0f64, 0);
    let (mut lost, mut late) = (std::vec::Vec::new(), 0);
    for case in 0..sequences(4_000) {
        let start = anywhere(&mut random, &config, 0.05);
        let mut arm = Checked::<f64>::new(&config, &start);
        let home = *arm.governor.pose();
        for _ in 0..3 {
            let goal = somewhere(&mut random, &arm, &config);
            for _ in 0..(random.within(20.0, 250.0) as u32) {
                let governed = arm.follow(&goal);
                held += u64::from(governed.limits.contains(Limit::WorkspaceEdge));
                other_ways += u64::from(governed.limits.contains(Limit::AnotherWay));
                nearest += u64::from(governed.limits.contains(Limit::TooFar));
                detours += u64::from(arm.governor.detour.via.is_some());
            }
            if random.chance(0.2) {
                for _ in 0..40 {
                    arm.step(&Order::Stop);
                }
            }
        }
        let mut round = 0;
        let cycles = (0..3_000).find(|_| {
            let governed = arm.follow(&home);
            round += u32::from(arm.governor.detour.via.is_some());
            governed.at_rest && arm.off(&home).0.max(arm.off(&home).1) < 1e-9
        });
        match cycles {
            Some(cycles) => {
                slowest = slowest.max(cycles);
                late += u64::from(cycles > 1_000);
            }
            None => {
                lost.push((case, round, arm.off(&home), arm.follow(&home).limits));
            }
        }
        out = out.max(arm.out_m);
        fastest = fastest.max(arm.fastest_m_s);
    }
    std::println!(
        "at most {:.2} mm out, {fastest:.3} m/s, {slowest} cycles back, {late} more than 1,000, {} lost; cycles \
         held at a face {held}, by another way {other_ways}, round {detours}, out of reach {nearest}",
        out * 1e3,
        lost.len(),
    );
    // a jump home across all that lies between may take a while
    assert!(lost.is_empty(), "{lost:#?}");
    assert!(late * 200 <= sequences(4_000), "{late} took more than 10 s");
    assert!(held > 100 && other_ways > 100 && nearest > 100 && out > 0.002);
}

#[test]
fn a_way_home_is_found_that_takes_a_folded_elbow() {
    let config = GovernorConfig { workspace: SMALL, ..GovernorConfig::default() };
    // the upper arm goes over the top, where there is only room for a forearm that is folded to its end
    let over_the_top = (
        [-0.301, -0.138, -0.0243, 1.7412, -0.1944, 3.1601],
        [-0.2000189, 3.9139138, 0.7779182, 1.7479918, -0.1474904, 3.1601816],
    );
    // folded already, and below the tool there is a face
    let at_the_floor = (
        [0.0261429, 3.6076343, 0.7853884, -1.2696081, -0.55585, 3.3261],
        [0.1686037, 3.8299596, 0.7608467, -1.4569333, -0.6498751, 3.7633655],
    );
    for (from, to) in [over_the_top, at_the_floor] {
        let mut arm = Checked::<f64>::new(&config, &from);
        let home = arm.arm.forward(&to);
        let cycles = arm.settle(&home, 1e-9, 3_000);
        std::println!("{cycles:?}");
        assert!(cycles.is_some(), "{:?} at {:?}", arm.off(&home), arm.governor.set_point());
    }
}

#[test]
fn who_is_outside_at_the_start_may_only_come_in() {
    let mut random = Random::new(42);
    let config = GovernorConfig { workspace: SMALL, ..GovernorConfig::default() };
    let mut inside = 0;
    for _ in 0..sequences(400) {
        let start = anywhere(&mut random, &config, 0.1);
        // a box that leaves the tool outside of one face by up to 10 cm
        let mut arm = Checked::<f64>::new(&config, &start);
        let home = *arm.governor.pose();
        let (axis, by) = ((random.bits() % 3) as usize, random.within(0.01, 0.1));
        let mut outside = config;
        outside.workspace.min_m[axis] = home.translation[axis] + by;
        outside.workspace.max_m[axis] = outside.workspace.min_m[axis] + 0.5;
        arm = Checked::<f64>::unheld(&outside, &start);
        let mut goal = home;
        let mut came = by;
        for cycle in 0..400 {
            if cycle % 50 == 0 {
                goal.translation = home.translation + random.vector(0.3);
                goal.translation[axis] = home.translation[axis] + random.within(-0.2, 0.3);
            }
            let out = outside.workspace.min_m[axis] - arm.follow(&goal).pose.translation[axis];
            // what was gained stays, but for what the tool swings while it turns round
            assert!(out <= by + 0.0011, "{out} m out, from {by} m");
            let most = came.max(fence::OVER_FACE_M) + 0.02;
            assert!(out <= most, "{out} m out, {came} m before");
            came = came.min(out);
        }
        inside += u64::from(came <= 0.0);
    }
    // some goals are kept from by a joint or a singularity, too
    assert!(inside * 10 >= sequences(400) * 8, "{inside} came in");
}

#[test]
fn what_was_gained_on_the_way_in_is_not_given_up() {
    let arm = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
    let config = GovernorConfig::default();
    let bounds = Governor::new(&arm, &config).unwrap().bounds;
    let lower = [0.3, 1.9, -2.6, 0.4, 0.9, -0.5];
    let mut upper = lower;
    upper[2] += 0.2;
    let height = |joints: &Joints<f64>| arm.forward(joints).translation.z;
    let (out, nearer) = if height(&lower) < height(&upper) { (lower, upper) } else { (upper, lower) };
    assert!(height(&nearer) - height(&out) > 0.02);
    let mut workspace = Workspace { min_m: [-1.0, -1.0, 0.0], max_m: [1.0, 1.0, 2.0] };
    workspace.min_m[2] = height(&nearer) + 0.05;
    let mut fence = Fence::new(&arm, &Bounded::new(&arm, &workspace), 0.1);
    fence.start(&arm.forward(&out).translation);
    let mut forbids = |joints: &Joints<f64>| {
        let place = arm.forward(joints).translation;
        fence.forbids(&arm, &place, &joints.map(Axis::at), &bounds)
    };
    assert_eq!(forbids(&out), None);
    assert_eq!(forbids(&nearer), None);
    assert_eq!(forbids(&out), Some(Limit::WorkspaceEdge));
}
