use super::*;
use tetrad_core::wire::{ArmReason, ArmState, ArmVerdict, CommandEcho, ControllerState, Settled, Transform};
use tetrad_fixtures::packets;

const SESSION: u32 = 7;

/// What the slave says at 70,000 of its clock, which is 1,000 us before it came.
fn state(command: Option<CommandEcho>, settled: Option<Settled>) -> Received<ArmStatePacket> {
    let what = ArmStatePacket {
        session: 9,
        sequence: 1,
        time_us: 70_000,
        state: ArmState::Engaged,
        reason: ArmReason::None,
        notes: 0,
        verdict: ArmVerdict::Pass,
        limits: 0,
        speed_share: 0.5,
        controller: ControllerState::Ready,
        measured: None,
        set_point: [0.0; 6],
        tool: Transform::IDENTITY,
        command,
        settled,
        buttons_age_us: None,
        scale: 1.0,
    };
    Received { what, received_us: 1_040_000, captured_us: Some(1_039_000) }
}

fn echo(sequence: u32, session: u32) -> CommandEcho {
    // three milliseconds before
    CommandEcho { session, sequence, received_us: 67_000, solved_after_us: 200, written_after_us: 500 }
}

fn motion(sequence: u32) -> SentMotion {
    SentMotion {
        sequence,
        capture_us: 1_000_000,
        ready_us: 1_032_000,
        first_us: 1_030_000,
        joined_us: 1_032_500,
        posed_us: 1_032_600,
        sent_us: 1_032_610,
    }
}

/// Histograms tell two digits.
#[track_caller]
fn about(delays: &Delays, stage: Stage, us: u64, count: u64) {
    let spread = delays.of(stage).unwrap_or_else(|| panic!("{stage:?} was not measured"));
    assert_eq!(spread.count, count, "{stage:?}");
    assert!(spread.p50_us.abs_diff(us) <= us / 100 + 1, "{stage:?}: {spread:?}, not {us}");
}

#[test]
fn each_stage_is_the_time_between_two_stamps() {
    let mut delays = Delays::new(SESSION);
    let what = ObservationPacket { ready_us: 4_000, observed_us: 4_300, ..packets::observation(1, 2) };
    delays.observed(&Received { what, received_us: 1_004_700, captured_us: Some(1_000_000) });
    delays.observed(&Received { what, received_us: 1_004_700, captured_us: None });
    about(&delays, Stage::Ready, 4_000, 2);
    about(&delays, Stage::Observed, 300, 2);
    about(&delays, Stage::Received, 400, 1);

    for sequence in [40, 41, 42] {
        delays.sent(&motion(sequence));
    }
    about(&delays, Stage::Joined, 2_500, 3);
    about(&delays, Stage::Posed, 100, 3);
    about(&delays, Stage::Sent, 10, 3);
    about(&delays, Stage::ReadyToSent, 610, 3);

    delays.arm_state(&state(Some(echo(41, SESSION)), Some(Settled { sequence: 40, after_us: 30_000 })));
    about(&delays, Stage::Back, 1_000, 1);
    about(&delays, Stage::Solved, 200, 1);
    about(&delays, Stage::Written, 300, 1);
    about(&delays, Stage::HeardOf, 7_390, 1);
    about(&delays, Stage::Arrived, 3_390, 1);
    about(&delays, Stage::SentToWritten, 3_890, 1);
    about(&delays, Stage::CaptureToWritten, 36_500, 1);
    about(&delays, Stage::Settled, 30_000, 1);
}

#[test]
fn a_motion_that_is_told_of_again_counts_once_and_others_not_at_all() {
    let mut delays = Delays::new(SESSION);
    delays.sent(&motion(5));
    for _ in 0..3 {
        delays.arm_state(&state(Some(echo(5, SESSION)), Some(Settled { sequence: 5, after_us: 9 })));
    }
    about(&delays, Stage::HeardOf, 7_390, 1);
    about(&delays, Stage::Settled, 9, 1);
    about(&delays, Stage::Back, 1_000, 3);
    delays.arm_state(&state(Some(echo(6, SESSION + 1)), None));
    assert_eq!(delays.of(Stage::Solved).unwrap().count, 1, "of another operator");
    delays.arm_state(&state(Some(echo(900, SESSION)), None));
    assert_eq!(delays.of(Stage::HeardOf).unwrap().count, 1, "of a motion that nobody remembers");
    assert_eq!(delays.of(Stage::Solved).unwrap().count, 2, "which the slave's clock tells all the same");
}

#[test]
fn the_memory_is_of_the_newest_and_numbers_wrap() {
    let mut delays = Delays::new(SESSION);
    for sequence in (0..2_000).map(|n: u32| n.wrapping_sub(1_900)) {
        delays.sent(&motion(sequence));
    }
    assert_eq!(delays.sent.len(), REMEMBERED);
    assert_eq!(delays.find(99).unwrap().sequence, 99);
    assert_eq!(delays.find(100), None);
    assert_eq!(delays.find(u32::MAX - 5).unwrap().sequence, u32::MAX - 5);
    assert_eq!(delays.find(u32::MAX - 1_000), None);
}

#[test]
fn the_table_has_what_was_measured() {
    let mut delays = Delays::new(SESSION);
    delays.sent(&motion(1));
    let table = delays.table();
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 5, "{table}");
    assert!(lines[0].ends_with("p50       p99       max"), "{table}");
    let joined: Vec<&str> = lines[1].split_whitespace().rev().take(4).collect();
    assert_eq!(joined[3], "1");
    let p50: f64 = joined[2].parse().unwrap();
    assert!((p50 - 2.5).abs() < 0.03, "{table}");
    for (at, stage) in Stage::ALL.into_iter().enumerate() {
        assert_eq!(stage as usize, at);
    }
}

#[test]
fn what_is_slow_lately_is_seen_and_forgotten_again() {
    const S: u64 = 1_000_000;
    let mut delays = Delays::new(SESSION);
    let send = |delays: &mut Delays, from_s: u64, to_s: u64, joined_after_us: u64| {
        for sent_us in (from_s * S..to_s * S).step_by(10_000) {
            let first_us = sent_us - joined_after_us;
            delays.sent(&SentMotion {
                first_us,
                joined_us: sent_us,
                posed_us: sent_us,
                sent_us,
                ..motion(1)
            });
        }
    };
    let p50 = |delays: &Delays, now_us: u64| delays.lately(Stage::Joined, now_us).map(|spread| spread.p50_us);
    assert_eq!(p50(&delays, 100 * S), None);
    send(&mut delays, 100, 3_700, 2_000);
    send(&mut delays, 3_700, 3_712, 80_000);
    // two digits; a hundredth of an hour moves neither figure of the whole
    assert!(p50(&delays, 3_712 * S).unwrap() >= 79_000);
    assert!(delays.of(Stage::Joined).unwrap().p99_us <= 2_100);
    let lately = delays.lately(Stage::Joined, 3_712 * S).unwrap();
    assert!((400..=1_000).contains(&lately.count), "of the last 5 to 10 s: {lately:?}");
    send(&mut delays, 3_712, 3_724, 2_000);
    assert!(p50(&delays, 3_724 * S).unwrap() <= 2_100);
    assert_eq!(p50(&delays, 3_740 * S), None, "nothing came any more");
    // and anew after the pause, without what was before it
    send(&mut delays, 3_740, 3_741, 80_000);
    assert_eq!(delays.lately(Stage::Joined, 3_741 * S).unwrap().count, 100);
}
