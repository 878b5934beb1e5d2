//! The link over real sockets on loopback. Waits are for progress, bounded, and never judge speed.

use super::authority::{make_authority, make_station};
use super::test_packets::{body, buttons, motion, observation};
use super::*;
use std::net::UdpSocket;
use std::time::Instant;
use tempfile::TempDir;

mod discovery;
mod relay;
mod strangers;
mod twins;

/// How long something may take that takes a moment on an idle computer.
const PATIENCE: Duration = Duration::from_secs(60);

fn name(text: &str) -> StationName {
    text.parse().unwrap()
}

/// A directory with an authority and a certificate for each of these.
fn keys(stations: &[&str]) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    make_authority(dir.path()).unwrap();
    for station in stations {
        make_station(dir.path(), &name(station)).unwrap();
    }
    dir
}

fn identity(keys: &TempDir, station: &str) -> Identity {
    Identity::load(keys.path(), &name(station)).unwrap()
}

/// A station that is dialled by these.
fn listener(keys: &TempDir, station: &str, peers: &[&str]) -> Link {
    let peers = peers.iter().map(|peer| PeerConfig { name: name(peer), address: None }).collect();
    let listen = Some(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
    let config = LinkConfig { listen, peers, picture_bytes_per_s: PICTURE_BYTES_PER_S };
    Link::start(&config, &identity(keys, station), Clock::wall()).unwrap()
}

/// A station that dials this one.
fn dialler(keys: &TempDir, station: &str, peer: &str, address: SocketAddr) -> Link {
    let peers = vec![PeerConfig { name: name(peer), address: Some(address.to_string()) }];
    let config = LinkConfig { listen: None, peers, picture_bytes_per_s: PICTURE_BYTES_PER_S };
    Link::start(&config, &identity(keys, station), Clock::wall()).unwrap()
}

fn only_peer(link: &Link) -> Peer {
    link.peers().next().unwrap()
}

/// The newest of what happened since this was last asked.
fn next_event(link: &Link) -> Option<LinkEvent> {
    link.events().into_iter().rfind(|event| !matches!(event, LinkEvent::SmallBuffer { .. }))
}

/// What `look` gives once it gives something.
fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(seen) = look() {
            return seen;
        }
        assert!(start.elapsed() < PATIENCE, "in vain: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn connected(link: &Link) -> Peer {
    let peer = only_peer(link);
    wait_for("a connection", || peer.is_connected().then_some(()));
    peer
}

/// Sends a motion again and again, numbered on, until one comes through; its number.
fn pass_motion(from: &Peer, session: u32, to: &Peer, next: &mut u32) -> u32 {
    wait_for("motion", || {
        *next += 1;
        from.send(&motion(session, *next)).unwrap();
        to.motion().map(|newest| newest.what.sequence)
    })
}

#[test]
fn packets_pass_both_ways_and_the_clocks_are_compared() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let operator = dialler(&keys, "operator", "slave", slave.local_address());
    let (to_slave, to_operator) = (connected(&operator), connected(&slave));
    let mut next = 0;
    pass_motion(&to_slave, operator.session(), &to_operator, &mut next);
    wait_for("buttons", || {
        next += 1;
        to_slave.send(&buttons(operator.session(), next, true)).unwrap();
        to_operator.buttons().filter(|newest| newest.what.pressed)
    });
    wait_for("observations", || {
        next += 1;
        to_operator.send(&observation(slave.session(), next, 2)).unwrap();
        to_slave.observation(2)
    });
    for peer in [&to_slave, &to_operator] {
        let clock = wait_for("the clock", || peer.stats().clock);
        let stats = peer.stats();
        assert!(stats.round_trip_us.is_some() && stats.address.is_some(), "{stats:?}");
        assert_eq!((stats.connected, stats.received.no_packet), (1, 0), "{stats:?}");
        // both clocks are this computer's, and were started within this test
        assert!(clock.offset_us.unsigned_abs() < 120_000_000, "{clock:?}");
    }
    let told = |link: &Link| {
        let small = |event: &LinkEvent| matches!(event, LinkEvent::SmallBuffer { .. });
        let events = link.events().into_iter().filter(|event| !small(event));
        events.map(|event| event.to_string()).collect::<Vec<_>>()
    };
    let (slaves, operators) = (told(&slave), told(&operator));
    assert!(slaves[0].starts_with("link: operator is connected (127.0.0.1:"), "{slaves:?}");
    assert!(operators.last().unwrap().contains("slave is connected"), "{operators:?}");
    drop(operator);
    let lost = wait_for("the end", || next_event(&slave));
    assert_eq!(lost.to_string(), "link: operator is lost: the peer says: the station ended");
    assert!(!to_operator.is_connected());
}

#[test]
fn pictures_and_configuration_pass() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let operator = dialler(&keys, "operator", "slave", slave.local_address());
    let (to_slave, to_operator) = (only_peer(&operator), only_peer(&slave));
    to_slave.set_configuration(b"before anybody is there").unwrap();
    let configuration = wait_for("configuration", || to_operator.configuration());
    assert_eq!(configuration, b"before anybody is there");
    to_slave.set_configuration(b"another").unwrap();
    assert_eq!(wait_for("configuration", || to_operator.configuration()), b"another");
    assert!(to_slave.set_configuration(&[0; message::MAX_CONFIGURATION + 1]).is_err());

    let mut sequence = 0;
    let jpeg: Vec<u8> = (0..100_000_u32).map(|i| i as u8).collect();
    let picture = wait_for("a picture", || {
        sequence += 1;
        let picture = Picture {
            camera: 1,
            session: slave.session(),
            sequence,
            capture_us: 3,
            width: 640,
            height: 480,
            jpeg: jpeg.clone(),
        };
        to_operator.send_picture(&picture).unwrap();
        to_slave.picture(1)
    });
    assert_eq!(picture.what.jpeg, jpeg);
    assert_eq!(to_slave.picture(0), None);
    assert!(to_slave.stats().pictures_received >= 1 && to_operator.stats().pictures_sent.sent >= 1);
}

#[test]
fn a_slow_reader_sees_the_newest_and_holds_up_nobody() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let operator = dialler(&keys, "operator", "slave", slave.local_address());
    let (to_slave, to_operator) = (connected(&operator), connected(&slave));
    let last = 3_000;
    for sequence in 1..=last {
        to_slave.send(&motion(operator.session(), sequence)).unwrap();
    }
    // what was handed over faster than it went was overtaken in the outbox
    let sent = wait_for("all sent", || {
        let counts = to_slave.stats().sent;
        (counts.sent + counts.overtaken >= u64::from(last)).then_some(counts)
    });
    // datagrams may get lost on loopback as well, so the end is marked by more of them
    let mut next = last;
    wait_for("the newest", || {
        next += 1;
        to_slave.send(&motion(operator.session(), next)).unwrap();
        std::thread::sleep(Duration::from_millis(20));
        let newest = to_operator.motion()?.what.sequence;
        assert!(newest > last || sent.sent < 2, "an old one was kept: {newest}");
        Some(newest)
    });
    assert_eq!(to_operator.motion(), None, "one is all there is");
}

#[test]
fn a_station_that_starts_again_is_another_session() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let to_operator = only_peer(&slave);
    let mut sessions = Vec::new();
    for start in 1..=3 {
        let operator = dialler(&keys, "operator", "slave", slave.local_address());
        let to_slave = connected(&operator);
        wait_for("this start", || (to_operator.stats().connected == start).then_some(()));
        // a lower number than those before: it counts, for it is of another session
        let mut next = 10 - start;
        pass_motion(&to_slave, operator.session(), &to_operator, &mut next);
        // packets that say they are of the session before are dropped
        if let Some(before) = sessions.last() {
            let dropped = to_operator.stats().received.other_session;
            wait_for("a drop", || {
                to_slave.send(&motion(*before, 1_000_000)).unwrap();
                (to_operator.stats().received.other_session > dropped).then_some(())
            });
            assert!(to_operator.motion().is_none_or(|newest| newest.what.session != *before));
        }
        sessions.push(operator.session());
    }
    sessions.dedup();
    assert_eq!(sessions.len(), 3);
}

#[test]
fn a_dialler_finds_a_station_that_starts_again() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let address = slave.local_address();
    let operator = dialler(&keys, "operator", "slave", address);
    let to_slave = connected(&operator);
    drop(slave);
    wait_for("the loss", || (!to_slave.is_connected()).then_some(()));
    let peers = vec![PeerConfig { name: name("operator"), address: None }];
    let config = LinkConfig { listen: Some(address), peers, picture_bytes_per_s: 1 };
    let slave = Link::start(&config, &identity(&keys, "slave"), Clock::wall()).unwrap();
    let to_operator = connected(&slave);
    let mut next = 0;
    pass_motion(&to_slave, operator.session(), &to_operator, &mut next);
    assert_eq!(to_slave.stats().connected, 2);
}

#[test]
fn two_that_dial_each_other_have_one_connection() {
    let keys = keys(&["alpha", "beta"]);
    let free = || {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        socket.local_addr().unwrap()
    };
    let (at_alpha, at_beta) = (free(), free());
    let start = |own: &str, listen, peer: &str, address: SocketAddr| {
        let peers = vec![PeerConfig { name: name(peer), address: Some(address.to_string()) }];
        let config = LinkConfig { listen: Some(listen), peers, picture_bytes_per_s: 1 };
        Link::start(&config, &identity(&keys, own), Clock::wall()).unwrap()
    };
    let alpha = start("alpha", at_alpha, "beta", at_beta);
    let beta = start("beta", at_beta, "alpha", at_alpha);
    let (to_beta, to_alpha) = (connected(&alpha), connected(&beta));
    let mut next = 0;
    pass_motion(&to_beta, alpha.session(), &to_alpha, &mut next);
    pass_motion(&to_alpha, beta.session(), &to_beta, &mut next);
}

#[test]
fn a_configuration_that_cannot_work_is_refused_by_name() {
    let keys = keys(&["slave"]);
    let slave = identity(&keys, "slave");
    let peer = |text: &str, address: Option<&str>| PeerConfig {
        name: name(text),
        address: address.map(str::to_owned),
    };
    let refused = |listen, peers| {
        let config = LinkConfig { listen, peers, picture_bytes_per_s: 1 };
        Link::start(&config, &slave, Clock::wall()).unwrap_err().to_string()
    };
    let localhost = Some(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
    let twice = refused(localhost, vec![peer("operator", None), peer("operator", None)]);
    assert_eq!(twice, "two stations are called `operator`: give each a name of its own");
    assert!(refused(localhost, vec![peer("slave", None)]).contains("two stations are called `slave`"));
    let nowhere = refused(None, vec![peer("operator", None)]);
    assert!(nowhere.contains("`operator` has no address and this station does not listen"), "{nowhere}");
    let taken = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let taken = refused(taken.local_addr().ok(), vec![peer("operator", None)]);
    assert!(taken.contains("cannot listen on 127.0.0.1:"), "{taken}");
}

/// Not a promise but a figure: `cargo test --release -p tetrad link -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn round_trips_on_loopback() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let operator = dialler(&keys, "operator", "slave", slave.local_address());
    let (to_slave, to_operator) = (connected(&operator), connected(&slave));
    let stop = Arc::new(std::sync::atomic::AtomicBool::new(false));
    let echo = std::thread::spawn({
        let (stop, mut watch, session) = (Arc::clone(&stop), slave.watch(), slave.session());
        move || {
            while !stop.load(std::sync::atomic::Ordering::Relaxed) {
                watch.wait(Duration::from_millis(100));
                if let Some(newest) = to_operator.motion() {
                    to_operator.send(&motion(session, newest.what.sequence)).unwrap();
                }
            }
        }
    });
    let pictures = Arc::new(std::sync::atomic::AtomicBool::new(false));
    let cameras = std::thread::spawn({
        let (stop, pictures, session) = (Arc::clone(&stop), Arc::clone(&pictures), slave.session());
        let to_operator = only_peer(&slave);
        move || {
            for sequence in 0.. {
                if stop.load(std::sync::atomic::Ordering::Relaxed) {
                    return;
                }
                for camera in 0..2 {
                    let jpeg = vec![7; 40_000];
                    let (capture_us, width, height) = (0, 640, 480);
                    let picture = Picture { camera, session, sequence, capture_us, width, height, jpeg };
                    if pictures.load(std::sync::atomic::Ordering::Relaxed) {
                        to_operator.send_picture(&picture).unwrap();
                    }
                }
                std::thread::sleep(Duration::from_micros(16_667));
            }
        }
    });
    let mut watch = operator.watch();
    let pause = Duration::from_micros(8_333);
    for (base, title, pause) in [
        (1, "back to back", Duration::ZERO),
        (1_000_000, "at 120 Hz", pause),
        (2_000_000, "at 120 Hz, beside pictures of two cameras", pause),
    ] {
        let mut took = Vec::new();
        pictures.store(base == 2_000_000, std::sync::atomic::Ordering::Relaxed);
        for sequence in base..base + 2_000 {
            let sent = Instant::now();
            to_slave.send(&motion(operator.session(), sequence)).unwrap();
            let back = loop {
                if to_slave.motion().is_some_and(|newest| newest.what.sequence == sequence) {
                    break true;
                }
                if sent.elapsed() > Duration::from_millis(500) {
                    break false;
                }
                watch.wait(Duration::from_millis(50));
            };
            if back {
                took.push(sent.elapsed().as_micros());
            }
            std::thread::sleep(pause);
        }
        took.sort_unstable();
        let at = |share: usize| took[(took.len() * share / 1000).min(took.len() - 1)];
        println!(
            "{title}: {} of 2000, {} bytes, p50 {} us, p99 {} us, p99.9 {} us",
            took.len(),
            body(&motion(1, 1)).len(),
            at(500),
            at(990),
            at(999)
        );
    }
    stop.store(true, std::sync::atomic::Ordering::Relaxed);
    echo.join().unwrap();
    cameras.join().unwrap();
    println!("pictures received: {}", to_slave.stats().pictures_received);
}
