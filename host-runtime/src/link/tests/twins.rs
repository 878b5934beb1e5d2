//! Two processes of one name and key: who has the arm keeps it, and whoever is dead is followed.

use super::relay::Relay;
use super::*;
use std::sync::atomic::Ordering;

fn picture(session: u32, sequence: u32) -> Picture {
    let (width, height, jpeg) = (2, 2, vec![1, 2, 3]);
    Picture { camera: 0, session, sequence, capture_us: 3, width, height, jpeg }
}

/// Sends pictures until one comes through.
fn pass_picture(from: &Peer, session: u32, to: &Peer, next: &mut u32) {
    wait_for("a picture", || {
        *next += 1;
        from.send_picture(&picture(session, *next)).unwrap();
        std::thread::sleep(Duration::from_millis(5));
        to.picture(0)
    });
}

#[test]
fn the_older_of_two_keeps_the_arm_and_the_other_gets_it_afterwards() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let to_operator = only_peer(&slave);
    let first = dialler(&keys, "operator", "slave", slave.local_address());
    let to_first = connected(&first);
    let (mut next, mut pictures) = (0, 0);
    pass_motion(&to_first, first.session(), &to_operator, &mut next);
    pass_picture(&to_operator, slave.session(), &to_first, &mut pictures);

    let second = dialler(&keys, "operator", "slave", slave.local_address());
    let to_second = only_peer(&second);
    let told = wait_for("a line of the second's", || next_event(&second)).to_string();
    assert!(told.contains("slave is not reached") && told.contains("connected already"), "{told}");
    let refused = |event: &LinkEvent| matches!(event, LinkEvent::Refused { .. });
    let told = wait_for("a line of the slave's", || slave.events().into_iter().find(refused)).to_string();
    assert!(told.contains("end one of the two"), "{told}");
    for _ in 0..20 {
        pass_motion(&to_first, first.session(), &to_operator, &mut next);
        pass_picture(&to_operator, slave.session(), &to_first, &mut pictures);
        to_second.send(&motion(second.session(), 1_000_000)).unwrap();
    }
    let stats = to_operator.stats();
    assert_eq!((stats.connected, stats.received.other_session), (1, 0), "the first was never left");
    assert_eq!((to_second.stats().connected, to_second.picture(0)), (0, None), "the second was never there");

    drop(first);
    connected(&second);
    pass_motion(&to_second, second.session(), &to_operator, &mut next);
    pass_picture(&to_operator, slave.session(), &to_second, &mut pictures);
    assert_eq!(to_operator.stats().connected, 2);
}

#[test]
fn one_that_was_killed_is_followed_at_once_and_does_not_come_back() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let to_operator = only_peer(&slave);
    // a process that was killed says no farewell: its cable is cut
    let relay = Relay::start(slave.local_address());
    let killed = dialler(&keys, "operator", "slave", relay.address);
    let to_killed = connected(&killed);
    let (mut next, mut pictures) = (0, 0);
    pass_motion(&to_killed, killed.session(), &to_operator, &mut next);
    relay.cut.store(true, Ordering::Relaxed);

    let again = dialler(&keys, "operator", "slave", slave.local_address());
    let to_again = connected(&again);
    pass_motion(&to_again, again.session(), &to_operator, &mut next);
    pass_picture(&to_operator, slave.session(), &to_again, &mut pictures);

    // it was not dead after all
    relay.cut.store(false, Ordering::Relaxed);
    let not_reached = |event: &LinkEvent| matches!(event, LinkEvent::NotReached { .. });
    let told = wait_for("a refusal", || killed.events().into_iter().find(not_reached)).to_string();
    assert!(told.contains("end one of the two"), "{told}");
    for _ in 0..20 {
        to_killed.send(&motion(killed.session(), 1_000_000)).unwrap();
        assert!(pass_motion(&to_again, again.session(), &to_operator, &mut next) < 1_000_000);
        pass_picture(&to_operator, slave.session(), &to_again, &mut pictures);
    }
    assert!(!to_killed.is_connected());
    assert_eq!(to_operator.stats().connected, 2);
}
