//! The socket under QUIC: room for what comes while the computer is busy, and a filter before that room.
//!
//! Whoever floods the port with garbage does not have to get in to do harm: what waits before the socket
//! crowds out motion. So on Linux the kernel is told what cannot be ours, and drops it before it takes any
//! room or wakes anybody. Connection ids of this station all begin with the same four bytes, drawn anew at
//! each start: what is of a connection has them; what begins one says QUIC's version 1. What passes is
//! looked at by QUIC as ever: this keeps nobody out.

use quinn_proto::{ConnectionId, ConnectionIdGenerator, InvalidCid, RandomConnectionIdGenerator};
use socket2::Socket;
use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

/// Room for what has come and was not looked at, bytes: half a second of what comes at most (pictures of
/// 2.5 MB/s), as the kernel counts it, with its own for each packet.
pub const RECEIVE_BUFFER: usize = 2 * 1024 * 1024;

/// The bytes that all connection ids of a station begin with.
pub(super) type Mark = [u8; 4];

/// A socket that is bound, and the room it was given, bytes.
pub(super) fn bind(address: SocketAddr, mark: Mark) -> io::Result<(UdpSocket, usize)> {
    let socket = Socket::from(UdpSocket::bind(address)?);
    // Linux counts what it needs itself in as much again, here and in what it says it gives
    let doubled = if cfg!(target_os = "linux") { 2 } else { 1 };
    // less room, or no filter, is no reason to do without the link
    let _ = socket.set_recv_buffer_size(RECEIVE_BUFFER / doubled);
    let granted = socket.recv_buffer_size().unwrap_or(0);
    let _ = filter::attach(&socket, mark);
    Ok((socket.into(), granted))
}

/// Connection ids that begin with the mark, random from there on.
#[derive(Clone, Copy, Debug)]
pub(super) struct MarkedIds {
    mark: Mark,
    rest: RandomConnectionIdGenerator,
}

/// Of an id, behind the mark, bytes. What tells a station's connections apart has as many as it.
const REST: usize = 4;

impl MarkedIds {
    pub(super) fn new(mark: Mark) -> Self {
        Self { mark, rest: RandomConnectionIdGenerator::new(REST) }
    }
}

impl ConnectionIdGenerator for MarkedIds {
    fn generate_cid(&mut self) -> ConnectionId {
        ConnectionId::new(&[&self.mark[..], &self.rest.generate_cid()].concat())
    }

    fn validate(&self, id: &ConnectionId) -> Result<(), InvalidCid> {
        if id.starts_with(&self.mark) { Ok(()) } else { Err(InvalidCid) }
    }

    fn cid_len(&self) -> usize {
        self.mark.len() + REST
    }

    fn cid_lifetime(&self) -> Option<Duration> {
        None
    }
}

#[cfg(target_os = "linux")]
mod filter {
    //! A classic BPF program (Linux, Documentation/networking/filter.rst) in front of a UDP socket.

    use super::Mark;
    use socket2::{SockFilter, Socket};
    use std::io;

    /// Where the payload begins: the program sees the UDP header, eight bytes.
    const FIRST: u32 = 8;

    /// RFC 9000, section 17: the form of the header, and the bit that is set in every packet of ours.
    const LONG: u32 = 0x80;
    const FIXED: u32 = 0x40;

    /// RFC 9000, section 15.
    const VERSION: u32 = 1;

    /// All of a packet, or nothing of it.
    const KEEP: u32 = u32::MAX;
    const DROP: u32 = 0;

    pub(super) fn attach(socket: &Socket, mark: Mark) -> io::Result<()> {
        let byte = op(libc::BPF_LD | libc::BPF_B | libc::BPF_ABS);
        let word = op(libc::BPF_LD | libc::BPF_W | libc::BPF_ABS);
        let any_set = op(libc::BPF_JMP | libc::BPF_JSET | libc::BPF_K);
        let equal = op(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K);
        let end = op(libc::BPF_RET | libc::BPF_K);
        // jumps count the instructions that are left out; to load beyond the end drops the packet
        socket.attach_filter(&[
            SockFilter::new(byte, 0, 0, FIRST),
            SockFilter::new(any_set, 0, 2, LONG),
            // long: the version stands behind the first byte
            SockFilter::new(word, 0, 0, FIRST + 1),
            SockFilter::new(equal, 3, 4, VERSION),
            // short: the connection id does
            SockFilter::new(any_set, 0, 3, FIXED),
            SockFilter::new(word, 0, 0, FIRST + 1),
            SockFilter::new(equal, 0, 1, u32::from_be_bytes(mark)),
            SockFilter::new(end, 0, 0, KEEP),
            SockFilter::new(end, 0, 0, DROP),
        ])
    }

    fn op(code: u32) -> u16 {
        // the codes are below 256
        code as u16
    }
}

#[cfg(not(target_os = "linux"))]
mod filter {
    //! None elsewhere: QUIC drops what is not ours, a little later.

    use super::Mark;
    use socket2::Socket;
    use std::io;

    pub(super) fn attach(_: &Socket, _: Mark) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    const MARK: Mark = [0xDE, 0xAD, 0xBE, 0xEF];

    #[test]
    fn ids_have_the_mark_and_differ() {
        let mut ids = MarkedIds::new(MARK);
        let made: Vec<ConnectionId> = (0..100).map(|_| ids.generate_cid()).collect();
        assert!(made.iter().all(|id| id.len() == ids.cid_len() && ids.validate(id).is_ok()));
        assert!(made.windows(2).all(|pair| pair[0] != pair[1]));
        assert!(ids.validate(&ConnectionId::new(&[7; 8])).is_err());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn only_what_may_be_ours_comes_to_the_socket() {
        let here = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let (socket, granted) = bind(here, MARK).unwrap();
        assert!(granted > 0);
        socket.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let sender = UdpSocket::bind(here).unwrap();
        let target = socket.local_addr().unwrap();
        let ours = [
            &[0x40, 0xDE, 0xAD, 0xBE, 0xEF][..],
            &[0x7F, 0xDE, 0xAD, 0xBE, 0xEF, 1, 2, 3],
            &[0xC0, 0, 0, 0, 1],
            &[0xE3, 0, 0, 0, 1, 9, 9],
        ];
        let others = [
            &[][..],
            &[0x40],
            &[0x40, 0xDE, 0xAD, 0xBE],
            &[0x40, 0xDE, 0xAD, 0xBE, 0xEE],
            &[0x00, 0xDE, 0xAD, 0xBE, 0xEF],
            &[0xC0],
            &[0xC0, 0, 0, 0, 0],
            &[0xC0, 0xDE, 0xAD, 0xBE, 0xEF],
            &[0xFF; 1200],
        ];
        let mut bytes = [0; 1500];
        for datagram in ours {
            // loopback keeps the order: whatever comes first has passed
            for other in others {
                sender.send_to(other, target).unwrap();
            }
            sender.send_to(datagram, target).unwrap();
            let length = socket.recv(&mut bytes).unwrap();
            assert_eq!(&bytes[..length], datagram);
        }
    }
}
