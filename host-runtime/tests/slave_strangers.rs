//! Promise: who has no certificate, or only a recording of another day's packets, gets nothing from
//! `tetrad slave`: no connection, no motion, and a line in its log.
#![cfg(unix)]

mod common;

use common::{command, tetrad};
use quinn::crypto::rustls::QuicClientConfig;
use rustls::crypto::ring;
use rustls::pki_types::{CertificateDer, pem::PemObject as _};
use std::fs::{self, File};
use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tetrad::link::{Carrier as _, Identity, Link, LinkConfig, PeerConfig, StationName};
use tetrad::robot::clock::Clock;
use tetrad_core::wire::{ArmState, VERSION};
use tetrad_fixtures::packets;

const LONG: Duration = Duration::from_secs(30);

const TICK: Duration = Duration::from_millis(5);

/// A slave's process; dropped, it is killed.
struct Slave {
    child: Child,
    log: std::path::PathBuf,
}

impl Drop for Slave {
    fn drop(&mut self) {
        // one that has ended is not there to be killed
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Slave {
    /// Starts it; `run` names its log and its results.
    fn start(dir: &Path, run: &str) -> Self {
        let log = dir.join(format!("{run}.log"));
        let mut command = command(&format!("slave --config tetrad.toml --out {run}"));
        command.current_dir(dir).stdin(Stdio::null()).stdout(Stdio::null());
        command.stderr(File::create(&log).unwrap());
        let slave = Self { child: command.spawn().unwrap(), log };
        slave.until_said("arm at");
        slave
    }

    fn until_said(&self, words: &str) {
        until(words, || self.said().contains(words).then_some(()));
    }

    fn said(&self) -> String {
        fs::read_to_string(&self.log).unwrap_or_default()
    }
}

#[track_caller]
fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(began.elapsed() < LONG, "never: {what}");
        std::thread::sleep(TICK);
    }
}

/// Keys and the slave's file; where it listens.
fn cell(dir: &Path) -> SocketAddr {
    tetrad(dir, "keys --out keys authority").done();
    for name in ["operator", "slave"] {
        tetrad(dir, &format!("keys --out keys station {name}")).done();
    }
    // a port that nobody has at the moment
    let address = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).unwrap();
    let text = format!(
        "[station]\nname = \"slave\"\nkeys = \"keys\"\nlisten = \"{address}\"\n[[peer]]\nname = \"operator\"\n\
         [slave]\noperator = \"operator\"\nport = \"sim:?noise=off&watchdog_ms=5000\"\n\
         [teleop]\ncommand_timeout_ms = 4000\nhold_to_run_timeout_ms = 4000\nresume_ms = 5000\n"
    );
    fs::write(dir.join("tetrad.toml"), text).unwrap();
    address
}

/// The different places of the tool that the slave sent its arm to, as far as they are on disk.
fn places(dir: &Path, run: &str) -> usize {
    let text = fs::read_to_string(dir.join(run).join("arm.csv")).unwrap();
    let mut rows = text.split_inclusive('\n').filter_map(|row| row.strip_suffix('\n'));
    let x = rows.next().unwrap().split(',').position(|column| column == "x").unwrap();
    let place = |row: &str| row.split(',').skip(x).take(3).collect::<Vec<_>>().join(",");
    let mut places: Vec<_> = rows.map(place).filter(|place| place != ",,").collect();
    places.dedup();
    places.len()
}

/// What was done is on disk a moment later.
fn until_it_moved(dir: &Path, run: &str) {
    until("the arm's movement on disk", || (places(dir, run) > 10).then_some(()));
}

#[test]
fn one_without_a_certificate_gets_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let address = cell(dir.path());
    let slave = Slave::start(dir.path(), "run");
    let mut roots = rustls::RootCertStore::empty();
    roots.add(CertificateDer::from_pem_file(dir.path().join("keys/authority.pem")).unwrap()).unwrap();
    let mut config = rustls::ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_protocol_versions(&[&rustls::version::TLS13])
        .unwrap()
        .with_root_certificates(roots)
        .with_no_client_auth();
    let mut answered = false;
    // the lanes that there are: another would be refused whatever is shown
    for lane in [format!("tetrad-motion/1.{VERSION}"), "tetrad-pictures/1".to_owned()] {
        config.alpn_protocols = vec![lane.into_bytes()];
        let client = quinn::ClientConfig::new(Arc::new(QuicClientConfig::try_from(config.clone()).unwrap()));
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let endpoint = quinn::Endpoint::client(SocketAddr::from(([127, 0, 0, 1], 0))).unwrap();
            // it may believe it is in until the slave has looked for its certificate
            let Ok(connection) = endpoint.connect_with(client, address, "slave").unwrap().await else {
                return;
            };
            if let Ok((mut to, mut from)) = connection.open_bi().await {
                let _ = to.write_all(&[0; 16]).await;
                answered |= matches!(from.read(&mut [0; 16]).await, Ok(Some(_)));
            }
            answered |= connection.accept_uni().await.is_ok();
        });
    }
    assert!(!answered, "something came back");
    slave.until_said("is refused: no certificate was shown");
    assert!(!slave.said().contains("is connected"), "{}", slave.said());
    assert!(places(dir.path(), "run") <= 1, "it moved");
}

/// Passes datagrams on between an operator and the slave, and keeps the operator's.
struct Tap {
    socket: UdpSocket,
    slave: SocketAddr,
    kept: Mutex<Vec<Vec<u8>>>,
    ended: AtomicBool,
}

impl Tap {
    fn pass_on(&self) {
        let mut operator = None;
        let mut buffer = [0; 2_048];
        while !self.ended.load(Ordering::Relaxed) {
            // nothing came for a while
            let Ok((length, from)) = self.socket.recv_from(&mut buffer) else { continue };
            let datagram = &buffer[..length];
            let to = if from == self.slave { operator } else { Some(self.slave) };
            if from != self.slave {
                operator = Some(from);
                self.kept.lock().unwrap().push(datagram.to_vec());
            }
            if let Some(to) = to {
                // as any wire may lose it
                let _ = self.socket.send_to(datagram, to);
            }
        }
    }
}

#[test]
fn a_recording_of_another_day_moves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let slave_at = cell(dir.path());
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(TICK)).unwrap();
    let tap = Tap { socket, slave: slave_at, kept: Mutex::default(), ended: AtomicBool::new(false) };
    let yesterday = Slave::start(dir.path(), "yesterday");
    std::thread::scope(|scope| {
        scope.spawn(|| tap.pass_on());
        drive(dir.path(), tap.socket.local_addr().unwrap());
        tap.ended.store(true, Ordering::Relaxed);
    });
    yesterday.until_said("operator is connected");
    // what is recorded moved the arm
    until_it_moved(dir.path(), "yesterday");
    drop(yesterday);

    let today = Slave::start(dir.path(), "today");
    let recorded = tap.kept.into_inner().unwrap();
    assert!(recorded.len() > 100, "{} datagrams", recorded.len());
    // from where they came before, and from elsewhere; all of it, again and again
    let elsewhere = UdpSocket::bind("127.0.0.1:0").unwrap();
    for _ in 0..3 {
        for datagram in &recorded {
            for socket in [&tap.socket, &elsewhere] {
                let _ = socket.send_to(datagram, slave_at);
            }
            std::thread::sleep(Duration::from_micros(200));
        }
    }
    // it cannot answer what it is asked: the keys of that day are gone
    today.until_said("is refused: no answer");
    assert!(!today.said().contains("is connected"), "{}", today.said());
    assert!(places(dir.path(), "today") <= 1, "it moved");
    // and the true one is let in
    drive(dir.path(), slave_at);
    until_it_moved(dir.path(), "today");
}

/// An operator that has the arm switched on and moves it, then ends.
fn drive(dir: &Path, slave_at: SocketAddr) {
    let identity = Identity::load(&dir.join("keys"), &"operator".parse().unwrap()).unwrap();
    let name: StationName = "slave".parse().unwrap();
    let peers = vec![PeerConfig { name: name.clone(), address: Some(slave_at.to_string()) }];
    let config = LinkConfig { listen: None, peers, picture_bytes_per_s: 1_000_000 };
    let link = Link::start(&config, &identity, Clock::wall()).unwrap();
    let slave = link.peer(&name).unwrap();
    let (mut motion, mut buttons) = (packets::motion(link.session(), 0), packets::buttons(link.session(), 0));
    let mut state = None;
    until("the arm follows", || {
        let heard = slave.arm_state().map(|state| state.what);
        state = heard.or(state.take());
        if let Some(state) = &state {
            match state.state {
                ArmState::Stopped if state.buttons_age_us.is_some() => buttons.resets = 1,
                ArmState::Armed => buttons.pressed = true,
                ArmState::Engaged => motion.since_engage.translation[0] += 0.001,
                _ => {}
            }
        }
        motion.sequence += 1;
        motion.capture_us += 16_667;
        buttons.sequence += 1;
        slave.send(&motion.into()).unwrap();
        slave.send(&buttons.into()).unwrap();
        (motion.since_engage.translation[0] > 0.05).then_some(())
    });
}
