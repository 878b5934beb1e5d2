//! The paper's law beside ours.

use super::network::{Network, PERFECT, Servo, through};
use super::*;

/// Is where it is sent at once: what is left is the network's doing.
const IDEAL: Servo = Servo { speed: f64::INFINITY, turn_speed: f64::INFINITY };

/// Half a second behind: what a real arm adds.
const SLOW: Servo = Servo { speed: 0.1, turn_speed: 1.0 };

/// The median distance between the goal and where the hand's way leads, metres, and the share of ways
/// with more than a millimetre. The hand does not turn: the printed law adds alpha in axes that turn.
fn missed(config: &TeleopConfig, network: Network, servo: &Servo) -> (f64, f64) {
    let mut off: std::vec::Vec<f64> = (0..sequences(2_000))
        .map(|seed| {
            let ends = through::<f64>(config, network, seed, 0.0, servo);
            apart(&ends.goal, &ends.commanded).0
        })
        .collect();
    off.sort_by(f64::total_cmp);
    (off[off.len() / 2], off.iter().filter(|m| **m > 1e-3).count() as f64 / off.len() as f64)
}

#[test]
fn the_printed_law_as_printed() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::paper());
    // a sagging arm: measured, not the set-point
    rig.arm.measured.translation.z -= 0.01;
    rig.arm.measured.rotation = so3::exp(&Vector3::new(0.1, 0.2, 0.3));
    let measured = rig.arm.measured;
    let phi = so3::exp(&Vector3::new(0.0, 0.02, 0.01));
    rig.send(|c| {
        c.increment = Pose { rotation: phi.map(|x| x as f32), translation: Vector3::new(0.01, 0.0, -0.002) };
    })
    .unwrap();
    let goal = *rig.step().order.goal().unwrap();
    let expected = Pose {
        translation: measured.translation + Vector3::new(0.01, 0.0, -0.002),
        rotation: measured.rotation * phi,
    };
    let (metres, radians) = apart(&goal, &expected);
    assert!(metres < 1e-8 && radians < 1e-7, "{metres} m, {radians} rad");
    // without a new packet the goal stands
    assert_eq!(rig.step().order, Order::Follow(goal));
}

#[test]
fn the_printed_law_loses_motion_with_packets_and_ours_does_not() {
    let (paper, ours) = (TeleopConfig::paper(), TeleopConfig::default());
    let (perfect, none) = missed(&paper, PERFECT, &IDEAL);
    let (lossy, most) = missed(&paper, Network::BAD, &IDEAL);
    let (slow, _) = missed(&paper, PERFECT, &SLOW);
    let (ours_lossy, ours_most) = missed(&ours, Network::BAD, &IDEAL);
    let (ours_slow, _) = missed(&ours, PERFECT, &SLOW);
    std::println!(
        "median miss, mm: paper {:.3}, with losses {:.1} ({:.0} % of ways over 1 mm), with a slow arm {:.1}; \
         since engage, with losses {:.6}, with a slow arm {:.6}",
        perfect * 1e3,
        lossy * 1e3,
        most * 100.0,
        slow * 1e3,
        ours_lossy * 1e3,
        ours_slow * 1e3
    );
    assert!(perfect < 1e-5 && none == 0.0, "{perfect}");
    assert!(lossy > 0.02 && most > 0.99, "{lossy}, {most}");
    assert!(slow > 0.02, "{slow}");
    assert!(ours_lossy < 1e-6 && ours_most == 0.0 && ours_slow < 1e-6, "{ours_lossy}, {ours_slow}");
}

#[test]
fn the_printed_law_stops_by_the_same_rules() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::paper());
    rig.wait(150_000);
    rig.button(true);
    assert_eq!(rig.step().status, Status::Hold(HoldReason::NoCommand));
    rig.release();
    rig.sender.hand.translation.x += 0.2;
    let before = rig.arm.set_point;
    rig.press();
    assert_eq!(rig.step().order, Order::Follow(before), "what was moved while let go is not added");
    // an increment that no hand makes
    rig.sender.hand.translation.x += 0.3;
    rig.frame();
    let decision = rig.step();
    assert!(decision.notes.contains(Note::HandJumped));
    assert_eq!(decision.order, Order::Follow(before));
}
