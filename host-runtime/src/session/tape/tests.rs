use super::*;
use crate::session::schema::tetrad::Taught;
use crate::session::{Beginning, Reader};
use crate::settings::Mode;
use std::time::{Duration, Instant};
use tetrad_core::config::FilterConfig;

fn configuration() -> Configuration {
    let camera = crate::session::CameraBeginning {
        name: "left".to_owned(),
        source: "sim:still".to_owned(),
        pictures: None,
        start: crate::pipeline::CameraStart::anywhere([None; 4]),
        mode: Mode::Refined,
        rigid: true,
    };
    let beginning = Beginning {
        chain: crate::session::schema::tetrad::Chain::Pairs,
        mode: Mode::Refined,
        epoch_us: 1_000_000,
        arm_m: None,
        filter: FilterConfig::default(),
        cameras: vec![camera],
    };
    beginning.message()
}

fn entries(path: &Path) -> (Vec<(Topic, u64, u32, usize)>, Reader) {
    let mut reader = Reader::open(path).unwrap();
    let mut all = Vec::new();
    while let Some(entry) = reader.next_entry().unwrap() {
        all.push((entry.topic, entry.time_us, entry.sequence, entry.bytes.len()));
    }
    (all, reader)
}

#[test]
fn what_was_handed_in_is_in_the_file_in_order() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let tape = Tape::start(&path, &configuration()).unwrap();
    for at in 0..5u32 {
        let fill = |bytes: &mut Vec<u8>| bytes.resize(1 + at as usize, 7);
        assert!(tape.feed().put(Topic::Image(0), u64::from(at) * 10, at, fill));
    }
    tape.feed().log(60, Level::Warning, "the light went out");
    let recorded = tape.finish(BTreeMap::from([("steps".to_owned(), "5".to_owned())])).unwrap();
    assert_eq!((recorded.written.messages, recorded.left_out.len()), (7, 0));
    assert_eq!(recorded.written.bytes, std::fs::metadata(&path).unwrap().len());
    let (all, reader) = entries(&path);
    let images: Vec<_> = all.iter().filter(|entry| entry.0 == Topic::Image(0)).collect();
    assert_eq!(images.len(), 5);
    assert_eq!(*images[4], (Topic::Image(0), 40, 4, 5));
    assert_eq!(all.last().unwrap().0, Topic::Log);
    assert!(!reader.cut());
    assert_eq!(reader.end().unwrap().get("steps").map(String::as_str), Some("5"));
}

#[test]
fn who_must_not_wait_never_does_and_what_is_left_out_is_counted_and_written() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let tape = Tape::bounded(&path, &configuration(), 10).unwrap();
    let feed = tape.feed().clone();
    // while the lock is held the writer's thread can take nothing out
    let mut taken = 0;
    {
        let mut state = feed.lock();
        state.bytes = 10;
        drop(state);
        for at in 0..3 {
            taken += u32::from(feed.offer(Topic::Image(0), at, 0, |bytes| bytes.push(1)));
        }
    }
    assert_eq!((taken, tape.left_out(), tape.has_failed()), (0, 3, false));
    // what the rest hangs on is taken all the same
    feed.insist(Topic::Taught(0), 8, 9, &Taught { frame: 9, ..Taught::default() });
    feed.lock().bytes = 0;
    assert!(feed.offer(Topic::Image(0), 9, 9, |bytes| bytes.push(1)));
    let recorded = tape.finish(BTreeMap::new()).unwrap();
    assert_eq!(recorded.left_out, BTreeMap::from([("/left/image".to_owned(), 3)]));
    let (all, reader) = entries(&path);
    assert_eq!(all, [(Topic::Taught(0), 8, 9, 2), (Topic::Image(0), 9, 9, 1)]);
    assert_eq!(reader.end().unwrap().get("left out /left/image").map(String::as_str), Some("3"));
}

#[test]
fn who_may_wait_loses_nothing_though_little_fits() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let tape = Tape::bounded(&path, &configuration(), 1).unwrap();
    for at in 0..200 {
        assert!(tape.feed().put(Topic::Image(0), at, at as u32, |bytes| bytes.resize(1000, 3)));
    }
    assert!(tape.finish(BTreeMap::new()).unwrap().left_out.is_empty());
    assert_eq!(entries(&path).0.len(), 200);
}

#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_is_full_ends_the_recording_and_is_told() {
    // what is handed to it now or after the first chunk fails
    let Ok(tape) = Tape::start(Path::new("/dev/full"), &configuration()) else { return };
    let began = Instant::now();
    while tape.feed().put(Topic::Image(0), 0, 0, |bytes| bytes.resize(1 << 20, 0)) {
        assert!(began.elapsed() < Duration::from_secs(60), "writing to a full disk never failed");
    }
    assert!(tape.has_failed());
    let error = tape.finish(BTreeMap::new()).unwrap_err();
    assert_eq!(error.to_string(), "cannot write /dev/full");
    assert!(std::error::Error::source(&error).unwrap().to_string().contains("No space left"), "{error:?}");
}
