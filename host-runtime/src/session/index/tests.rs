use super::*;
use crate::session::moments;
use crate::session::testing::{BEGAN_US, PERIOD_US, SIZE, small};
use tetrad_core::vision::frame::Rgb;

/// More than three chunks of them.
const PICTURES: u32 = 40;

fn path(dir: &tempfile::TempDir) -> PathBuf {
    dir.path().join("a.mcap")
}

/// The shade of the picture at that time.
fn shade(lookup: &mut Lookup, time_us: u64) -> Option<u8> {
    let pixel = lookup.picture(0, time_us, |view| view.pixel(i32::from(SIZE.0) - 1, 3).unwrap()).unwrap()?;
    assert_eq!(pixel, Rgb::new(pixel.r, pixel.r, pixel.r));
    Some(pixel.r)
}

#[test]
fn every_moment_is_found_with_what_was_known_then() {
    let dir = tempfile::tempdir().unwrap();
    small(&path(&dir), PICTURES);
    let mut lookup = Lookup::open(&path(&dir)).unwrap();
    let index = lookup.index();
    assert!(!index.cut() && index.chunks.len() > 3, "{} chunks", index.chunks.len());
    assert_eq!(moments(index).len(), PICTURES as usize);
    let last_us = BEGAN_US + u64::from(PICTURES - 1) * PERIOD_US;
    assert_eq!(index.span_us(), Some((BEGAN_US, last_us + 2)));
    // backwards too, and again: what was read is not what is asked for next
    for at in (0..PICTURES).rev().chain(0..PICTURES).step_by(3) {
        let time_us = BEGAN_US + u64::from(at) * PERIOD_US + PERIOD_US / 2;
        assert_eq!(shade(&mut lookup, time_us), Some(at as u8));
        let moment = lookup.moment(time_us).unwrap();
        let picture_us = BEGAN_US + u64::from(at) * PERIOD_US;
        let [left, afar] = moment.cameras.as_slice() else { panic!("{moment:?}") };
        assert_eq!((left.picture_us, afar.picture_us), (Some(picture_us), None));
        let red = |seen: &Option<(u64, _)>| {
            let (time_us, balls): &(u64, tetrad_core::observation::Observations) = seen.as_ref().unwrap();
            (*time_us, balls[0].centre.u as u32)
        };
        assert_eq!((red(&left.seen), red(&afar.seen)), ((picture_us, at), (picture_us + 1, at)));
        let pose = moment.hand.unwrap().pose.unwrap();
        assert!((pose.translation.x - at as f32 * 1e-3).abs() < 1e-6);
        assert_eq!(moment.arm.map(|(_, arm)| arm.slowed.len()), (at >= 2).then_some(2));
        assert_eq!(moment.lines.last().unwrap().1, format!("line {at}"));
        assert!(moment.lines.len() <= 5);
    }
    let before = lookup.moment(BEGAN_US - 1).unwrap();
    assert!(before.hand.is_none() && before.cameras[0].seen.is_none() && before.lines.is_empty());
    assert_eq!(shade(&mut lookup, BEGAN_US - 1), None);
    assert_eq!(lookup.picture(7, last_us, |_| ()).unwrap(), None);
}

#[test]
fn a_file_without_an_end_is_looked_at_as_far_as_it_goes() {
    let dir = tempfile::tempdir().unwrap();
    small(&path(&dir), PICTURES);
    let whole = std::fs::read(path(&dir)).unwrap();
    let mut counts = Vec::new();
    for part in [whole.len() - 3, whole.len() * 2 / 3, whole.len() / 3, 9_000] {
        std::fs::write(path(&dir), &whole[..part]).unwrap();
        let Ok(mut lookup) = Lookup::open(&path(&dir)) else {
            counts.push(0);
            continue;
        };
        let count = lookup.index().of(Topic::Image(0)).len();
        counts.push(count);
        assert_eq!(lookup.index().cut(), part < whole.len() - 3);
        if count > 0 {
            assert_eq!(shade(&mut lookup, u64::MAX), Some(count as u8 - 1));
        }
    }
    assert_eq!(counts[0], PICTURES as usize, "what is after the last message is not needed");
    assert!(counts.windows(2).all(|pair| pair[1] < pair[0]), "{counts:?}");
}

#[test]
fn what_is_damaged_is_not_shown_and_the_rest_is() {
    let dir = tempfile::tempdir().unwrap();
    small(&path(&dir), PICTURES);
    let mut bytes = std::fs::read(path(&dir)).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(path(&dir), bytes).unwrap();
    let mut lookup = Lookup::open(&path(&dir)).unwrap();
    let mut damaged = 0;
    for at in 0..PICTURES {
        match lookup.moment(BEGAN_US + u64::from(at) * PERIOD_US) {
            Ok(moment) => assert_eq!(moment.lines.last().unwrap().1, format!("line {at}")),
            Err(error) => {
                assert!(error.to_string().contains("check sum"), "{error}");
                damaged += 1;
            }
        }
    }
    assert!((1..PICTURES / 2).contains(&damaged), "{damaged}");
}

/// A list of messages may say anything.
#[test]
fn lists_that_lie_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    small(&path(&dir), 3);
    let whole = std::fs::read(path(&dir)).unwrap();
    let reader = Reader::open(&path(&dir)).unwrap();
    let lookup = |bytes: &[u8]| Lookup::of(&reader, std::io::Cursor::new(bytes.to_vec()), bytes.len() as u64);
    let sound = lookup(&whole).unwrap();
    let spot = sound.index().of(Topic::Image(0))[1];
    // the list's entry: the time in nanoseconds, then the place
    let time_ns = (spot.time_us + 5_000_000) * 1_000;
    let entry = [time_ns.to_le_bytes(), u64::from(spot.offset).to_le_bytes()].concat();
    let found = whole.windows(entry.len()).position(|window| window == entry).unwrap();
    for offset in [0, u64::from(spot.offset) + 1, u64::from(u32::MAX), u64::MAX] {
        let mut bytes = whole.clone();
        bytes[found + 8..found + 16].copy_from_slice(&offset.to_le_bytes());
        let mut lying = lookup(&bytes).unwrap();
        let spots = lying.index().of(Topic::Image(0)).to_vec();
        let read = spots.iter().map(|spot| lying.message::<super::super::schema::foxglove::RawImage>(*spot));
        let sound = read.filter(Result::is_ok).count();
        assert_eq!(sound, 2, "at {offset}");
    }
}
