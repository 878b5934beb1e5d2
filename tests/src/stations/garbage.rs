//! Datagrams that nobody asked for, as fast as they go.

use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};

/// The longest.
const LONGEST: usize = 1_200;

/// So much of each is drawn anew, bytes: a datagram is judged by its head.
const HEAD: usize = 64;

/// Sends so many, unless it is ended before; how many went.
///
/// # Errors
/// There is no socket.
pub(super) fn send(target: SocketAddr, count: u64, ended: &AtomicBool) -> Result<u64, String> {
    let socket = UdpSocket::bind("127.0.0.1:0").map_err(|error| error.to_string())?;
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut datagram = [0_u8; LONGEST];
    let mut sent = 0;
    while sent < count && !ended.load(Ordering::Relaxed) {
        // xorshift
        for chunk in datagram[..HEAD].chunks_mut(8) {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            chunk.copy_from_slice(&state.to_le_bytes());
        }
        let length = 1 + (state % LONGEST as u64) as usize;
        // a full buffer is the receiver's matter
        sent += u64::from(socket.send_to(&datagram[..length], target).is_ok());
    }
    Ok(sent)
}
