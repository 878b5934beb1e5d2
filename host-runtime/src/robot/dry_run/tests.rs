use super::*;

fn port(clock: &Clock) -> (tempfile::TempDir, DryRun) {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("set-points.csv");
    let port = DryRun::with_clock(&file, &PumaConfig::default(), 10_000, clock.clone()).unwrap();
    (dir, port)
}

#[test]
fn set_points_are_recorded_with_their_times_and_followed() {
    let clock = Clock::given();
    let (dir, mut port) = port(&clock);
    let mut joints = port.read_joints().unwrap().joints;
    assert_eq!(port.write_set_point(&joints), Err(PortError::NotReady(PortStatus::Disabled)));
    port.enable().unwrap();
    port.write_set_point(&joints).unwrap();
    clock.set(10_000);
    joints[0] = 0.0125;
    port.write_set_point(&joints).unwrap();
    assert_eq!(port.read_joints().unwrap(), JointReading { joints, age_us: 0 });
    assert_eq!(port.report(), ["2 set-points recorded"]);
    let text = std::fs::read_to_string(dir.path().join("set-points.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3);
    assert_eq!(lines[0], "t,q1,q2,q3,q4,q5,q6");
    assert!(lines[2].starts_with("0.010000,0.0125,0.785"), "{}", lines[2]);
}

#[test]
fn a_file_of_something_else_is_left_as_it_is() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("keep.toml");
    let create = || DryRun::create(&file, &PumaConfig::default(), 10_000);
    for text in ["[slave]\n", "t,q1,q2,q3,q4,q5,q6,x\n1\n", "t,q1", "\0\x01"] {
        std::fs::write(&file, text).unwrap();
        let error = create().unwrap_err().to_string();
        assert!(error.starts_with(&format!("{} is there and no dry run's", file.display())), "{error}");
        assert!(error.contains("name another file"), "{error}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    }
    // a record of before, and what holds nothing, are written over
    for text in ["", "t,q1,q2,q3,q4,q5,q6", "t,q1,q2,q3,q4,q5,q6\n0.1,1,2,3,4,5,6\n"] {
        std::fs::write(&file, text).unwrap();
        create().unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "t,q1,q2,q3,q4,q5,q6\n");
    }
}

#[test]
fn a_longer_cycle_has_a_longer_step_and_watchdog() {
    let dir = tempfile::tempdir().unwrap();
    let clock = Clock::given();
    let (file, puma) = (dir.path().join("a.csv"), PumaConfig::default());
    let mut port = DryRun::with_clock(&file, &puma, 100_000, clock.clone()).unwrap();
    port.enable().unwrap();
    let mut joints = port.read_joints().unwrap().joints;
    joints[0] += 0.09 * puma.joints[0].max_speed_rad_s;
    clock.set(150_000);
    assert_eq!(port.write_set_point(&joints), Ok(()));
}

#[test]
fn a_jump_is_refused_and_not_recorded() {
    let clock = Clock::given();
    let (_dir, mut port) = port(&clock);
    port.enable().unwrap();
    let stood = port.read_joints().unwrap().joints;
    let mut far = stood;
    far[2] += 1.0;
    assert_eq!(port.write_set_point(&far), Err(PortError::TooFar(3)));
    assert_eq!(port.read_joints().unwrap().joints, stood);
    assert_eq!(port.report(), ["0 set-points recorded"]);
}

#[test]
fn without_set_points_it_stops_until_it_is_enabled_again() {
    let clock = Clock::given();
    let (_dir, mut port) = port(&clock);
    port.enable().unwrap();
    let joints = port.read_joints().unwrap().joints;
    clock.set(WATCHDOG_US);
    assert_eq!(port.status(), PortStatus::Ready);
    clock.set(WATCHDOG_US + 1);
    assert_eq!(port.write_set_point(&joints), Err(PortError::NotReady(PortStatus::Stopped)));
    assert_eq!(port.reason().as_deref(), Some("no set-point came for 100 ms"));
    port.enable().unwrap();
    assert_eq!((port.status(), port.reason()), (PortStatus::Ready, None));
    port.write_set_point(&joints).unwrap();
    port.stop().unwrap();
    assert_eq!(port.write_set_point(&joints), Err(PortError::NotReady(PortStatus::Stopped)));
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_goes_away_is_a_loss_with_a_reason() {
    use std::os::fd::AsRawFd as _;
    let (reader, writer) = std::io::pipe().unwrap();
    let file = format!("/dev/fd/{}", writer.as_raw_fd());
    let mut port =
        DryRun::with_clock(Path::new(&file), &PumaConfig::default(), 10_000, Clock::given()).unwrap();
    let joints = port.read_joints().unwrap().joints;
    port.enable().unwrap();
    port.write_set_point(&joints).unwrap();
    drop(reader);
    assert_eq!(port.write_set_point(&joints), Err(PortError::Lost));
    assert_eq!(port.status(), PortStatus::Lost);
    let reason = port.reason().unwrap();
    assert!(reason.starts_with(&format!("cannot write {file}: Broken pipe")), "{reason}");
}
