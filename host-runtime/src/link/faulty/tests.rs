use super::*;
use crate::link::test_packets::{buttons, motion};

const SESSION: u32 = 7;
const PERIOD_US: u64 = 10_000;

/// Sends a motion each 10 ms for so many, and gives the numbers and ages of those that came through.
fn run(seed: u64, faults: Faults, packets: u32) -> (Vec<(u32, u64)>, FaultyEnd) {
    let clock = Clock::given();
    let [operator, slave] = pair(seed, [faults, Faults::default()], &clock);
    slave.begin(SESSION).unwrap();
    let mut came = Vec::new();
    for tick in 0..10 * (u64::from(packets) + 400) {
        let now_us = tick * PERIOD_US / 10;
        clock.set(now_us);
        let sequence = u32::try_from(tick / 10).unwrap();
        if tick % 10 == 0 && sequence < packets {
            operator.send(&motion(SESSION, sequence)).unwrap();
        }
        if let Some(newest) = slave.motion() {
            let sent_us = u64::from(newest.what.sequence) * PERIOD_US;
            came.push((newest.what.sequence, now_us.saturating_sub(sent_us)));
        }
    }
    (came, slave)
}

#[test]
fn without_faults_all_comes_at_once() {
    let (came, slave) = run(1, Faults::default(), 50);
    assert_eq!(came, (0..50).map(|sequence| (sequence, 0)).collect::<Vec<_>>());
    assert_eq!(slave.carried(), Carried { sent: 50, arrived: 50, damaged: 0, dropped: 0 });
}

#[test]
fn the_same_seed_is_the_same_network() {
    let faults = Faults { loss: 0.3, delay_us: 20_000, jitter_us: 40_000, ..Faults::default() };
    assert_eq!(run(5, faults, 200).0, run(5, faults, 200).0);
    assert_ne!(run(5, faults, 200).0, run(6, faults, 200).0);
}

#[test]
fn whatever_the_network_does_only_newer_motion_comes_through() {
    let everything = Faults {
        loss: 0.3,
        delay_us: 100_000,
        jitter_us: 60_000,
        duplication: 0.5,
        corruption: 0.1,
        unseen: false,
        replay: 0.5,
        cut: Some((2_000_000, 4_000_000)),
    };
    for seed in 0..20 {
        let (came, slave) = run(seed, everything, 1_000);
        assert!(came.windows(2).all(|pair| pair[0].0 < pair[1].0), "{came:?}");
        // what is kept on the way comes through only where nothing newer does: in the cut, at the end
        let old: Vec<_> = came.iter().filter(|(_, age_us)| !(100_000..=170_000).contains(age_us)).collect();
        assert!(old.iter().all(|(sequence, _)| (150..200).contains(sequence) || *sequence > 950), "{old:?}");
        let gap = came.iter().filter(|(sequence, _)| (200..400).contains(sequence)).count();
        assert_eq!(gap, 0, "nothing came through the cut");
        assert!(came.last().unwrap().0 > 950, "it goes on after the cut");
        let counts = slave.with_inbox(|inbox| inbox.counts());
        assert!(counts.motion.repeated > 100 && counts.motion.late > 10, "{counts:?}");
        assert!(slave.carried().dropped > 100);
    }
}

#[test]
fn loss_is_measured() {
    for loss in [0.0, 0.1, 0.5] {
        let faults = Faults { loss, jitter_us: 30_000, ..Faults::default() };
        let (_, slave) = run(3, faults, 4_000);
        let measured = slave.with_inbox(|inbox| inbox.counts().motion.loss());
        assert!((measured - loss).abs() < 0.03, "{loss}: {measured}");
    }
}

#[test]
fn damage_is_found() {
    let (came, slave) = run(9, Faults { corruption: 0.5, ..Faults::default() }, 2_000);
    let carried = slave.carried();
    // where one bit was changed twice, nothing was
    assert!((900..1_100).contains(&carried.damaged), "{carried:?}");
    assert_eq!((came.len() as u64, carried.dropped), (2_000 - carried.damaged, 0), "the rest is whole");
    assert!(came.iter().all(|(sequence, age_us)| *age_us == 0 && *sequence < 2_000));
}

#[test]
fn damage_that_is_not_found_is_refused_or_is_a_packet() {
    let (came, slave) = run(9, Faults { corruption: 1.0, unseen: true, ..Faults::default() }, 2_000);
    let counts = slave.with_inbox(|inbox| inbox.counts());
    assert!(counts.no_packet > 200, "{counts:?}");
    assert!(counts.other_session > 5, "{counts:?}");
    assert!(!came.is_empty() && came.len() < 2_000, "{}", came.len());
    assert_eq!(slave.carried().damaged, 0);
}

#[test]
fn a_session_that_ended_stays_ended_behind_any_delay() {
    let clock = Clock::given();
    let slow = Faults { delay_us: 500_000, ..Faults::default() };
    let [operator, slave] = pair(1, [slow, Faults::default()], &clock);
    slave.begin(7).unwrap();
    operator.send(&motion(7, 100)).unwrap();
    operator.send(&buttons(7, 100, true)).unwrap();
    clock.set(100_000);
    slave.begin(8).unwrap();
    operator.send(&motion(8, 0)).unwrap();
    clock.set(550_000);
    assert_eq!((slave.motion(), slave.buttons()), (None, None), "of the session before");
    clock.set(600_000);
    let newest = slave.motion().unwrap();
    assert_eq!((newest.what.session, newest.received_us), (8, 600_000));
}
