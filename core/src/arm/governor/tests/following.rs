//! Goals that the arm can be at: it gets there, exactly, straight, and stays.

use super::*;

#[test]
fn a_goal_nearby_is_reached_to_rounding() {
    let mut random = Random::new(11);
    let config = GovernorConfig::default();
    let (mut worst_m, mut slowest, mut fastest, mut out) = (0.0f64, 0, 0.0f64, 0.0f64);
    for case in 0..sequences(4_000) {
        let start = anywhere(&mut random, &config, 0.2);
        let mut arm = Checked::<f64>::new(&config, &start);
        // where the arm can be: a bit off in its joints
        let mut joints = start;
        for (angle, range) in joints.iter_mut().zip(&arm.arm.config().joints) {
            *angle = (*angle + random.within(-0.2, 0.2)).clamp(range.min_rad, range.max_rad);
        }
        let goal = arm.arm.forward(&joints);
        let (here, there) = (arm.arm.configuration(&start), arm.arm.configuration(&joints));
        if (here.shoulder, here.elbow) != (there.shoulder, there.elbow) {
            // only by a passage that is not allowed
            continue;
        }
        let w = &config.workspace;
        if !(0..3).all(|i| goal.translation[i] >= w.min_m[i] && goal.translation[i] <= w.max_m[i]) {
            continue;
        }
        let cycles = arm.settle(&goal, 1e-9, 2_000);
        let (m, rad) = arm.off(&goal);
        assert!(
            cycles.is_some() && m < 1e-9 && rad < 1e-9,
            "case {case}: {m} m, {rad} rad after {cycles:?} from {start:?} to {joints:?}: {} at {:?}",
            arm.follow(&goal).limits,
            arm.governor.axes
        );
        worst_m = worst_m.max(m);
        slowest = slowest.max(cycles.unwrap_or(0));
        fastest = fastest.max(arm.fastest_m_s);
        out = out.max(arm.out_m);
    }
    std::println!(
        "{worst_m:.1e} m off, {slowest} cycles, {fastest:.3} m/s, {:.2} mm out of the box",
        out * 1e3
    );
}

#[test]
fn a_goal_a_quarter_metre_away_is_gone_to_straight() {
    let mut random = Random::new(12);
    let config = GovernorConfig::default();
    let (mut cases, mut fastest, mut slowest, mut out) = (0, 0.0f64, 0, 0.0f64);
    let mut bends = std::vec::Vec::new();
    while cases < sequences(2_000) {
        let start = anywhere(&mut random, &config, 0.2);
        let mut arm = Checked::<f64>::new(&config, &start);
        let from = arm.governor.pose;
        let mut way = random.vector(1.0);
        way *= 0.25 / way.norm();
        let goal =
            Pose { translation: from.translation + way, rotation: random.rotation(0.5) * from.rotation };
        // the whole way can be gone
        let left = goal::Left::between(&from, &goal);
        let mut recent = Recent::at_rest(&arm.arm, &start);
        let free = (1..=50).all(|k| {
            let pose = left.along(&from, f64::from(k) / 50.0);
            let w = &config.workspace;
            let inside = (0..3).all(|i| pose.translation[i] > w.min_m[i] && pose.translation[i] < w.max_m[i]);
            inside
                && arm.arm.choose(&pose, &recent, &crate::arm::puma560::Policy::default()).is_ok_and(
                    |choice| {
                        let away =
                            arm.arm.nearest_singularity(&arm.arm.singularities(&choice.joints)).1 > 0.2;
                        recent.push(&arm.arm, &choice.joints);
                        away
                    },
                )
        });
        if !free {
            continue;
        }
        cases += 1;
        let mut bend = 0.0f64;
        let mut cycles = 0;
        loop {
            let governed = arm.follow(&goal);
            let gone = governed.pose.translation - from.translation;
            let along = gone.dot(&way) / way.norm_squared();
            bend = bend.max((gone - way * along).norm());
            cycles += 1;
            if governed.at_rest {
                break;
            }
            assert!(cycles < 2000);
        }
        let (m, rad) = arm.off(&goal);
        assert!(m < 1e-9 && rad < 1e-9, "{m} {rad}");
        bends.push(bend);
        fastest = fastest.max(arm.fastest_m_s);
        slowest = slowest.max(cycles);
        out = out.max(arm.out_m);
    }
    bends.sort_by(f64::total_cmp);
    std::println!(
        "bend p50 {:.2e} p99 {:.2e} max {:.2e}, {fastest:.3} m/s, {slowest} cycles, {:.2} mm out",
        bends[bends.len() / 2],
        bends[bends.len() * 99 / 100],
        bends[bends.len() - 1],
        out * 1e3
    );
    // straight, but for joints that change their speeds at different times
    assert!(bends[bends.len() / 2] < 0.005 && bends[bends.len() - 1] < 0.1, "{bends:?}");
    assert!(fastest <= config.max_tool_speed_m_s, "{fastest} m/s");
}
