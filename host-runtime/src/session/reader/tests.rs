use super::*;
use crate::pipeline::CameraStart;
use crate::session::schema::tetrad::Chain;
use crate::session::{CameraBeginning, Tape};
use crate::settings::Mode;
use std::fs;
use tetrad_core::config::FilterConfig;

fn beginning() -> Beginning {
    let camera = CameraBeginning {
        name: "left".to_owned(),
        source: "sim:still".to_owned(),
        pictures: None,
        start: CameraStart::anywhere([None; 4]),
        mode: Mode::Refined,
        rigid: true,
    };
    Beginning {
        chain: Chain::Pairs,
        mode: Mode::Refined,
        epoch_us: 5_000_000,
        arm_m: None,
        filter: FilterConfig::default(),
        cameras: vec![camera],
    }
}

/// A session of so many messages of 1 MB, two or three a chunk.
fn session(path: &Path, messages: u32) {
    let tape = Tape::start(path, &beginning().message()).unwrap();
    for at in 0..messages {
        tape.feed().put(Topic::Image(0), u64::from(at), at, |bytes| bytes.resize(1_000_000, at as u8));
    }
    tape.finish(BTreeMap::new()).unwrap();
}

/// How many messages can be read, and how it ended.
fn read(path: &Path) -> (u32, Result<bool, String>) {
    let mut reader = match Reader::open(path) {
        Ok(reader) => reader,
        Err(error) => return (0, Err(error.to_string())),
    };
    assert_eq!(reader.beginning(), &beginning());
    let mut count = 0;
    loop {
        match reader.next_entry() {
            Ok(Some(entry)) => {
                assert_eq!((entry.topic, entry.sequence), (Topic::Image(0), count), "none is skipped");
                assert!(entry.bytes.iter().all(|byte| u32::from(*byte) == count), "message {count}");
                count += 1;
            }
            Ok(None) => return (count, Ok(reader.cut())),
            Err(error) => return (count, Err(error.to_string())),
        }
    }
}

#[test]
fn a_file_that_was_cut_anywhere_is_read_as_far_as_it_goes() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    session(&path, 10);
    let whole = fs::read(&path).unwrap();
    assert_eq!(read(&path), (10, Ok(false)));
    let mut before = 0;
    for share in [0.2, 0.35, 0.5, 0.65, 0.8, 0.95] {
        fs::write(&path, &whole[..(whole.len() as f64 * share) as usize]).unwrap();
        let (count, ended) = read(&path);
        assert_eq!(ended, Ok(true), "{share}");
        assert!(count >= before && u64::from(count) <= (share * 10.0) as u64, "{count} at {share}");
        // at most the last chunk is lost
        assert!(f64::from(count) >= share * 10.0 - 4.0, "{count} at {share}");
        before = count;
    }
    for missing in [1, 8, 20, 100] {
        fs::write(&path, &whole[..whole.len() - missing]).unwrap();
        assert_eq!(read(&path).0, 10, "{missing} bytes of the summary are missing");
    }
}

#[test]
fn a_bit_that_flipped_is_noticed_and_nothing_of_its_chunk_handed_out() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    session(&path, 6);
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    fs::write(&path, bytes).unwrap();
    let (count, ended) = read(&path);
    assert!((1..4).contains(&count), "{count}");
    let said = ended.unwrap_err();
    assert!(said.contains("a.mcap: damaged at byte ") && said.contains("check sum"), "{said}");
}

/// A length that is wrong, or hostile, in a file that takes next to nothing on the disk.
#[test]
fn no_memory_is_asked_for_what_is_longer_than_anything_that_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    session(&path, 6);
    let mut bytes = fs::read(&path).unwrap();
    let mut chunks = Vec::new();
    let mut at = 8;
    while let Some((opcode, length)) = bytes.get(at).zip(bytes.get(at + 1..at + HEAD)) {
        if *opcode == op::CHUNK {
            chunks.push(at);
        }
        at += HEAD + u64::from_le_bytes(length.try_into().unwrap()) as usize;
    }
    let last = *chunks.last().unwrap();
    bytes.truncate(last + HEAD);
    let size = 3 << 30;
    for (length, ended) in [(1_u64 << 30, Err(())), (LONGEST_CHUNK + 1, Err(())), (1 << 40, Ok(true))] {
        bytes[last + 1..].copy_from_slice(&length.to_le_bytes());
        fs::write(&path, &bytes).unwrap();
        fs::File::options().write(true).open(&path).unwrap().set_len(size).unwrap();
        let (count, told) = read(&path);
        assert!((1..6).contains(&count), "{length}: {count}, {told:?}");
        if let Err(told) = &told {
            assert!(told.contains(&format!("a record of {length} bytes")), "{told}");
        }
        assert_eq!(told.map_err(|_| ()), ended, "{length}");
    }
}

#[test]
fn files_that_are_no_sessions_are_named_with_what_to_give_instead() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let said = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        read(&path).1.unwrap_err()
    };
    for nothing in [&b""[..], b"frame,t,u,v\n0,0,1,2\n", b"\x89MCAP"] {
        assert!(said(nothing).contains("a.mcap: no MCAP file"), "{}", said(nothing));
    }
    assert!(said(b"\x89MCAP0\r\n").contains("cut short before anything was recorded"));
    let mut foreign = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut foreign).unwrap();
    let channel = writer.add_channel(0, "/rosout", "json", &BTreeMap::new()).unwrap();
    let header =
        mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, b"{}").unwrap();
    writer.finish().unwrap();
    drop(writer);
    assert!(said(foreign.get_ref()).contains("of another program"), "{}", said(foreign.get_ref()));
    let missing = Reader::open(Path::new("/nowhere/a.mcap")).err().unwrap();
    assert_eq!(missing.to_string(), "cannot read /nowhere/a.mcap");
}

#[test]
fn no_single_byte_that_is_wrong_makes_the_reader_panic_or_never_end() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let tape = Tape::start(&path, &beginning().message()).unwrap();
    for at in 0..5 {
        tape.feed().put(Topic::Log, at, at as u32, |bytes| bytes.push(at as u8));
    }
    tape.finish(BTreeMap::new()).unwrap();
    let whole = fs::read(&path).unwrap();
    // beyond the descriptors, which are most of it, every byte; within them one in a hundred
    for at in (0..whole.len()).filter(|at| *at < 300 || *at + 600 > whole.len() || at % 100 == 0) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xff;
        let mut records = Records::new(bytes.as_slice(), bytes.len() as u64);
        let mut steps = 0;
        while let Ok(Some(_)) = records.next(&path) {
            steps += 1;
            assert!(steps < 1_000, "byte {at}");
        }
    }
}

#[test]
fn a_file_that_is_packed_says_how_it_is_unpacked() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let record = |opcode: u8, body: &[u8]| [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat();
    let chunk = [&[0; 28][..], &4u32.to_le_bytes(), b"zstd", &3u64.to_le_bytes(), &[1, 2, 3]].concat();
    let file = [b"\x89MCAP0\r\n".to_vec(), record(op::HEADER, &[0; 8]), record(op::CHUNK, &chunk)].concat();
    fs::write(&path, file).unwrap();
    let (count, ended) = read(&path);
    let told = ended.unwrap_err();
    assert_eq!(count, 0);
    let command = format!("mcap decompress {} -o", path.display());
    assert!(told.contains("compressed (zstd)") && told.contains(&command), "{told}");
}
