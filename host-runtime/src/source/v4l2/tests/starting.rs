//! From a path to a running camera, and back.

use super::*;
use crate::source::v4l2::device::FourCc;
use tetrad_core::vision::frame::PixelFormat;

const AUTO_EXPOSURE: u32 = 0x009a_0901;
const AUTO_GAIN: u32 = 0x0098_0912;
const AUTO_WHITE_BALANCE: u32 = 0x0098_090c;
const AUTO_FOCUS: u32 = 0x009a_090c;

#[track_caller]
fn assert_refused(result: Result<Camera<Fake>, Refusal>, exit: Exit, words: &[&str]) {
    let error = match result {
        Ok(_) => panic!("the camera started"),
        Err(Refusal::Never(error) | Refusal::NotNow(error)) => error,
    };
    assert_eq!(error.exit(), exit, "{error}");
    for word in ["/dev/video7"].iter().chain(words) {
        assert!(error.to_string().contains(word), "'{word}' is not in: {error}");
    }
}

#[test]
fn the_best_format_of_the_wanted_size_is_chosen() {
    let offer = |name: &[u8; 4], sizes: &[(u32, u32)]| (FourCc(*name), sizes.to_vec());
    let vga = |name| offer(name, &[(640, 480)]);
    let small = |name| offer(name, &[(320, 240), (160, 120)]);
    for (formats, chosen) in [
        (vec![vga(b"MJPG"), vga(b"YUYV")], (PixelFormat::Yuyv, 640)),
        (vec![vga(b"NV12"), vga(b"UYVY")], (PixelFormat::Uyvy, 640)),
        (vec![vga(b"RGBP"), vga(b"NV12")], (PixelFormat::Nv12, 640)),
        // The size counts more than the format.
        (vec![small(b"YUYV"), vga(b"RGBP")], (PixelFormat::Rgb565Le, 640)),
        (vec![small(b"RGBR"), small(b"YUYV")], (PixelFormat::Yuyv, 320)),
    ] {
        let fake = Fake::new(Vec::new());
        fake.state().formats = formats;
        let camera = running(&fake);
        assert_eq!((camera.info.format, camera.info.width), chosen);
    }
}

#[test]
fn what_the_camera_changed_is_told() {
    let fake = Fake::new(Vec::new());
    {
        let mut state = fake.state();
        state.formats = vec![(FourCc(*b"YUYV"), vec![(320, 240)])];
        state.rate = Some(25.0);
        state.other_yuv = true;
    }
    let mut camera = running(&fake);
    assert_eq!((camera.info.width, camera.info.height, camera.info.fps), (320, 240, Some(25.0)));
    let notices = camera.take_notices().join("\n");
    for words in
        ["asked for 640 x 480 pixels, the camera sends 320 x 240", "the camera sends 25.00", "BT.601"]
    {
        assert!(notices.contains(words), "'{words}' is not in: {notices}");
    }
    assert!(camera.take_notices().is_empty(), "each is told once");
}

#[test]
fn a_rate_near_the_wish_is_no_news_and_none_at_all_is() {
    for (rate, told) in [(Some(29.97), 0), (None, 1)] {
        let fake = Fake::new(Vec::new());
        fake.state().rate = rate;
        let mut camera = running(&fake);
        assert_eq!(camera.info.fps, rate);
        assert_eq!(camera.take_notices().len(), told);
    }
}

#[test]
fn padded_rows_are_understood() {
    let fake = Fake::new(steady(1));
    {
        let mut state = fake.state();
        state.formats = vec![(FourCc(*b"YUYV"), vec![(320, 240)])];
        state.padding = 64;
    }
    let mut camera = running(&fake);
    assert_eq!(camera.next().unwrap().view.pixel(319, 239).unwrap().r, grey(100));
}

#[test]
fn a_camera_without_a_readable_format_is_refused_with_what_it_offers() {
    let fake = Fake::new(Vec::new());
    fake.state().formats =
        vec![(FourCc(*b"MJPG"), vec![(1280, 720), (640, 480)]), (FourCc(*b"H264"), vec![(1920, 1080)])];
    let words =
        ["only MJPG (not read): 1280x720, 640x480; H264 (not read): 1920x1080", "YUYV", "another camera"];
    assert_refused(start(&fake, &Options::default()), Exit::Failed, &words);

    fake.state().formats.clear();
    assert_refused(start(&fake, &Options::default()), Exit::Failed, &["no picture format"]);
}

#[test]
fn interlaced_other_and_oversized_pictures_are_refused() {
    let fake = Fake::new(Vec::new());
    fake.state().interlaced = true;
    assert_refused(start(&fake, &Options::default()), Exit::Failed, &["progressive"]);

    let fake = Fake::new(Vec::new());
    fake.state().forced_fourcc = Some(FourCc(*b"MJPG"));
    assert_refused(start(&fake, &Options::default()), Exit::Failed, &["YUYV", "sends MJPG"]);

    let fake = Fake::new(Vec::new());
    fake.state().formats = vec![(FourCc(*b"YUYV"), vec![(10_000, 7000)])];
    assert_refused(start(&fake, &Options::default()), Exit::Failed, &["10000 x 7000", "8192"]);
}

#[test]
fn nodes_that_do_not_capture_are_bad_arguments() {
    let fake = Fake::new(Vec::new());
    fake.state().identity.captures = false;
    assert_refused(start(&fake, &Options::default()), Exit::BadArguments, &["tetrad devices"]);
    fake.state().identity.multi_planar = true;
    assert_refused(start(&fake, &Options::default()), Exit::BadArguments, &["multi-planar"]);
}

#[test]
fn automatic_controls_are_off_while_open_and_back_afterwards() {
    let fake = Fake::new(Vec::new());
    fake.state().controls = [
        (AUTO_EXPOSURE, (true, 3)),
        (AUTO_GAIN, (true, 1)),
        (AUTO_WHITE_BALANCE, (true, 1)),
        (AUTO_FOCUS, (true, 1)),
    ]
    .into();
    let mut camera = running(&fake);
    let off = [(AUTO_EXPOSURE, 1), (AUTO_GAIN, 0), (AUTO_WHITE_BALANCE, 0), (AUTO_FOCUS, 0)];
    assert_eq!(fake.state().control_writes, off, "exposure first: others may depend on it");
    let notices = camera.take_notices().join("\n");
    for name in ["auto exposure", "automatic gain", "auto white balance", "autofocus"] {
        assert!(notices.contains(&format!("/dev/video7: {name} switched off")), "{notices}");
    }
    drop(camera);
    let back = [(AUTO_FOCUS, 1), (AUTO_WHITE_BALANCE, 1), (AUTO_GAIN, 1), (AUTO_EXPOSURE, 3)];
    assert_eq!(fake.state().control_writes[4..], back);
}

#[test]
fn controls_that_are_missing_inactive_or_off_are_left_alone() {
    let fake = Fake::new(Vec::new());
    fake.state().controls = [(AUTO_EXPOSURE, (true, 1)), (AUTO_GAIN, (false, 1))].into();
    let mut camera = running(&fake);
    assert!(camera.take_notices().is_empty());
    drop(camera);
    assert!(fake.state().control_writes.is_empty());
}

#[test]
fn a_control_that_will_not_go_off_is_told_and_does_not_stop_the_camera() {
    let fake = Fake::new(steady(1));
    {
        let mut state = fake.state();
        state.controls = [(AUTO_EXPOSURE, (true, 3)), (AUTO_WHITE_BALANCE, (true, 1))].into();
        state.stubborn = vec![AUTO_EXPOSURE];
        state.refusing = vec![AUTO_WHITE_BALANCE];
    }
    let mut camera = running(&fake);
    let notices = camera.take_notices();
    assert_eq!(notices.len(), 2);
    assert!(notices[0].contains("auto exposure could not be switched off (it went to 3"), "{notices:?}");
    assert!(notices[1].contains("auto white balance could not be switched off"), "{notices:?}");
    camera.next().unwrap();
}

#[test]
fn controls_are_set_back_when_the_start_fails() {
    let fake = Fake::new(Vec::new());
    fake.state().controls = [(AUTO_EXPOSURE, (true, 3))].into();
    fake.state().fail_start = Some(libc::ENOSPC);
    assert_refused(start(&fake, &Options::default()), Exit::Failed, &["USB bandwidth"]);
    assert_eq!(fake.state().controls[&AUTO_EXPOSURE], (true, 3));
    assert!(!fake.state().streaming);
}

#[test]
fn one_buffer_is_not_enough() {
    let fake = Fake::new(Vec::new());
    fake.state().buffer_count = 1;
    assert_refused(start(&fake, &Options::default()), Exit::Failed, &["only 1 buffer"]);
}

#[test]
fn a_busy_or_missing_camera_is_tried_for_a_while() {
    let not_now = |code| {
        let fake = Fake::new(Vec::new());
        fake.state().fail_format = Some(code);
        start(&fake, &Options::default())
    };
    for (code, words) in [(libc::EBUSY, "in use by another program"), (libc::ENOENT, "no such camera")] {
        let (mut attempts, mut pauses) = (0, 0);
        let result = with_retries(
            || {
                attempts += 1;
                not_now(code)
            },
            || pauses += 1,
        );
        assert_eq!((attempts, pauses), (21, 20));
        let error = result.map(|camera| camera.info).unwrap_err();
        assert_eq!(error.exit(), Exit::DeviceLost);
        assert!(error.to_string().contains(words), "{error}");
    }
    // It may come back in between.
    let mut attempts = 0;
    let camera = with_retries(
        || {
            attempts += 1;
            if attempts < 3 {
                not_now(libc::EBUSY)
            } else {
                start(&Fake::new(Vec::new()), &Options::default())
            }
        },
        || {},
    );
    assert!(camera.is_ok());
    assert_eq!(attempts, 3);
}

#[test]
fn a_camera_without_permission_is_not_tried_again() {
    let mut attempts = 0;
    let result = with_retries(
        || {
            attempts += 1;
            Err::<(), _>(refused("/dev/video7", "opened", io::Error::from_raw_os_error(libc::EACCES)))
        },
        || panic!("no reason to wait"),
    );
    assert_eq!(attempts, 1);
    let error = result.unwrap_err();
    assert_eq!(error.exit(), Exit::Failed);
    assert!(error.to_string().contains("group 'video'"), "{error}");
}

#[test]
fn a_file_that_is_no_camera_is_a_bad_argument() {
    let error =
        CameraSource::open("/dev/null", Path::new("/dev/null"), &Options::default()).map(|_| ()).unwrap_err();
    assert_eq!(error.exit(), Exit::BadArguments);
    assert!(error.to_string().contains("/dev/null: this is not a Video4Linux camera"), "{error}");
}

#[test]
fn a_node_tells_its_formats_without_being_started() {
    let fake = Fake::new(Vec::new());
    let big_endian = FourCc([b'Y', b'1', b'6', b' ' | 0x80]);
    fake.state().formats = vec![
        (FourCc(*b"MJPG"), vec![(1280, 720), (640, 480)]),
        (FourCc(*b"YUYV"), vec![(640, 480)]),
        (FourCc(*b"GREY"), Vec::new()),
        (FourCc(*b"NV12"), vec![(640, 480)]),
        (big_endian, vec![(640, 480)]),
    ];
    let probed = devices::ask(&mut fake.clone()).unwrap();
    assert_eq!(probed.card, "Memory Cam");
    assert_eq!(
        probed.formats,
        [
            "YUYV, NV12: 640x480",
            "MJPG (not read): 1280x720, 640x480",
            "GREY (not read)",
            "Y16-BE (not read): 640x480"
        ]
    );
    assert!(!fake.state().streaming);
    fake.state().identity.captures = false;
    assert!(devices::ask(&mut fake.clone()).unwrap().formats.is_empty());
}
