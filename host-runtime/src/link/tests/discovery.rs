//! Stations that are found by multicast DNS, on loopback and on a port of its own.

use super::*;
use crate::link::discovery::Scope;
use std::net::UdpSocket;

/// Whether this computer's loopback carries multicast, which some containers' does not.
fn multicast() -> bool {
    let group = Ipv4Addr::new(224, 0, 0, 251);
    let heard = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).and_then(|socket| {
        socket.join_multicast_v4(&group, &Ipv4Addr::LOCALHOST)?;
        socket.set_read_timeout(Some(Duration::from_secs(2)))?;
        let from = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
        from.send_to(b"here", (group, socket.local_addr()?.port()))?;
        socket.recv(&mut [0; 8])
    });
    heard.is_ok()
}

fn free_port() -> u16 {
    UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).and_then(|socket| socket.local_addr()).unwrap().port()
}

fn sought(peer: &str) -> LinkConfig {
    let peers = vec![PeerConfig { name: name(peer), address: Some(MDNS.to_owned()) }];
    LinkConfig { listen: None, peers, picture_bytes_per_s: PICTURE_BYTES_PER_S }
}

#[test]
fn a_station_is_found_where_it_announces_itself_and_known_by_its_certificate_alone() {
    if !multicast() {
        tetrad_tests::skip("link::tests::discovery", "no multicast on loopback");
        return;
    }
    let scope = Scope::Loopback(free_port());
    let (ours, theirs) = (keys(&["operator", "slave"]), keys(&["slave", "operator"]));
    let config = sought("slave");
    let looks = Discovery::start(config.sought(), scope).unwrap();
    let operator =
        Link::start_with(&config, &identity(&ours, "operator"), Clock::wall(), Some(looks)).unwrap();
    let unknown = wait_for("that it is not known", || operator.events().pop());
    assert!(unknown.to_string().contains("nobody on this network has announced it"), "{unknown}");

    // somebody with a certificate of his own authority is there first, under the slave's name
    let impostor = listener(&theirs, "slave", &["operator"]);
    let lies = Discovery::start([], scope).unwrap();
    lies.announce(&name("slave"), impostor.local_address()).unwrap();
    let refused = wait_for("the impostor", || operator.events().pop());
    let refused = refused.to_string();
    assert!(refused.contains("slave is not reached at mdns") && !refused.contains("announced"), "{refused}");
    assert!(!only_peer(&operator).is_connected());

    let listen = Some(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
    let peers = vec![PeerConfig { name: name("operator"), address: None }];
    let config = LinkConfig { listen, peers, picture_bytes_per_s: PICTURE_BYTES_PER_S };
    let tells = Discovery::start([], scope).unwrap();
    let slave = Link::start_with(&config, &identity(&ours, "slave"), Clock::wall(), Some(tells)).unwrap();
    slave.announce().unwrap();
    let (to_slave, to_operator) = (connected(&operator), connected(&slave));
    assert_eq!(to_slave.stats().address, Some(slave.local_address()));
    pass_motion(&to_slave, operator.session(), &to_operator, &mut 0);
    assert!(!only_peer(&impostor).is_connected());
}
