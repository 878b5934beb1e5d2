//! Promise: whatever the network does, the arm follows or stops; it never jumps; and where the link comes
//! back it ends where the hand led it. A hand moves the slave that is shipped, over a link with faults and
//! the decoder that is shipped, on simulated time, and the tables of what came of it are compared with
//! tests/snapshots/link_faults.txt.
//!
//! `TETRAD_BLESS=1 cargo test -p tetrad-tests --test link_faults` rewrites it: read the difference.

mod outcome;
mod rig;

use outcome::apart_m;
use rig::{Commands, HAPPENS_US, hand_m, run};
use std::fmt::Write as _;
use tetrad::link::faulty::Faults;
use tetrad_fixtures::golden;

/// Rows and columns of the first table.
const LOSS: [f64; 5] = [0.0, 0.1, 0.2, 0.3, 0.5];
const DELAY_MS: [u64; 5] = [0, 20, 100, 300, 1000];

const NONE: Faults = Faults {
    loss: 0.0,
    delay_us: 0,
    jitter_us: 0,
    duplication: 0.0,
    corruption: 0.0,
    unseen: false,
    replay: 0.0,
    cut: None,
};

/// Rows of the second table.
const KINDS: [(&str, Faults); 15] = [
    ("none", NONE),
    ("loss 30 %", Faults { loss: 0.3, ..NONE }),
    ("loss 50 %", Faults { loss: 0.5, ..NONE }),
    ("delay 300 ms", Faults { delay_us: 300_000, ..NONE }),
    ("delay 1 s", Faults { delay_us: 1_000_000, ..NONE }),
    ("jitter, reorder 40 ms", Faults { jitter_us: 40_000, ..NONE }),
    ("jitter, reorder 200 ms", Faults { jitter_us: 200_000, ..NONE }),
    ("duplication 50 %", Faults { duplication: 0.5, jitter_us: 40_000, ..NONE }),
    ("again after 1 s, 50 %", Faults { replay: 0.5, ..NONE }),
    ("corruption 10 %", Faults { corruption: 0.1, ..NONE }),
    ("corruption 50 %", Faults { corruption: 0.5, ..NONE }),
    ("unseen corruption 5 %", Faults { corruption: 0.05, unseen: true, ..NONE }),
    ("cut of 0.3 s", Faults { cut: Some((10_000_000, 10_300_000)), ..NONE }),
    ("cut of 2 s", Faults { cut: Some((10_000_000, 12_000_000)), ..NONE }),
    (
        "all but unseen",
        Faults {
            loss: 0.2,
            delay_us: 100_000,
            jitter_us: 40_000,
            duplication: 0.2,
            corruption: 0.1,
            unseen: false,
            replay: 0.2,
            cut: Some((9_000_000, 9_700_000)),
        },
    ),
];

fn losing(loss: f64, delay_ms: u64) -> Faults {
    Faults {
        loss,
        delay_us: delay_ms * 1_000,
        jitter_us: 10_000,
        duplication: 0.05,
        corruption: 0.02,
        replay: 0.05,
        ..NONE
    }
}

/// Milliseconds, rounded up.
fn ms(us: u64) -> u64 {
    us.div_ceil(1_000)
}

fn loss_by_delay() -> Result<String, std::fmt::Error> {
    let reference = run(1, NONE, Commands::OfOne);
    let mut table = String::from(
        "A hand moves an arm over a link that loses and delays packets both ways (and doubles 5 % of them,\n\
         plays 5 % again a second later, damages 2 %, and adds up to 10 ms to each). Each cell: the largest\n\
         distance of the tool from where it is without faults, mm / where the operator dies: the latest that a\n\
         stop begins after the last fresh command came, ms / and after the last of all the arm rests, ms.\n\n",
    );
    write!(table, "{:>9}", "loss %")?;
    DELAY_MS.iter().try_for_each(|delay| write!(table, "{:>22}", format!("{delay} ms")))?;
    writeln!(table)?;
    for loss in LOSS {
        write!(table, "{:>9.0}", loss * 100.0)?;
        for delay_ms in DELAY_MS {
            let what = format!("loss {loss}, delay {delay_ms} ms");
            let faults = losing(loss, delay_ms);
            let whole = run(7, faults, Commands::OfOne);
            let killed = run(7, faults, Commands::Ending);
            whole.check(&what);
            whole.check_end(&what);
            killed.check(&what);
            killed.check_rest(&what);
            let error_mm = whole.error_m(&reference) * 1e3;
            let cell = format!("{error_mm:.1} / {} / {}", ms(killed.stop_us), ms(killed.rest_us));
            write!(table, "{cell:>22}")?;
        }
        writeln!(table)?;
    }
    Ok(table)
}

fn kinds_by_commands() -> Result<String, std::fmt::Error> {
    let mut table = String::from(
        "Each kind of fault, while commands come of one operator; of a second sender beside it; of an\n\
         operator that is started again amid the movement; and of one that dies. Each cell: the latest that\n\
         a stop began after the last fresh command had come, ms / how often the arm stopped following amid\n\
         the movement / how far it is in the end from where the hand led it, um (- where it rests instead).\n\n",
    );
    write!(table, "{:>24}", "")?;
    for commands in ["one", "two", "started again", "ending"] {
        write!(table, "{commands:>18}")?;
    }
    writeln!(table)?;
    for (kind, faults) in KINDS {
        write!(table, "{kind:>24}")?;
        for commands in Commands::ALL {
            let what = format!("{kind}, {commands:?}");
            let outcome = run(11, faults, commands);
            outcome.check(&what);
            let off_m = match commands {
                Commands::Ending => {
                    outcome.check_rest(&what);
                    None
                }
                // what is changed unseen may be a number far ahead, after which nothing is new any more
                _ if faults.unseen => outcome.off_m().map(|(sent_m, _)| sent_m),
                _ => Some(outcome.check_end(&what)),
            };
            assert_eq!(outcome.second_senders, 0, "{what}: the law heard of another");
            let off = off_m.map_or_else(|| "-".to_owned(), |off_m| format!("{:.0}", off_m * 1e6));
            let cell = format!("{} / {} / {off}", ms(outcome.stop_us), outcome.stops);
            write!(table, "{cell:>18}")?;
        }
        writeln!(table)?;
    }
    Ok(table)
}

#[test]
fn the_fault_tables() -> Result<(), Box<dyn std::error::Error>> {
    let tables = format!("{}\n{}", loss_by_delay()?, kinds_by_commands()?);
    golden::check_file(
        &tetrad_tests::repository().join("tests/snapshots/link_faults.txt"),
        tables.as_bytes(),
    )?;
    Ok(())
}

/// Each packet holds the whole motion: where hold-to-run was heard all the time, the arm ends where it ends
/// without faults, whatever was lost on the way.
#[test]
fn what_was_lost_on_the_way_is_not_missing_at_the_end() {
    let reference = run(1, NONE, Commands::OfOne);
    let [first, last] = [reference.tool_m.iter().flatten().next(), reference.tool_m.iter().flatten().last()];
    let (first, last) = (*first.expect("cycles"), *last.expect("cycles"));
    let led = hand_m(u64::MAX).map(f64::from);
    let moved = [0, 1, 2].map(|axis| last[axis] - first[axis]);
    assert!(apart_m(moved, led) < 1e-4, "it went {moved:?}");
    for (loss, delay_ms) in [(0.1, 20), (0.3, 20), (0.3, 100), (0.2, 1000)] {
        let outcome = run(3, losing(loss, delay_ms), Commands::OfOne);
        let end = outcome.tool_m.last().copied().flatten().expect("cycles");
        assert!(apart_m(end, last) < 1e-4, "{loss}, {delay_ms}: {} m", apart_m(end, last));
    }
}

/// Nothing of a second sender's reaches the arm, to the bit.
#[test]
fn a_second_sender_changes_nothing() {
    let alone = run(5, NONE, Commands::OfOne);
    let beside = run(5, NONE, Commands::OfTwo);
    assert!(alone.tool_m == beside.tool_m);
}

/// What QUIC lets nobody do: a peer's packets are changed and taken for whole. The arm may stop for good
/// (a number far ahead makes all that follow old), but in time, within its limits, and nothing panics.
#[test]
fn damage_that_nobody_sees_makes_no_jump() {
    let mut followed = 0;
    for seed in 0..60 {
        let share = [0.002, 0.02, 0.2][usize::try_from(seed % 3).expect("small")];
        let damage = Faults { corruption: share, unseen: true, ..NONE };
        let outcome = run(seed, damage, Commands::OfOne);
        outcome.check_bounds(&format!("seed {seed}, {share}"));
        followed += outcome.followed;
    }
    assert!(followed > 60 * 100, "{followed} cycles");
}

/// The end of a cut, and a station that is started again, move nothing at once.
#[test]
fn what_comes_back_waits_for_a_press() {
    let cut = Faults { cut: Some((HAPPENS_US, HAPPENS_US + 2_000_000)), ..NONE };
    for (faults, commands, back_us) in
        [(cut, Commands::OfOne, 2_000_000), (NONE, Commands::StartedAgain, 200_000)]
    {
        let outcome = run(5, faults, commands);
        let at = |us: u64| outcome.tool_m[usize::try_from(us / 10_000).expect("few cycles")].expect("sent");
        // one is heard to have let go, by itself, in the first packets after the cut; the other has to
        let rests_us = HAPPENS_US + 190_000;
        let until_us = HAPPENS_US + back_us + 10_000;
        assert!(apart_m(at(rests_us), at(until_us)) < 1e-9, "{commands:?}");
        let after = (until_us..until_us + 2_000_000).step_by(10_000);
        let way_m: f64 = after.map(|us| apart_m(at(us), at(us + 10_000))).sum();
        assert!(way_m > 0.05, "{commands:?}: then it follows again: {way_m} m");
    }
}
