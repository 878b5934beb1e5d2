//! Those who are not to be let in get nothing: no motion in, no picture out, and a line in the log.

use super::*;
use crate::link::authority::make_station_with;
use quinn::crypto::rustls::QuicClientConfig;
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::version::TLS13;

/// A client that shows another certificate, or none, and dials the slave at its best.
fn stranger(server_side: &Identity, shown: Option<&Identity>, alpn: Vec<u8>) -> ClientConfig {
    let builder = rustls::ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_protocol_versions(&[&TLS13])
        .unwrap()
        .with_root_certificates(server_side.authority.clone());
    let mut config = match shown {
        Some(identity) => builder
            .with_client_auth_cert(vec![identity.certificate.clone()], identity.key.clone_key())
            .unwrap(),
        None => builder.with_no_client_auth(),
    };
    config.alpn_protocols = vec![alpn];
    ClientConfig::new(Arc::new(QuicClientConfig::try_from(config).unwrap()))
}

/// Dials, and tries all that a peer could do. Whether anything came back on a stream or as a datagram.
async fn try_everything(client: ClientConfig, slave: SocketAddr) -> bool {
    let endpoint = Endpoint::client(SocketAddr::from((Ipv4Addr::LOCALHOST, 0))).unwrap();
    let Ok(connection) = endpoint.connect_with(client, slave, "slave").unwrap().await else { return false };
    // TLS 1.3: the client believes it is in until the server has looked at its certificate
    let session = 7;
    let hello = message::Message::Hello { session }.encode();
    let mut answered = false;
    if let Ok((mut to, mut from)) = connection.open_bi().await {
        let _ = to.write_all(&hello).await;
        for sequence in 0..20 {
            let _ = connection.send_datagram(body(&motion(session, sequence)).into());
        }
        let mut piece = [0; 64];
        answered = matches!(from.read(&mut piece).await, Ok(Some(_)));
    }
    let ended = connection.closed().await;
    assert!(!matches!(ended, quinn::ConnectionError::TimedOut), "the slave ends it at once");
    answered
}

fn runtime() -> Runtime {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap()
}

#[test]
fn strangers_get_nothing_and_are_told_of() {
    let ours = keys(&["operator", "slave", "mallory"]);
    let theirs = keys(&["operator"]);
    let own = identity(&ours, "slave");
    let (mallory, forged) = (identity(&ours, "mallory"), identity(&theirs, "operator"));
    for (who, shown, expected) in [
        ("no certificate", None, "no certificate was shown"),
        ("another name", Some(&mallory), "the certificate is not that of a configured peer"),
        ("another authority", Some(&forged), "the certificate is of another authority"),
    ] {
        for lane in Lane::ALL {
            // the same is told once a minute: a slave for each
            let slave = listener(&ours, "slave", &["operator"]);
            let to_operator = only_peer(&slave);
            let client = stranger(&own, shown, lane.alpn());
            assert!(!runtime().block_on(try_everything(client, slave.local_address())), "{who}");
            let event = wait_for(who, || next_event(&slave)).to_string();
            assert!(event.contains("is refused") && event.contains(expected), "{who}: {event}");
            let stats = to_operator.stats();
            assert_eq!((stats.connected, stats.heard_us, to_operator.motion()), (0, None, None));
            // and the right one is let in
            let operator = dialler(&ours, "operator", "slave", slave.local_address());
            connected(&operator);
        }
    }
}

#[test]
fn one_that_speaks_another_version_is_told_so() {
    let keys = keys(&["operator", "slave"]);
    let operator = identity(&keys, "operator");
    for alpn in [b"tetrad-motion/0.1".to_vec(), b"h3".to_vec()] {
        let slave = listener(&keys, "slave", &["operator"]);
        let client = stranger(&operator, Some(&operator), alpn);
        assert!(!runtime().block_on(try_everything(client, slave.local_address())));
        let event = wait_for("a line", || next_event(&slave)).to_string();
        assert!(event.contains("different versions"), "{event}");
    }
}

#[test]
fn a_station_does_not_talk_to_one_of_another_name_or_authority() {
    let ours = keys(&["operator", "slave", "camera"]);
    let theirs = keys(&["operator", "slave"]);
    let camera = listener(&ours, "camera", &["operator"]);
    let false_slave = listener(&theirs, "slave", &["operator"]);
    for (address, expected) in [
        (camera.local_address(), "not valid for name"),
        (false_slave.local_address(), "of another authority"),
    ] {
        let operator = dialler(&ours, "operator", "slave", address);
        let event = wait_for("a line", || next_event(&operator)).to_string();
        assert!(event.contains("slave is not reached at"), "{event}");
        assert!(event.contains(expected) || event.contains("not that of a configured peer"), "{event}");
        assert!(!only_peer(&operator).is_connected());
    }
    assert_eq!(only_peer(&camera).stats().connected, 0);
}

#[test]
fn a_session_is_one_stations() {
    let keys = keys(&["camera", "operator", "slave"]);
    let slave = listener(&keys, "slave", &["camera", "operator"]);
    let operator = dialler(&keys, "operator", "slave", slave.local_address());
    let to_operator = slave.peer(&name("operator")).unwrap();
    wait_for("the operator", || to_operator.is_connected().then_some(()));
    // the camera is one of the peers, and says it is of the operator's session
    let camera = identity(&keys, "camera");
    let client = stranger(&camera, Some(&camera), Lane::Motion.alpn());
    runtime().block_on(async {
        let endpoint = Endpoint::client(SocketAddr::from((Ipv4Addr::LOCALHOST, 0))).unwrap();
        let connection =
            endpoint.connect_with(client, slave.local_address(), "slave").unwrap().await.unwrap();
        let (mut to, _from) = connection.open_bi().await.unwrap();
        let hello = message::Message::Hello { session: operator.session() }.encode();
        to.write_all(&hello).await.unwrap();
        let ended = connection.closed().await;
        assert!(super::closing::in_words(&ended).contains("is another station's"), "{ended}");
    });
    assert!(to_operator.is_connected(), "the owner stays");
    let to_camera = slave.peer(&name("camera")).unwrap();
    assert_eq!(to_camera.stats().connected, 0);
}

#[test]
fn garbage_on_the_port_harms_nobody() {
    let keys = keys(&["operator", "slave"]);
    let slave = listener(&keys, "slave", &["operator"]);
    let operator = dialler(&keys, "operator", "slave", slave.local_address());
    let (to_slave, to_operator) = (connected(&operator), connected(&slave));
    let flood = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let mut next = 0;
    let mut noise = 1_u32;
    for round in 0..50 {
        for _ in 0..100 {
            let garbage: Vec<u8> = (0..1 + round * 25)
                .map(|_| {
                    noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (noise >> 24) as u8
                })
                .collect();
            let _ = flood.send_to(&garbage, slave.local_address());
            // a packet as it stands in a cable, but not in a connection
            let _ = flood.send_to(&body(&motion(operator.session(), 1_000_000)), slave.local_address());
        }
        let seen = pass_motion(&to_slave, operator.session(), &to_operator, &mut next);
        assert!(seen < 1_000_000);
    }
    assert_eq!(to_operator.stats().connected, 1);
    assert_eq!(to_operator.stats().received.no_packet, 0, "none of it came as far as the inbox");
}

/// One of the peers has gone mad, or fallen into wrong hands: it can send what it wants, and no more.
#[test]
fn nonsense_from_a_peer_ends_its_connection_alone() {
    let keys = keys(&["camera", "operator", "slave"]);
    let slave = listener(&keys, "slave", &["camera", "operator"]);
    let operator = dialler(&keys, "operator", "slave", slave.local_address());
    let to_operator = slave.peer(&name("operator")).unwrap();
    wait_for("the operator", || to_operator.is_connected().then_some(()));
    let camera = identity(&keys, "camera");
    let client = stranger(&camera, Some(&camera), Lane::Motion.alpn());
    let hello = message::Message::Hello { session: 1 }.encode();
    for nonsense in [vec![99], [&hello[..], &[99]].concat(), [&hello[..], &hello].concat()] {
        runtime().block_on(async {
            let endpoint = Endpoint::client(SocketAddr::from((Ipv4Addr::LOCALHOST, 0))).unwrap();
            let connection =
                endpoint.connect_with(client.clone(), slave.local_address(), "slave").unwrap().await.unwrap();
            let (mut to, _from) = connection.open_bi().await.unwrap();
            to.write_all(&nonsense).await.unwrap();
            let ended = connection.closed().await;
            assert!(super::closing::in_words(&ended).contains("makes no sense"), "{ended}");
        });
    }
    let mut next = 0;
    pass_motion(&only_peer(&operator), operator.session(), &to_operator, &mut next);
}

/// A peer whose certificate has had its day, made by somebody else than `tetrad keys`.
#[test]
fn a_certificate_of_another_day_is_told_as_that() {
    let keys = keys(&["operator", "slave"]);
    let old = name("camera");
    let files = make_station_with(keys.path(), &old, |params| {
        params.not_after = rcgen::date_time_ymd(2001, 1, 1);
    })
    .unwrap();
    let own = identity(&keys, "slave");
    let camera = Identity {
        name: old,
        certificate: CertificateDer::from_pem_file(files.certificate).unwrap(),
        key: PrivateKeyDer::from_pem_file(files.key).unwrap(),
        authority: own.authority.clone(),
    };
    let slave = listener(&keys, "slave", &["camera"]);
    let client = stranger(&own, Some(&camera), Lane::Motion.alpn());
    assert!(!runtime().block_on(try_everything(client, slave.local_address())));
    let event = wait_for("a line", || next_event(&slave)).to_string();
    assert!(event.contains("is refused") && event.contains("not valid on the day"), "{event}");
}
