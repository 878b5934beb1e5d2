//! A line's bytes in the payloads of CAN FD.

/// The longest payload, bytes.
pub const LONGEST: usize = 64;

/// The lengths that a payload can have.
const LENGTHS: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, LONGEST];

/// One payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Payload {
    bytes: [u8; LONGEST],
    length: usize,
}

impl Payload {
    /// As many of `bytes` as go into one, and how many those are. The gap up to the next length that there
    /// is holds zero bytes: behind a whole frame of the line, which ends with one, they mean nothing.
    #[must_use]
    pub fn of(bytes: &[u8]) -> (Self, usize) {
        let taken = bytes.len().min(LONGEST);
        let length = LENGTHS.into_iter().find(|length| *length >= taken).unwrap_or(LONGEST);
        let mut payload = Self { bytes: [0; LONGEST], length };
        for (slot, byte) in payload.bytes.iter_mut().zip(bytes) {
            *slot = *byte;
        }
        (payload, taken)
    }

    /// Its bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::observation::{BALLS, Observation};
    use tetrad_core::wire::{
        Decoder, MAX_FRAME_LEN, Notice, NoticePacket, ObservationPacket, Packet, encode,
    };

    #[test]
    fn packets_come_out_as_they_went_in() {
        let notice = NoticePacket { camera: 1, session: 2, sequence: 3, answers: None, notice: Notice::Done };
        let observation = ObservationPacket {
            camera: 1,
            session: u32::MAX,
            sequence: u32::MAX,
            capture_us: u64::MAX,
            ready_us: 5,
            observed_us: 6,
            width: 320,
            height: 240,
            pixels_tested: 70_000,
            balls: [Observation::default(); BALLS],
        };
        let sent: [Packet; 3] = [notice.into(), observation.into(), notice.into()];
        let (mut decoder, mut received, mut longest) = (Decoder::new(), std::vec::Vec::new(), 0);
        for packet in &sent {
            let mut frame = [0; MAX_FRAME_LEN];
            let length = encode(packet, &mut frame).unwrap();
            longest = longest.max(length);
            let mut rest = &frame[..length];
            while !rest.is_empty() {
                let (payload, taken) = Payload::of(rest);
                rest = &rest[taken..];
                received.extend(decoder.packets(payload.bytes()).map(Result::unwrap));
            }
        }
        assert_eq!(received, sent);
        assert!(longest > LONGEST, "one packet goes into several payloads");
    }

    #[test]
    fn only_the_last_payload_of_a_frame_is_filled_up() {
        for length in 1..300 {
            let bytes = std::vec![7; length];
            let (mut rest, mut joined) = (&bytes[..], std::vec::Vec::new());
            while !rest.is_empty() {
                let (payload, taken) = Payload::of(rest);
                assert!(LENGTHS.contains(&payload.bytes().len()));
                rest = &rest[taken..];
                joined.extend_from_slice(payload.bytes());
            }
            let end = joined.split_off(length);
            assert!(joined == bytes && end.iter().all(|byte| *byte == 0), "{length}");
        }
    }
}
