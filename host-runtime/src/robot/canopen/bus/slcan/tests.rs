use super::*;

fn decoded(bytes: &[u8]) -> Vec<Line> {
    let mut decoder = Decoder::default();
    bytes.iter().filter_map(|byte| decoder.push(*byte)).collect()
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).unwrap()
}

#[test]
fn a_frame_is_the_line_that_python_can_writes() {
    let mut line = Vec::new();
    encode(&frame(0x205, &[0x0F, 0x00]), &mut line);
    assert_eq!(line, b"t20520F00\r");
}

#[test]
fn lines_come_back_as_frames_in_any_pieces() {
    let frames = [frame(0x080, &[]), frame(0x7FF, &[0xFF; 8]), frame(0x181, &[0x37, 0x02, 1, 2, 3, 4])];
    let mut line = Vec::new();
    for frame in &frames {
        encode(frame, &mut line);
    }
    assert_eq!(decoded(&line), frames.map(Line::Frame));
}

#[test]
fn what_adapters_say_beside_frames_is_passed_over() {
    let mut lines = decoded(b"\rz\r\x07V1013\rt08001A2B\rT000001238\rt1");
    assert_eq!(lines.remove(4), Line::Other);
    assert_eq!(lines, [Line::Other, Line::Other, Line::Other, Line::Frame(frame(0x080, &[]))]);
}

#[test]
fn garbage_is_told_from_frames() {
    for text in ["t0801\r", "tXYZ0\r", "t0809112233445566778899\r", "t08001\r", "t8000\r", "hello\r", "t\r"] {
        assert_eq!(decoded(text.as_bytes()), [Line::Garbage], "{text:?}");
    }
    let mut long = vec![b't'; 500];
    long.push(b'\r');
    long.extend_from_slice(b"t0800\r");
    assert_eq!(decoded(&long), [Line::Garbage, Line::Frame(frame(0x080, &[]))]);
}

#[test]
fn a_bit_rate_without_a_letter_is_refused_before_the_port_is_touched() {
    let error = open("/dev/null", 115_200, 666).err().unwrap();
    assert!(error.to_string().starts_with("666 bit/s"), "{error}");
}

#[test]
fn bytes_that_are_no_frames_are_counted_also_where_no_line_ends() {
    let count = |bytes: &[u8]| {
        let mut decoder = Decoder::default();
        for byte in bytes {
            let _ = decoder.push(*byte);
        }
        decoder.garbage()
    };
    assert_eq!(count(b"t0800\rz\r\x07V1013\r"), 0);
    assert_eq!(count(b"xx\rzz\rhello\r"), 7);
    assert_eq!(count(&[b'x'; MAX_LINE]), 0);
    assert_eq!(count(&[b'x'; MAX_LINE + 5]), 5);
    let mut ended = vec![b'x'; MAX_LINE + 5];
    ended.push(b'\r');
    assert_eq!(count(&ended), MAX_LINE as u64 + 5);
}

/// What comes is no frame, again and again and without end: the reader looks up all the same.
#[cfg(target_os = "linux")]
#[test]
fn an_adapter_that_babbles_does_not_hold_the_reader() {
    use std::sync::mpsc::channel;
    use std::thread;
    for babble in [&[b'x'; 200][..], b"xx\rzz\r"] {
        let (mut device, computer) = serialport::TTYPort::pair().unwrap();
        let path = computer.name().unwrap();
        drop(computer);
        let mut bus = open(&path, 115_200, 1_000_000).unwrap();
        let babbler = thread::spawn(move || while device.write_all(babble).is_ok() {});
        let (tell, told) = channel();
        let reader = thread::spawn(move || {
            loop {
                let received = bus.receive.receive(Duration::from_millis(5)).unwrap();
                if tell.send((received, bus.receive.garbage())).is_err() {
                    return;
                }
            }
        });
        let mut garbage = 0;
        while garbage < 1_000 {
            let (received, bytes) = told.recv_timeout(Duration::from_secs(60)).expect("the reader looks up");
            assert_eq!(received, None);
            garbage = bytes;
        }
        drop(told);
        reader.join().unwrap();
        babbler.join().unwrap();
    }
}
