use super::*;
use nalgebra::Vector3;
use tetrad_core::config::{GovernorConfig, TeleopConfig, TeleopMode, Turning};

fn parse(text: &str) -> Result<ArmSettings, SettingsError> {
    ArmSettings::parse(text, "tetrad.toml")
}

#[track_caller]
fn refused(text: &str, message: &str) {
    let error = parse(text).unwrap_err().to_string();
    assert!(error.contains(message), "{error}");
    assert!(error.starts_with("tetrad.toml: "), "{error}");
}

/// The example of docs/arm.md.
fn documented() -> String {
    let document = include_str!("../../../../docs/arm.md");
    let (_, example) = document.split_once("```toml\n").unwrap();
    example.split_once("```").unwrap().0.to_owned()
}

#[test]
fn the_documented_file_is_the_default() {
    let text = documented();
    assert!(text.contains("resume_ms"), "{text}");
    let settings = parse(&text).unwrap();
    let default = ArmSettings { port: Some(RobotAddress::default()), ..ArmSettings::default() };
    assert_eq!(settings.port, default.port);
    assert_eq!(settings.slave.puma.tool, default.slave.puma.tool);
    assert_eq!(
        settings.slave.teleop,
        TeleopConfig { max_lead_rad: settings.slave.teleop.max_lead_rad, ..default.slave.teleop }
    );
    assert!((settings.slave.teleop.max_lead_rad - default.slave.teleop.max_lead_rad).abs() < 1e-3);
    for (a, b) in settings.slave.puma.joints.iter().zip(&default.slave.puma.joints) {
        assert!((a.min_rad - b.min_rad).abs() < 1e-12 && (a.max_rad - b.max_rad).abs() < 1e-12);
        // the file has tenths of a degree
        assert!((a.max_speed_rad_s - b.max_speed_rad_s).abs() < 1e-3);
    }
    assert_governor_is_near(&settings.slave.governor, &default.slave.governor);
    let (a, b) = (settings.slave.puma.lengths, default.slave.puma.lengths);
    for (a, b) in [(a.base_m, b.base_m), (a.offset_m, b.offset_m), (a.elbow_m, b.elbow_m)] {
        assert!((a - b).abs() < 1e-12);
    }
}

#[track_caller]
fn assert_governor_is_near(a: &GovernorConfig, b: &GovernorConfig) {
    let numbers = |g: &GovernorConfig| {
        let u = g.uncertainty;
        let mut all = vec![u.full_m, u.creep_m, u.full_rad, u.creep_rad, g.speed_share, g.max_tool_speed_m_s];
        all.extend([g.response_per_s, g.limit_margin_rad, g.max_outside_rad, g.singularity_margin]);
        all.extend(g.max_acceleration_rad_s2.iter().chain(&g.max_jerk_rad_s3));
        all.push(g.creep_share);
        all
    };
    for (a, b) in numbers(a).iter().zip(&numbers(b)) {
        // the file has three digits and more
        assert!((a - b).abs() < 2e-3 * b, "{a} {b}");
    }
    assert_eq!((a.cycle_us, a.workspace, a.passages), (b.cycle_us, b.workspace, b.passages));
}

#[test]
fn an_empty_file_is_the_default() {
    assert_eq!(parse("").unwrap(), ArmSettings::default());
    assert_eq!(parse("[arm]\n[teleop]\n[slave]\n").unwrap(), ArmSettings::default());
}

#[test]
fn units_are_those_of_the_keys() {
    let settings = parse(
        "[arm]\nforearm_mm = 433\nmax_speed_deg_s = [90, 90, 90, 90, 90, 90]\ntool_mm = [1, 2, 3]\n\
         tool_rpy_deg = [0, 0, 90]\n[teleop]\nmode = \"paper\"\nlock_turns = true\n\
         robot_from_hand_rpy_deg = [90, 0, 0]\nresume_ms = 600\n\
         [workspace]\nmin_mm = [100, -200, 50]\n[governor]\nmax_tool_speed_mm_s = 250\npass_elbow = true\n\
         [slave]\nport = \"sim:?seed=4\"\n",
    )
    .unwrap();
    assert!((settings.slave.puma.lengths.forearm_m - 0.433).abs() < 1e-15);
    assert!((settings.slave.puma.joints[5].max_speed_rad_s - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert!((settings.slave.puma.tool.translation - Vector3::new(0.001, 0.002, 0.003)).amax() < 1e-15);
    // yaw turns x to y; roll turns y to z
    assert!((settings.slave.puma.tool.rotation * Vector3::x() - Vector3::y()).amax() < 1e-15);
    assert!((settings.slave.teleop.robot_from_hand * Vector3::y() - Vector3::z()).amax() < 1e-15);
    assert_eq!(
        (settings.slave.teleop.mode, settings.slave.teleop.turning),
        (TeleopMode::Paper, Turning::Locked)
    );
    assert_eq!(settings.slave.teleop.workspace.min_m, [0.1, -0.2, 0.05]);
    assert_eq!(settings.slave.governor.workspace, settings.slave.teleop.workspace);
    assert_eq!(settings.slave.teleop.resume_us, 600_000);
    assert_eq!(settings.slave.governor.max_tool_speed_m_s, 0.25);
    assert!(settings.slave.governor.passages.elbow && !settings.slave.governor.passages.shoulder);
    assert_eq!(settings.port.unwrap().to_string(), "sim:?seed=4");
}

#[test]
fn what_is_unknown_or_of_another_kind_is_named_with_its_line() {
    refused("[arm]\nforearm_m = 0.43\n", "unknown field `forearm_m`");
    refused("[arm]\nforearm_m = 0.43\n", "line 2");
    refused("[governor]\ncycle_ms = 0.5\n", "[governor] cycle_ms: 1 to 100 is needed");
    refused("[governor]\ncycle_ms = nan\n", "[governor] cycle_ms: 1 to 100 is needed");
    refused("[amr]\n", "unknown field `amr`");
    refused("[arm]\nmin_deg = [1, 2, 3]\n", "line 2");
    refused("[teleop]\nmode = \"direct\"\n", "since-engage");
    refused("arm = \n", "line 1");
}

#[test]
fn values_that_cannot_be_are_named_by_table_and_key() {
    refused(
        "[arm]\nforearm_mm = 0\n",
        "[arm] base_mm, upper_arm_mm, offset_mm, elbow_mm, forearm_mm: an arm's",
    );
    refused("[arm]\nmin_deg = [0, 0, 50, 0, 0, 0]\n", "[arm] min_deg, max_deg: joint 3: the range");
    refused("[arm]\nmax_speed_deg_s = [1, 1, 1, nan, 1, 1]\n", "[arm] max_speed_deg_s: joint 4");
    for angle in ["inf", "nan", "1e300", "-360.1"] {
        let problem = "[arm] tool_rpy_deg: angles from -360 to 360 degrees";
        refused(&format!("[arm]\ntool_rpy_deg = [{angle}, 0, 0]\n"), problem);
        let problem = "[teleop] robot_from_hand_rpy_deg: angles from -360 to 360 degrees";
        refused(&format!("[teleop]\nrobot_from_hand_rpy_deg = [0, {angle}, 0]\n"), problem);
    }
    refused(
        "[canopen]\nwatchdog_cycles = 101\n",
        "[canopen]: watchdog_cycles (times period_us): that is 1010 ms",
    );
    refused("[teleop]\nmode = \"Paper\"\n", "write mode = \"since-engage\" or \"paper\", in small letters");
    refused("[teleop]\nscale = -1\n", "[teleop] scale, turn_scale: ");
    refused("[teleop]\ncommand_timeout_ms = nan\n", "[teleop] command_timeout_ms: the time that a command ");
    refused("[teleop]\nhold_to_run_timeout_ms = -1\n", "[teleop] hold_to_run_timeout_ms: ");
    refused("[teleop]\npredicted_ms = 6000\n", "[teleop] predicted_ms: the time that a predicted hand ");
    refused(
        "[teleop]\nresume_ms = 6000\n",
        "[teleop] resume_ms: the pause after which it takes a fresh press ",
    );
    refused("[teleop]\nresume_ms = 150\n", "no shorter than a command or hold-to-run stands");
    refused("[teleop]\nrobot_from_hand = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\n", "[teleop] robot_from_hand: ");
    refused("[teleop]\nlock_turns = true\nturn_scale = 0.5\n", "[teleop] lock_turns, turn_scale: ");
    refused(
        "[teleop]\nrobot_from_hand = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\nrobot_from_hand_rpy_deg = [0, 0, 0]\n",
        "leave one of both out",
    );
    refused("[workspace]\nmin_mm = [0, 950, 0]\n", "[workspace] min_mm, max_mm: each least");
    refused("[governor]\nmax_jerk_deg_s3 = [1, 1, 1, 1, 1, -1]\n", "[governor] max_");
    refused("[governor]\nlimit_margin_deg = nan\n", "[governor] limit_margin_deg: 0 to 57.29");
    refused("[governor]\ncreep_from_mm = 1\n", "[governor] full_speed_to_mm, creep_from_mm, ");
    refused("[governor]\nspeed_share = 2\n", "[governor] speed_share: above 0 and at most 1");
    refused("[governor]\nhome_speed_share = 0\n", "[governor] home_speed_share: 0.05 to 1");
    refused("[governor]\nhome_deg = [0, 45, -180, 0, nan, 0]\n", "[governor] home_deg: joint 5: an angle");
    refused("[governor]\nhome_deg = [0, 45, -180, 0, 45]\n", "home_deg");
    refused(
        "[governor]\nhome_deg = [0, 45, -180, 0, 45, 0]\n[workspace]\nmax_mm = [900, 900, 50]\n",
        "[governor] home_deg: there the tool must be in the workspace",
    );
    assert_eq!(parse("[governor]\ncycle_ms = 5\n").unwrap().slave.governor.cycle_us, 5_000);
    // a faster arm takes longer to stop
    refused(
        "[arm]\nmax_speed_deg_s = [1000, 90, 90, 90, 90, 90]\n",
        "[governor] max_acceleration_deg_s2, max_jerk_deg_s3: joint 1 would take over 2 s",
    );
    refused("[slave]\nport = \"usb\"\n", "[slave] port: usb: this is no arm's address");
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let error = ArmSettings::load(Path::new("/nowhere/tetrad.toml")).unwrap_err();
    assert_eq!(error.to_string(), "cannot read /nowhere/tetrad.toml");
}

#[test]
fn the_slave_table_has_its_own_keys() {
    let settings = parse("[slave]\nlead_ms = 0\nmax_following_deg = 10\nblind_timeout_ms = 50\n").unwrap();
    assert_eq!((settings.slave.lead_us, settings.slave.blind_timeout_us), (0, 50_000));
    assert!((settings.slave.max_following_rad - 10.0_f64.to_radians()).abs() < 1e-15);
    refused("[slave]\nlead_ms = 501\n", "[slave] lead_ms");
    refused("[slave]\nlead_ms = -1\n", "[slave] lead_ms");
    refused("[slave]\nlead_ms = nan\n", "[slave] lead_ms");
    refused("[slave]\nmax_following_deg = 0\n", "[slave] max_following_deg");
    refused("[slave]\nblind_timeout_ms = 0\n", "[slave] blind_timeout_ms");
    refused("[slave]\nprot = 'sim:'\n", "prot");
}
