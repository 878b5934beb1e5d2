//! Packets to a line's bytes.

use crate::handover::Packets;
use embedded_io_async::Write;
use tetrad_core::wire::{MAX_FRAME_LEN, encode};

/// Writes every packet as one frame, behind a zero byte, so that noise before it costs nothing. Ends when
/// the last packet of a recording is on the line.
///
/// # Errors
/// The line's.
pub async fn send<W: Write>(mut line: W, packets: &Packets) -> Result<(), W::Error> {
    line.write_all(&[0]).await?;
    let mut frame = [0; MAX_FRAME_LEN];
    while let Some(packet) = packets.receive().await {
        // what is not finite is not sent: no packet of a camera can be so
        let length = encode(&packet, &mut frame).unwrap_or_default();
        line.write_all(frame.get(..length).unwrap_or_default()).await?;
    }
    line.flush().await
}
