//! The same packets for two lines.

use crate::handover::Packets;

/// Hands on every packet to both. The first is waited for; the second, where nobody may listen, misses what
/// comes while its channel is full. Ends behind the last packet of a recording.
pub async fn share(packets: &Packets, waited_for: &Packets, may_miss: &Packets) {
    loop {
        let packet = packets.receive().await;
        // what it misses is missed: whoever listens sees by the packets' numbers that one is not there
        let _ = may_miss.try_send(packet);
        waited_for.send(packet).await;
        if packet.is_none() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};
    use tetrad_core::wire::{Notice, NoticePacket};

    #[test]
    fn a_line_where_nobody_listens_holds_nothing_up() {
        let [packets, first, second] = [const { Packets::new() }; 3];
        let mut sharing = pin!(share(&packets, &first, &second));
        let mut run = || sharing.as_mut().poll(&mut Context::from_waker(Waker::noop()));
        let numbered = |sequence| {
            let notice = Notice::Done;
            Some(NoticePacket { camera: 0, session: 1, sequence, answers: None, notice }.into())
        };
        for sequence in 0..20 {
            assert!(packets.try_send(numbered(sequence)).is_ok(), "packet {sequence} waits");
            assert_eq!(run(), Poll::Pending);
            assert_eq!(first.try_receive().ok(), Some(numbered(sequence)));
        }
        // it has the oldest ones, and then those that came after it was listened to
        assert_eq!(second.try_receive().ok(), Some(numbered(0)));
        assert!(packets.try_send(None).is_ok());
        assert_eq!(run(), Poll::Ready(()));
        let rest: std::vec::Vec<_> = core::iter::from_fn(|| second.try_receive().ok()).collect();
        assert_eq!(rest, [numbered(1), numbered(2), numbered(3), None]);
    }
}
