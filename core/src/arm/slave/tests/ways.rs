//! Where the arm ends: clutched a thousand times, and through a bad network.

use super::*;
use crate::arm::governor::Verdict;
use crate::arm::teleop::tests::network::{Network, Wander, arrived};
use crate::arm::teleop::tests::{Random, apart, sequences};
use crate::config::TeleopConfig;
use nalgebra::Vector3;

#[test]
fn a_thousand_clutch_cycles_with_a_still_hand_move_nothing() {
    let mut rig = Rig::<f64>::armed(&SlaveConfig::default());
    let start = rig.joints;
    let mut random = Random::new(5);
    for _ in 0..1000 {
        // the hand goes elsewhere while it is not followed
        rig.sender.hand = Pose { rotation: random.rotation(2.0), translation: random.vector(0.4) };
        rig.run(70_000);
        rig.press();
        let step = rig.run(100_000);
        assert!(step.decision.order.goal().is_some(), "{}", step.decision.status);
        rig.release();
        rig.run(50_000);
    }
    assert_eq!(rig.joints, start);
}

/// Two seconds of a moving hand, then time to catch up; where the tool ends, and where it was
/// commanded to.
fn through(config: &SlaveConfig, network: &Network, seed: u64) -> (Pose<f64>, Pose<f64>, Verdict) {
    let mut random = Random::new(seed);
    let mut fates = Random::new(seed ^ 0xFA7E);
    let mut wander = Wander::new(0.15, 0.5);
    let mut rig = Rig::<f64>::armed(config);
    let start = rig.tool();
    let mut under_way = Vec::new();
    let mut verdict = Verdict::Pass;
    let begun_us = rig.now_us;
    while rig.now_us < begun_us + 6_000_000 {
        rig.now_us += 10_000;
        let since_us = rig.now_us - begun_us;
        if since_us > 300_000 && !rig.sender.engaged {
            rig.press();
        }
        if (600_000..2_600_000).contains(&since_us) {
            wander.go(&mut rig.sender.hand, 0.01, &mut random);
        }
        if let Some(command) = rig.due() {
            network.send(command, rig.now_us, &mut under_way, &mut fates);
        }
        for command in arrived(rig.now_us, &mut under_way) {
            // an old one is refused
            let _ = rig.slave.take(&command);
        }
        let governed = rig.step().governed;
        verdict = governed.map_or(verdict, |governed| governed.verdict);
    }
    let moved = rig.sender.latch.inverse().compose(&rig.sender.hand);
    let commanded = Pose {
        translation: start.translation + moved.translation,
        rotation: moved.rotation * start.rotation,
    };
    (rig.tool(), commanded, verdict)
}

#[test]
fn the_arm_ends_where_it_was_commanded_through_loss_jitter_and_reordering() {
    let (mut worst, mut clamped, all) = ((0.0_f64, 0.0_f64), 0, sequences(2_000));
    for seed in 0..all {
        let (tool, commanded, verdict) = through(&SlaveConfig::default(), &Network::BAD, seed);
        if verdict == Verdict::Clamp {
            // the hand led out of the arm's range, and this was said
            clamped += 1;
            continue;
        }
        let (metres, radians) = apart(&tool, &commanded);
        assert!(metres < 1e-6 && radians < 1e-6, "seed {seed}: {metres} m, {radians} rad");
        worst = (worst.0.max(metres), worst.1.max(radians));
    }
    std::println!("{all} ways, {clamped} of them out of range; worst {worst:?}");
    assert!(clamped < all / 20);
}

#[test]
fn in_paper_mode_the_loss_shows() {
    let config = SlaveConfig { teleop: TeleopConfig::paper(), ..SlaveConfig::default() };
    let mut off: Vec<f64> = (0..40)
        .map(|seed| {
            let (tool, commanded, _) = through(&config, &Network::BAD, seed);
            apart(&tool, &commanded).0
        })
        .collect();
    off.sort_by(f64::total_cmp);
    std::println!("paper mode: {:?} m off in the middle", off[20]);
    assert!(off[20] > 0.01, "{off:?}");
}

/// A hand that goes at `speed` for two seconds, then stands still: by how many seconds the tool is
/// behind it at the end of its way, and how far the tool goes beyond it, metres.
fn behind(lead_us: u32, speed: f64) -> (f64, f64) {
    let config = SlaveConfig { lead_us, ..SlaveConfig::default() };
    let mut rig = Rig::<f64>::engaged(&config);
    let start = rig.tool().translation.y;
    let mut way = 0.0;
    for _ in 0..200 {
        way += speed * 0.01;
        rig.sender.hand.translation.y = way;
        rig.cycle();
    }
    let behind = (start + way - rig.tool().translation.y) / speed;
    let mut beyond = 0.0_f64;
    for _ in 0..200 {
        rig.cycle();
        beyond = beyond.max(rig.tool().translation.y - start - way);
    }
    let left = rig.tool().translation.y - start - way;
    assert!(left.abs() < 1e-6, "{left} m from where the hand is");
    (behind, beyond)
}

#[test]
fn a_goal_told_ahead_is_followed_less_late() {
    for speed in [0.05, 0.1, 0.15] {
        let (late, without) = behind(0, speed);
        let (less, beyond) = behind(SlaveConfig::default().lead_us, speed);
        std::println!(
            "{speed} m/s: {late:.3} s, told ahead {less:.3} s; {without:.5} and {beyond:.5} m beyond"
        );
        assert!(late > 0.12 && less < 0.6 * late && less > 0.0, "{late} {less}");
        assert!(beyond < 0.05 * speed, "{beyond} m beyond");
    }
}

/// Where the simulated arm stands at first: joints 1, 4 and 6 at exactly 0, so that a hand that moves in
/// the arm's own plane leaves them nothing but rounding to go.
#[test]
fn a_hand_that_moves_in_the_plane_of_the_arm_is_followed() {
    for way in [Vector3::x(), Vector3::z(), Vector3::x() + Vector3::z()] {
        let mut rig = Rig::<f64>::new(&SlaveConfig::default());
        rig.joints = [0.0, 45.0, -180.0, 0.0, 45.0, 0.0].map(f64::to_radians);
        rig.run(100_000);
        rig.reset().unwrap();
        rig.run(100_000);
        rig.press();
        rig.run(200_000);
        let start = rig.tool().translation;
        for to_m in [0.1, -0.1, 0.0] {
            let from = rig.sender.hand.translation;
            let to = Vector3::z() + way * to_m;
            for step in 1..=100 {
                rig.sender.hand.translation = from + (to - from) * (f64::from(step) / 100.0);
                rig.cycle();
            }
            rig.run(3_000_000);
            let off = (rig.tool().translation - start - way * to_m).norm();
            assert!(off < 1e-6, "{way:?} by {to_m} m: {off} m off");
        }
    }
}
