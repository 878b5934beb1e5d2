//! Promise: fuzzing begins with packets that are accepted. What was written for another version of the wire is refused at
//! its first byte, and the fuzzer would go on without anything to vary.

use std::fs;
use tetrad::station::SlaveAnnouncement;
use tetrad_core::wire::{Decoder, Packet, decode_body};

/// A seed without what the target takes before its data: so many bytes.
fn seed(path: &str, before: usize) -> Vec<u8> {
    let file = tetrad_tests::repository().join("fuzz/seeds").join(path);
    let bytes = fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    bytes[before..].to_vec()
}

/// Of `packet`: the length of its pieces. Of `link`: a session too. Of `node`: baud rate, clock and step.
const OF_PACKET: usize = 1;
const OF_LINK: usize = 5;
const OF_NODE: usize = 17;

#[test]
fn every_packet_among_the_seeds_is_accepted() {
    for kind in [
        "observation",
        "motion",
        "arm-state",
        "buttons",
        "command",
        "notice",
        "preview",
        "shown-strip",
        "shown-look",
    ] {
        let body = seed(&format!("packet/{kind}-body"), OF_PACKET);
        assert!(decode_body(&body).is_ok(), "{kind}: {:?}", decode_body(&body));
    }
    for kind in ["observation", "arm-state", "buttons"] {
        let body = seed(&format!("link/{kind}"), OF_LINK);
        assert!(decode_body(&body).is_ok(), "{kind}: {:?}", decode_body(&body));
    }
    let twice = seed("link/motion-twice", OF_LINK);
    let (one, other) = twice.split_at(twice.len() / 2);
    assert_eq!(one, other);
    assert!(matches!(decode_body(one), Ok(Packet::Motion(_))));
    let announcement = seed("link/announcement", OF_LINK);
    assert!(SlaveAnnouncement::decode(&announcement).is_ok());
}

#[test]
fn every_frame_among_the_seeds_is_found() {
    for (path, before, frames) in [
        ("packet/two-frames", OF_PACKET, 2),
        ("node/two-frames", OF_NODE, 2),
        ("node/noise-between", OF_NODE, 2),
        ("node/thumbnail", OF_NODE, 4),
    ] {
        let found = Decoder::new().packets(&seed(path, before)).filter(Result::is_ok).count();
        assert_eq!(found, frames, "{path}");
    }
}

/// A seed that nobody looks at here is none of packets.
#[test]
fn no_seed_of_packets_is_left_out() {
    for (target, known) in [("packet", 10), ("node", 3), ("link", 7)] {
        let folder = tetrad_tests::repository().join("fuzz/seeds").join(target);
        let seeds = fs::read_dir(&folder).expect("the seeds").count();
        assert_eq!(seeds, known, "{}: a new seed needs a line in this file", folder.display());
    }
}
