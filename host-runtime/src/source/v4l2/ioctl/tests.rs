use super::*;

#[test]
fn a_file_that_is_no_camera_says_so() {
    let mut device = Kernel::open(Path::new("/dev/null")).unwrap();
    assert!(is_absent(&device.identity().unwrap_err()));
    assert_eq!(device.formats().unwrap(), []);
    assert_eq!(device.control_info(1).unwrap(), None);
    assert!(device.start(4).is_err());
    assert!(device.dequeue().is_err());
    assert!(device.queue(0).is_err());
    assert!(device.bytes(0).is_empty());
}

#[test]
fn mapped_bytes_are_the_files_and_hidden_while_queued() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("buffer");
    std::fs::write(&path, [7; 4096]).unwrap();
    let mut device = Kernel::open(&path).unwrap();
    let mapped = device.map(0, 4096).unwrap();
    device.buffers.push(mapped);
    assert_eq!(device.bytes(0), [7; 4096]);
    assert!(device.queue(0).is_err(), "an ordinary file takes no buffers");
    assert!(device.bytes(0).is_empty());
    assert!(device.map(1, 4096).is_err(), "an offset that is not a whole page");
}

#[test]
fn waiting_tells_data_silence_and_hang_up_apart() {
    use std::{io::Write as _, os::fd::OwnedFd};
    let (reader, mut writer) = io::pipe().unwrap();
    let file = File::from(OwnedFd::from(reader));
    let mut device = Kernel { file, buffers: Vec::new(), streaming: false };
    assert_eq!(device.wait(Duration::from_millis(1)).unwrap(), Wake::TimedOut);
    writer.write_all(b"x").unwrap();
    assert_eq!(device.wait(Duration::from_secs(60)).unwrap(), Wake::Ready);
    drop(writer);
    assert_eq!(device.wait(Duration::from_secs(60)).unwrap(), Wake::Gone);
}

#[test]
fn the_clock_runs_forwards() {
    let device = Kernel::open(Path::new("/dev/null")).unwrap();
    let first = device.now_s();
    assert!(first > 0.0 && device.now_s() >= first);
}

#[test]
fn yuv_other_than_core_reads_is_recognised() {
    let said = |colorspace, ycbcr_enc, quantization| {
        let pix = layout::PixFormat { colorspace, ycbcr_enc, quantization, ..Default::default() };
        granted(&layout::Format::capture(pix)).other_yuv
    };
    const SRGB: u32 = 8;
    assert!(!said(SRGB, 0, 0));
    assert!(!said(COLORSPACE_REC709, ENCODING_601, 2));
    assert!(said(COLORSPACE_REC709, 0, 0));
    assert!(said(SRGB, 2, 0));
    assert!(said(SRGB, 0, QUANTIZATION_FULL));
    assert!(said(COLORSPACE_JPEG, 0, 0));
}

#[test]
fn access_is_asked_without_opening() {
    assert!(may_use(Path::new("/dev/null")));
    assert!(!may_use(Path::new("/dev/no-such-device")));
    assert!(!may_use(Path::new("/dev/nu\0ll")));
}

#[test]
fn texts_end_at_their_zero() {
    assert_eq!(text(b"HD Webcam\0junk"), "HD Webcam");
    assert_eq!(text(b"full"), "full");
}
