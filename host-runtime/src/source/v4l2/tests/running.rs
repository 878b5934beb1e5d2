//! The running camera.

use super::*;
#[test]
fn pictures_come_one_after_the_other_with_the_drivers_time() {
    let fake = Fake::new(steady(3));
    let mut camera = running(&fake);
    assert_eq!((camera.info.width, camera.info.height), (640, 480));
    assert_eq!((camera.info.fps, camera.info.frames, camera.info.live), (Some(30.0), None, true));
    let mut times = Vec::new();
    for at in 0..3 {
        let frame = camera.next().unwrap();
        assert_eq!((frame.index, frame.number, frame.gap), (u64::from(at), u64::from(at), Gap::None));
        assert_eq!(frame.view.pixel(639, 479).unwrap().r, grey(100 + at));
        times.push(frame.t_s);
    }
    let stamped = |at: f64| 1000.0 + at * fake::PERIOD_S - 0.001;
    assert_eq!(times, [stamped(1.0), stamped(2.0), stamped(3.0)]);
    assert_eq!(camera.take_notices(), Vec::<String>::new());
}

#[test]
fn the_lent_buffer_stays_out_until_the_next_call() {
    let fake = Fake::new(steady(2));
    let mut camera = running(&fake);
    assert_eq!(fake.queued(), 4);
    let lent = camera.next().unwrap().view.pixel(0, 0);
    assert_eq!(fake.queued(), 3, "one is lent");
    assert_eq!(lent.unwrap().r, grey(100));
    camera.next().unwrap();
    assert_eq!(fake.queued(), 3, "the first came back when the second was asked for");
}

#[test]
fn a_slow_caller_gets_the_newest_and_the_others_go_back_first() {
    let pictures = (0..3).map(|at| Arrival::picture(50 + at, u32::from(at))).collect();
    let fake = Fake::new(vec![pictures, vec![Arrival::picture(60, 3)]]);
    let mut camera = running(&fake);
    assert_eq!(look(&mut camera), (grey(52), 0, Gap::None));
    assert_eq!(fake.queued(), 3, "the overtaken ones are the driver's again while we work");
    assert_eq!(look(&mut camera), (grey(60), 1, Gap::None));
    assert_eq!(camera.stream.losses(), Losses { damaged: 0, overtaken: 2 });
}

#[test]
fn overtaken_pictures_count_as_missed() {
    let burst = vec![Arrival::picture(51, 1), Arrival::picture(52, 2), Arrival::picture(53, 3)];
    let fake = Fake::new(vec![vec![Arrival::picture(50, 0)], burst]);
    let mut camera = running(&fake);
    assert_eq!(look(&mut camera), (grey(50), 0, Gap::None));
    assert_eq!(look(&mut camera), (grey(53), 3, Gap::Missed(2)));
}

#[test]
fn damaged_and_short_pictures_are_skipped_and_counted() {
    let damaged = Arrival::Picture { value: 1, sequence: 1, damaged: true, short: false };
    let short = Arrival::Picture { value: 2, sequence: 2, damaged: false, short: true };
    let fake = Fake::new(vec![
        vec![Arrival::picture(50, 0)],
        vec![damaged.clone()],
        vec![short],
        // A whole picture is not lost to a damaged one behind it.
        vec![Arrival::picture(53, 3), damaged],
    ]);
    let mut camera = running(&fake);
    assert_eq!(look(&mut camera), (grey(50), 0, Gap::None));
    assert_eq!(look(&mut camera), (grey(53), 3, Gap::Missed(2)));
    assert_eq!(camera.stream.losses(), Losses { damaged: 3, overtaken: 0 });
    assert_eq!(fake.queued(), 3, "every skipped buffer went back");
}

#[test]
fn sequence_numbers_may_jump_repeat_run_back_and_wrap() {
    let sequences = [u32::MAX - 1, u32::MAX, 0, 0, 5, 2, 3, 0x4000_0000, 0x4000_0001];
    let script = sequences.iter().map(|sequence| vec![Arrival::picture(50, *sequence)]).collect();
    let fake = Fake::new(script);
    let mut camera = running(&fake);
    let seen: Vec<(u64, Gap)> = sequences
        .iter()
        .map(|_| {
            let (_, number, gap) = look(&mut camera);
            (number, gap)
        })
        .collect();
    assert_eq!(
        seen,
        [
            (0, Gap::None),
            (1, Gap::None),
            (2, Gap::None),
            (3, Gap::Unknown),
            (8, Gap::Missed(4)),
            (9, Gap::Unknown),
            (10, Gap::None),
            (11, Gap::Unknown),
            (12, Gap::None),
        ]
    );
}

#[test]
fn a_pulled_cable_is_a_lost_device_and_stays_one() {
    for ending in [Arrival::Unplugged, Arrival::Fails(libc::ENODEV), Arrival::Fails(libc::EIO)] {
        let mut script = steady(1);
        script.push(vec![ending.clone()]);
        let fake = Fake::new(script);
        let mut camera = running(&fake);
        camera.next().unwrap();
        for _ in 0..2 {
            let error = camera.next().map(|frame| frame.index).unwrap_err();
            assert!(matches!(error, SourceError::DeviceLost { .. }), "{ending:?}");
            assert_eq!(error.exit(), Exit::DeviceLost);
            assert!(error.to_string().contains("/dev/video7: the camera went away"), "{error}");
        }
    }
}

#[test]
fn silence_is_a_stall_and_not_a_hang() {
    let fake = Fake::new(steady(1));
    let mut camera = running(&fake);
    camera.next().unwrap();
    let before = fake.state().now_s;
    let error = camera.next().map(|frame| frame.index).unwrap_err();
    assert!(matches!(error, SourceError::Stalled { damaged: 0, .. }), "{error}");
    assert_eq!(error.exit(), Exit::DeviceLost);
    assert!(error.to_string().contains("/dev/video7: no usable picture for 2 s"), "{error}");
    let waited = fake.state().now_s - before;
    assert!((waited - 2.0).abs() < 1e-6, "{waited}");
    // The stall may pass: nothing was requeued twice, and the stream goes on.
    fake.state().script.push_back(vec![Arrival::picture(77, 9)]);
    assert_eq!(look(&mut camera), (grey(77), 9, Gap::Missed(8)));
}

#[test]
fn only_damaged_pictures_are_a_stall_that_says_so() {
    let damaged = Arrival::Picture { value: 1, sequence: 1, damaged: true, short: false };
    let fake = Fake::new(std::iter::repeat_n(vec![damaged], 10_000).collect());
    let mut camera = running(&fake);
    let error = camera.next().map(|frame| frame.index).unwrap_err();
    // Five seconds for the first picture, at 32 a second.
    assert!(matches!(error, SourceError::Stalled { damaged: 160, .. }), "{error}");
    assert!(error.to_string().contains("160 damaged"), "{error}");
}

#[test]
fn slow_cameras_are_given_ten_frames_of_time() {
    let fake = Fake::new(steady(1));
    fake.state().rate = Some(1.0);
    let mut camera = running(&fake);
    camera.next().unwrap();
    let error = camera.next().map(|frame| frame.index).unwrap_err();
    assert!(matches!(error, SourceError::Stalled { seconds: 10.0, .. }), "{error}");
}

#[test]
fn without_the_drivers_monotonic_time_frames_carry_their_arrival() {
    let fake = Fake::new(steady(2));
    fake.state().stamps = false;
    let mut camera = running(&fake);
    let first = camera.next().unwrap().t_s;
    let second = camera.next().unwrap().t_s;
    assert_eq!((first, second), (1000.0 + fake::PERIOD_S, 1000.0 + 2.0 * fake::PERIOD_S));
    let notices = camera.take_notices();
    assert_eq!(notices.len(), 1, "said once: {notices:?}");
    assert!(notices[0].contains("/dev/video7") && notices[0].contains("monotonic"), "{notices:?}");
}

#[test]
fn time_never_runs_backwards_whatever_the_driver_stamps() {
    for (off_s, words) in [(-5.0, "do not increase"), (0.4, "do not increase"), (500.0, "of another clock")] {
        let fake = Fake::new(steady(5));
        let mut camera = running(&fake);
        let mut times = vec![camera.next().unwrap().t_s];
        fake.state().stamp_off_s = off_s;
        for _ in 0..4 {
            times.push(camera.next().unwrap().t_s);
        }
        assert!(times.is_sorted_by(|a, b| a < b), "{off_s}: {times:?}");
        let notices = camera.take_notices();
        assert_eq!(notices.len(), 1, "{notices:?}");
        assert!(notices[0].contains(words), "{off_s}: {notices:?}");
    }
}

#[test]
fn a_stream_that_begins_in_another_time_carries_arrivals() {
    for off_s in [-900.0, 2e9] {
        let fake = Fake::new(steady(1));
        let mut camera = running(&fake);
        fake.state().stamp_off_s = off_s;
        assert_eq!(camera.next().unwrap().t_s, 1000.0 + fake::PERIOD_S);
        assert!(camera.take_notices()[0].contains("of another clock"));
    }
}

#[test]
fn a_picture_that_waited_for_a_stopped_program_keeps_its_time() {
    let fake = Fake::new(steady(2));
    let mut camera = running(&fake);
    let first = camera.next().unwrap().t_s;
    // Taken soon after the first, and the program went to sleep for an hour.
    fake.state().now_s += 3600.0;
    fake.state().stamp_off_s = -3600.0;
    let second = camera.next().unwrap().t_s;
    assert!((second - first - fake::PERIOD_S).abs() < 1e-9, "{first} {second}");
    assert!(camera.take_notices().is_empty());
}
