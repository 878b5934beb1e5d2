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
        let w = &config.workspace;
        if !(0..3).all(|i| goal.translation[i] >= w.min_m[i] && goal.translation[i] <= w.max_m[i]) {
            continue;
        }
        let cycles = arm.settle(&goal, 2_000);
        let (m, rad) = arm.off(&goal);
        assert!(
            cycles.is_some() && m < 1e-9 && rad < 1e-9,
            "case {case}: {m} m, {rad} rad after {cycles:?} from {start:?} to {joints:?}"
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
