//! Any bytes from a peer of the link: as its stream in pieces of any size, as a picture, as a slave's
//! word on itself, as datagrams.
//! Refused with a reason, or taken as what was sent; what the inbox lets through is only ever newer.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tetrad::link::inbox::Inbox;
use tetrad::link::message::{Message, MessageError, Reader};
use tetrad::link::picture::Picture;
use tetrad::station::SlaveAnnouncement;

fn messages<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> (Vec<Message>, Option<MessageError>) {
    let mut reader = Reader::default();
    let mut messages = Vec::new();
    for piece in pieces {
        reader.feed(piece);
        loop {
            match reader.message() {
                Ok(Some(message)) => messages.push(message),
                Ok(None) => break,
                Err(refused) => return (messages, Some(refused)),
            }
        }
    }
    (messages, None)
}

fuzz_target!(|input: (u8, u32, &[u8])| {
    let (piece, session, data) = input;
    let piece = usize::from(piece).max(1);
    let at_once = messages([data].into_iter());
    assert_eq!(messages(data.chunks(piece)), at_once);
    let again: Vec<u8> = at_once.0.iter().flat_map(Message::encode).collect();
    assert!(data.starts_with(&again), "what was read is what was sent");

    if let Ok(picture) = Picture::decode(data) {
        assert_eq!(picture.encode().as_deref(), Ok(data));
    }

    if let Ok(slave) = SlaveAnnouncement::decode(data) {
        assert_eq!(slave.station, "slave");
        assert!(slave.encode().is_ok_and(|again| SlaveAnnouncement::decode(&again).is_ok()));
    }

    let mut inbox = Inbox::default();
    inbox.begin(session).expect("no session has ended");
    let mut newest = None;
    for (at_us, datagram) in (0..).zip(data.chunks(piece)) {
        if inbox.take(datagram, at_us).is_ok()
            && let Some(motion) = inbox.motion()
        {
            assert_eq!(motion.what.session, session);
            let ahead = newest.map(|newest| motion.what.sequence.wrapping_sub(newest));
            assert!(ahead.is_none_or(|ahead| ahead != 0 && ahead <= u32::MAX / 2));
            newest = Some(motion.what.sequence);
        }
    }
});
