use super::*;
use crate::station::node::tests::{frame, packet};
use proptest::prelude::*;
use std::path::PathBuf;

const USB: Line = Line { byte_us: 0.0 };

fn take(receiver: &mut Receiver, bytes: &[u8], now_us: u64) -> Option<Received<ObservationPacket>> {
    receiver.take(bytes, USB, now_us)
}

fn sequence(came: Option<Received<ObservationPacket>>) -> Option<u32> {
    came.map(|came| came.what.sequence)
}

#[test]
fn split_and_joined_frames_are_the_same_packets() {
    let mut receiver = Receiver::default();
    receiver.open();
    let all: Vec<u8> = (0..6).flat_map(|sequence| frame(&packet(7, sequence, 100))).collect();
    let (one, rest) = all.split_at(10);
    assert_eq!(sequence(take(&mut receiver, one, 1)), None);
    let length = all.len() / 6;
    assert_eq!(sequence(take(&mut receiver, &rest[..length], 2)), Some(0));
    assert_eq!(sequence(take(&mut receiver, &rest[length..], 3)), Some(5), "the newest of what came at once");
    assert_eq!(receiver.counts(), NodeCounts { taken: 6, ..NodeCounts::default() });
}

#[test]
fn garbage_is_counted_and_what_is_behind_it_comes() {
    let mut receiver = Receiver::default();
    receiver.open();
    let good = frame(&packet(7, 0, 100));
    // the port was opened within a frame
    assert_eq!(sequence(take(&mut receiver, &good[good.len() / 2..], 1)), None);
    assert_eq!(receiver.counts().damaged, 0);
    assert_eq!(sequence(take(&mut receiver, &good, 2)), Some(0));
    let mut damaged = frame(&packet(7, 1, 100));
    damaged[20] ^= 0x10;
    assert_eq!(sequence(take(&mut receiver, &damaged, 3)), None);
    assert_eq!(sequence(take(&mut receiver, &[0xA5; 2_000], 4)), None);
    assert_eq!(sequence(take(&mut receiver, &[0, 0, 0], 5)), None);
    assert_eq!(sequence(take(&mut receiver, &frame(&packet(7, 4, 100)), 6)), Some(4));
    let expected = NodeCounts { taken: 2, lost: 3, damaged: 2, other: 0 };
    assert_eq!(receiver.counts(), expected);
}

#[test]
fn a_node_that_begins_anew_is_believed_at_its_second_packet() {
    let mut receiver = Receiver::default();
    receiver.open();
    let mut came = |session, number| sequence(take(&mut receiver, &frame(&packet(session, number, 100)), 9));
    assert_eq!(came(7, 500), Some(500), "the first that is heard of");
    assert_eq!(came(8, 3), None, "one alone may be damage");
    assert_eq!(came(7, 501), Some(501));
    assert_eq!(came(7, 501), None, "twice");
    assert_eq!(came(7, 499), None, "older");
    assert_eq!(came(8, 0), None);
    assert_eq!(came(8, 1), Some(1), "its numbers begin anew");
    assert_eq!(came(8, 2), Some(2));
    assert_eq!(receiver.counts(), NodeCounts { taken: 4, lost: 0, damaged: 0, other: 4 });
}

#[test]
fn another_version_is_told_once() {
    let mut receiver = Receiver::default();
    receiver.open();
    // version 9, kind 1, and the check of these two bytes: CRC-16/IBM-3740, then COBS
    let check = crc_16(&[9, 1]).to_le_bytes();
    let frame = [5, 9, 1, check[0], check[1], 0];
    assert!(!check.contains(&0), "else the stuffing would be another");
    take(&mut receiver, &[frame, frame].concat(), 1);
    let notice = receiver.take_notice().unwrap();
    assert!(notice.contains("version 9"), "{notice}");
    take(&mut receiver, &frame, 2);
    assert_eq!((receiver.take_notice(), receiver.counts().damaged), (None, 3));
}

fn crc_16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ (u16::from(*byte) << 8), |crc, _| {
            if crc & 0x8000 == 0 { crc << 1 } else { (crc << 1) ^ 0x1021 }
        })
    })
}

/// A node whose clock is an hour off and parts by 100 ppm, packets up to 20 ms late.
#[test]
fn capture_times_are_told_by_the_packets_that_were_held_up_least() {
    let mut receiver = Receiver::default();
    receiver.open();
    let (mut worst_us, mut draws) = (0, 1_u64);
    for number in 0..3_000_u32 {
        let captured_us = u64::from(number) * 10_000;
        draws = draws.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let late_us = (draws >> 33) % 20_000;
        let theirs_us = 3_600_000_000 + captured_us - captured_us / 10_000;
        let bytes = frame(&packet(7, number, theirs_us));
        let now_us = captured_us + 4_000 + late_us;
        let came = take(&mut receiver, &bytes, now_us).unwrap();
        assert_eq!(came.received_us, now_us);
        let error_us = came.captured_us.unwrap().abs_diff(captured_us);
        if number > 100 {
            worst_us = worst_us.max(error_us);
        }
    }
    // the window of 5 s lets 0.5 ms part; 50 packets have one within about a millisecond of the quickest
    assert!(worst_us < 2_000, "{worst_us}");
}

#[test]
fn the_time_on_the_wire_is_known_where_there_is_a_wire() {
    let line = |device: &str, baud| Line::of(&PathBuf::from(device), baud).byte_us;
    assert_eq!((line("/dev/ttyACM7", 115_200), line("/dev/pts/3", 9_600)), (0.0, 0.0));
    assert!((line("/dev/ttyUSB7", 1_000_000) - 10.0).abs() < 1e-9);
    let mut receiver = Receiver::default();
    receiver.open();
    let bytes = frame(&packet(7, 0, 50_000));
    let wire_us = 10 * bytes.len() as u64;
    let came = receiver.take(&bytes, Line { byte_us: 10.0 }, 90_000).unwrap();
    // made 3 ms after the exposure, then on the wire
    assert_eq!(came.captured_us, Some(90_000 - wire_us - 3_000));
}

/// An hour of packets with as much noise between them, a megabyte of it at once as well.
#[test]
fn memory_does_not_grow_with_what_comes() {
    let mut receiver = Receiver::default();
    receiver.open();
    let noise: Vec<u8> = (0..1_000_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    take(&mut receiver, &noise, 0);
    for number in 0..40_000_u32 {
        let at_us = u64::from(number) * 90_000;
        let from = number as usize * 13;
        take(&mut receiver, &noise[from..from + 100], at_us);
        take(&mut receiver, &[&[0], &frame(&packet(7, number, at_us))[..]].concat(), at_us);
    }
    assert_eq!(receiver.counts().taken, 40_000);
    assert!(receiver.counts().damaged > 10_000, "{:?}", receiver.counts());
    assert!(receiver.lateness.stretches.capacity() <= 4 * STRETCHES);
}

proptest! {
    /// However the line is cut into reads, and whatever lies between the packets, the same comes of it.
    #[test]
    fn where_reads_end_changes_nothing(
        garbage in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..40), 8),
        cuts in prop::collection::vec(1_usize..200, 1..80),
    ) {
        let mut stream = Vec::new();
        for (sequence, garbage) in (0..).zip(&garbage) {
            stream.extend_from_slice(garbage);
            // so that it costs no packet
            stream.push(0);
            stream.extend(frame(&packet(7, sequence, 100)));
        }
        let mut whole = Receiver::default();
        whole.open();
        let newest = take(&mut whole, &stream, 1);
        prop_assert_eq!(sequence(newest), Some(7));
        prop_assert_eq!(whole.counts().taken, 8);
        let mut cut = Receiver::default();
        cut.open();
        let (mut rest, mut came) = (&stream[..], 0);
        for length in cuts.iter().cycle() {
            let (read, behind) = rest.split_at(rest.len().min(*length));
            came += u32::from(take(&mut cut, read, 1).is_some());
            rest = behind;
            if rest.is_empty() {
                break;
            }
        }
        prop_assert!((1..=8).contains(&came));
        prop_assert_eq!(cut.counts(), whole.counts());
    }
}
