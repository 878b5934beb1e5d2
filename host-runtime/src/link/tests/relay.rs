//! Somebody in the middle who hands on datagrams: cut, recorded, played again.

use super::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Bytes: longer than acknowledgements and motion, shorter than pieces of a picture.
const SHORT: usize = 600;

/// Between one who dials and one who is dialled.
pub(super) struct Relay {
    pub(super) address: SocketAddr,
    /// What the dialler's side is known by to the other.
    socket: UdpSocket,
    to: SocketAddr,
    pub(super) cut: Arc<AtomicBool>,
    /// Only what is short passes, as on a line that is full.
    full: Arc<AtomicBool>,
    recorded: Arc<Mutex<Vec<Vec<u8>>>>,
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Relay {
    pub(super) fn start(to: SocketAddr) -> Self {
        let bind = || {
            let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
            socket.set_read_timeout(Some(Duration::from_millis(20))).unwrap();
            socket
        };
        let (front, back) = (bind(), bind());
        let (cut, stop) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let full = Arc::new(AtomicBool::new(false));
        let recorded = Arc::new(Mutex::new(Vec::new()));
        let dialler = Arc::new(Mutex::new(None::<SocketAddr>));
        let hand_on = |from: UdpSocket, out: UdpSocket, forth: bool| {
            let (cut, full, stop) = (Arc::clone(&cut), Arc::clone(&full), Arc::clone(&stop));
            let (recorded, dialler) = (Arc::clone(&recorded), Arc::clone(&dialler));
            std::thread::spawn(move || {
                let mut bytes = [0; 65_536];
                while !stop.load(Ordering::Relaxed) {
                    let Ok((length, sender)) = from.recv_from(&mut bytes) else { continue };
                    let datagram = &bytes[..length];
                    let receiver = if forth {
                        *dialler.lock().unwrap() = Some(sender);
                        recorded.lock().unwrap().push(datagram.to_vec());
                        Some(to)
                    } else {
                        *dialler.lock().unwrap()
                    };
                    let kept = full.load(Ordering::Relaxed) && length > SHORT;
                    if let Some(receiver) = receiver.filter(|_| !kept && !cut.load(Ordering::Relaxed)) {
                        let _ = out.send_to(datagram, receiver);
                    }
                }
            })
        };
        let threads = vec![
            hand_on(front.try_clone().unwrap(), back.try_clone().unwrap(), true),
            hand_on(back.try_clone().unwrap(), front.try_clone().unwrap(), false),
        ];
        let address = front.local_addr().unwrap();
        Self { address, socket: back, to, cut, full, recorded, stop, threads }
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.threads.drain(..).for_each(|thread| thread.join().unwrap());
    }
}

#[test]
fn what_was_recorded_and_is_played_again_moves_nothing() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let relay = Relay::start(slave.local_address());
    let to_operator = only_peer(&slave);
    let mut next = 0;
    {
        let operator = dialler(&keys, "operator", "slave", relay.address);
        let to_slave = connected(&operator);
        let mut newest = 0;
        for _ in 0..20 {
            newest = pass_motion(&to_slave, operator.session(), &to_operator, &mut next);
        }
        // within the connection, from the same address
        let recording = relay.recorded.lock().unwrap().clone();
        assert!(recording.len() > 20);
        for datagram in recording.iter().chain(&recording) {
            relay.socket.send_to(datagram, relay.to).unwrap();
        }
        let seen = pass_motion(&to_slave, operator.session(), &to_operator, &mut next);
        assert!(seen > newest, "played again: {seen}");
        let counts = to_operator.stats().received;
        // QUIC drops what it has seen before the inbox sees it
        assert_eq!(counts.motion.repeated, 0, "{counts:?}");
        assert!(counts.motion.taken <= u64::from(next), "{counts:?}");
    }
    wait_for("the end", || (!to_operator.is_connected()).then_some(()));
    to_operator.motion();
    // "yesterday's": the connection is gone, and so are its keys
    let recording = relay.recorded.lock().unwrap().clone();
    for datagram in &recording {
        relay.socket.send_to(datagram, relay.to).unwrap();
    }
    let operator = dialler(&keys, "operator", "slave", slave.local_address());
    let to_slave = connected(&operator);
    let before = next;
    assert!(pass_motion(&to_slave, operator.session(), &to_operator, &mut next) > before);
    let counts = to_operator.stats().received;
    assert_eq!(counts.motion.repeated, 0, "{counts:?}");
    // the new operator's first may come before its greeting; all that came was sent once
    assert!(counts.motion.taken + counts.other_session <= u64::from(next), "{counts:?}");
}

#[test]
fn a_cut_of_two_seconds_is_lived_through() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let relay = Relay::start(slave.local_address());
    let operator = dialler(&keys, "operator", "slave", relay.address);
    let (to_slave, to_operator) = (connected(&operator), connected(&slave));
    let mut next = 0;
    pass_motion(&to_slave, operator.session(), &to_operator, &mut next);
    relay.cut.store(true, Ordering::Relaxed);
    // what was on its way when the cable was cut
    std::thread::sleep(Duration::from_millis(100));
    to_operator.motion();
    let cut = Instant::now();
    while cut.elapsed() < Duration::from_secs(2) {
        next += 1;
        to_slave.send(&motion(operator.session(), next)).unwrap();
        assert_eq!(to_operator.motion(), None);
        std::thread::sleep(Duration::from_millis(16));
    }
    let during = next;
    relay.cut.store(false, Ordering::Relaxed);
    let seen = pass_motion(&to_slave, operator.session(), &to_operator, &mut next);
    assert!(seen + 1 >= during, "what comes after the cut is new: {seen}, cut until {during}");
    assert!(to_operator.stats().received.motion.lost > 50, "{:?}", to_operator.stats());
}

#[test]
fn a_long_cut_ends_the_connection_and_it_comes_back_as_the_same_session() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let relay = Relay::start(slave.local_address());
    let operator = dialler(&keys, "operator", "slave", relay.address);
    let (to_slave, to_operator) = (connected(&operator), connected(&slave));
    let mut next = 0;
    pass_motion(&to_slave, operator.session(), &to_operator, &mut next);
    relay.cut.store(true, Ordering::Relaxed);
    wait_for("the end", || (!to_operator.is_connected() && !to_slave.is_connected()).then_some(()));
    relay.cut.store(false, Ordering::Relaxed);
    wait_for("the return", || to_operator.is_connected().then_some(()));
    to_operator.motion();
    let before = next;
    // an old number does not count though the connection is new
    wait_for("a drop", || {
        to_slave.send(&motion(operator.session(), 0)).unwrap();
        (to_operator.stats().received.motion.repeated > 0).then_some(())
    });
    assert_eq!(to_operator.motion(), None);
    assert!(pass_motion(&to_slave, operator.session(), &to_operator, &mut next) > before);
}

#[test]
fn a_picture_that_is_late_is_given_up_and_never_comes() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let relay = Relay::start(slave.local_address());
    let operator = dialler(&keys, "operator", "slave", relay.address);
    let (to_slave, to_operator) = (connected(&operator), connected(&slave));
    let send = |sequence| {
        let picture = Picture {
            camera: 0,
            session: slave.session(),
            sequence,
            capture_us: 3,
            width: 640,
            height: 480,
            jpeg: vec![7; 50_000],
        };
        to_operator.send_picture(&picture).unwrap();
    };
    let mut last = 0;
    wait_for("a picture", || {
        last += 1;
        send(last);
        to_slave.picture(0)
    });
    // the last of these, so that none is on its way any more
    wait_for("all sent", || {
        let counts = to_operator.stats().pictures_sent;
        (counts.sent + counts.overtaken >= u64::from(last)).then_some(())
    });
    send(last + 1);
    wait_for("the last", || to_slave.picture(0).filter(|picture| picture.what.sequence > last));
    relay.full.store(true, Ordering::Relaxed);
    let late = last + 2;
    let before = to_operator.stats().pictures_sent;
    // as many as may be on their way at a time
    for (sequence, sent) in (late..late + 2).zip(before.sent + 1..) {
        send(sequence);
        wait_for("its turn", || (to_operator.stats().pictures_sent.sent >= sent).then_some(()));
    }
    wait_for("the end of both", || {
        (to_operator.stats().pictures_sent.overtaken >= before.overtaken + 2).then_some(())
    });
    relay.full.store(false, Ordering::Relaxed);
    let mut next = late + 1;
    let came = wait_for("a newer picture", || {
        next += 1;
        send(next);
        to_slave.picture(0)
    });
    assert!(came.what.sequence > late + 1, "{} came after it was given up", came.what.sequence);
}
