use super::*;

#[test]
fn a_bit_rate_without_a_letter_is_refused_before_the_port_is_touched() {
    let error = open("/dev/null", 115_200, 666).err().unwrap();
    assert!(error.to_string().starts_with("666 bit/s"), "{error}");
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
