use super::*;
use clap::Parser;
use std::fs;
use tempfile::TempDir;

/// Parses flags as the program does.
#[derive(Parser)]
struct Flags {
    #[command(flatten)]
    args: TrackArgs,
}

const BALL: &str = "reference = [120, 120, 120]\ntypical = [198, 44, 55]\nbackground = [120, 118, 110]\ndiameter_px = 16.5\n";

/// A directory with colours of all four balls, of red alone, and a scene.
fn files() -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    let ball = |name: &str, typical: &str| format!("[{name}]\n{}", BALL.replace("[198, 44, 55]", typical));
    let four = ball("red", "[198, 44, 55]")
        + &ball("green", "[44, 198, 55]")
        + &ball("blue", "[44, 55, 198]")
        + &ball("yellow", "[198, 190, 40]");
    fs::write(dir.path().join("four.toml"), four).unwrap();
    fs::write(dir.path().join("red.toml"), ball("red", "[198, 44, 55]")).unwrap();
    let scene = r#"{"fps": 25, "arm_m": 0.08, "seeds": {"left": {"red": [1, 2], "blue": [3, 4]},
                    "right": {"red": [5, 6], "blue": [7, 8]}}}"#;
    fs::write(dir.path().join("scene.json"), scene).unwrap();
    let loose = r#"{"rigid": false, "arm_m": 0.08, "seeds": {"left":
                    {"red": [1, 2], "green": [1, 2], "blue": [3, 4], "yellow": [3, 4]}}}"#;
    fs::write(dir.path().join("loose.json"), loose).unwrap();
    fs::write(dir.path().join("one.json"), r#"{"seeds": {"left": {"red": [1, 2]}}}"#).unwrap();
    dir
}

fn check(dir: &TempDir, flags: &str) -> Result<TrackSettings, String> {
    let at = |word: &str| {
        if word.ends_with(".toml") || word.ends_with(".json") {
            dir.path().join(word).display().to_string()
        } else {
            word.to_owned()
        }
    };
    let words = ["track".to_owned()].into_iter().chain(flags.split_whitespace().map(at));
    let args = Flags::try_parse_from(words).map_err(|e| e.to_string())?.args;
    TrackSettings::new(args).map_err(|failure| {
        assert_eq!(failure.exit, Exit::BadArguments, "{failure}");
        failure.to_string()
    })
}

#[test]
fn two_cameras_with_colours() {
    let dir = files();
    let flags = "--left a --right b --colours-left four.toml --colours-right four.toml --arm-mm 80 --out o";
    let settings = check(&dir, flags).unwrap();
    assert_eq!(
        settings.input.cameras.iter().map(|c| (c.name, c.source.as_str())).collect::<Vec<_>>(),
        [("left", "a"), ("right", "b")]
    );
    assert!(settings.input.rigid && settings.input.has_pose() && settings.input.balls.is_all());
    assert_eq!(settings.input.arm_m, Some(0.08));
}

#[test]
fn fewer_balls_are_independent_and_have_no_pose() {
    let dir = files();
    let settings = check(&dir, "--left a --colours-left red.toml --balls red --out o").unwrap();
    assert!(!settings.input.rigid && !settings.input.has_pose());
    let settings = check(&dir, "--left a --colours-left four.toml --balls red --out o").unwrap();
    let Start::Colours(colours) = &settings.input.cameras[0].start else { panic!("colours were given") };
    assert_eq!(BallSet::known(&colours.balls), Some(settings.input.balls));
}

#[test]
fn one_camera_has_a_pose_when_it_is_asked_for() {
    let dir = files();
    let flags = "--left a --colours-left four.toml --arm-mm 80 --focal-left 812.5 --out o";
    let settings = check(&dir, flags).unwrap();
    assert!(!settings.input.has_pose());
    assert_eq!(settings.input.cameras[0].focal_px, Some(812.5));
    assert!(check(&dir, &format!("{flags} --one-camera-pose")).unwrap().input.has_pose());
}

#[test]
fn a_scene_gives_seeds_rate_and_arm() {
    let dir = files();
    let settings = check(&dir, "--left a --right b --scene scene.json --out o").unwrap();
    assert_eq!(settings.input.balls.to_string(), "red,blue");
    assert_eq!((settings.input.fps, settings.input.arm_m), (Some(25.0), Some(0.08)));
    let settings =
        check(&dir, "--left a --right b --scene scene.json --balls blue --arm-mm 50 --out o").unwrap();
    assert_eq!(settings.input.arm_m, Some(0.05));
    for camera in settings.input.cameras {
        let Start::Seeds { seeds, .. } = camera.start else { panic!("seeds were given") };
        assert_eq!(BallSet::known(&seeds).unwrap().to_string(), "blue");
    }
}

#[test]
fn the_bounds_of_an_arm_are_the_solvers_and_the_helps() {
    use clap::CommandFactory as _;
    let dir = files();
    for mm in [5.0, 2000.0] {
        let flags = format!("--left a --colours-left four.toml --arm-mm {mm} --out o");
        let arm_m = check(&dir, &flags).unwrap().input.arm_m.unwrap();
        assert!(tetrad_core::hand::affine::Arms::equal(arm_m).is_ok(), "{mm} mm");
    }
    let help = Flags::command().render_help().to_string();
    // as one line, however it is wrapped
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("in millimetres, 5 to 2000"), "{help}");
}

#[test]
fn what_is_missing_or_contradicts_is_named() {
    let dir = files();
    let cases = [
        ("--left a --out o", "<--colours-left <FILE>|--scene <FILE>>"),
        ("--colours-left four.toml --out o", "--left"),
        ("--left a --colours-left four.toml", "--out"),
        ("--left a --colours-left four.toml --scene scene.json --out o", "cannot be used with"),
        (
            "--left a --right b --colours-left four.toml --arm-mm 80 --out o",
            "--right is given without --colours-right",
        ),
        ("--left a --right b --colours-left four.toml --colours-right four.toml --out o", "--arm-mm"),
        ("--left a --colours-left four.toml --arm-mm 0 --out o", "--arm-mm 0: a length from 5 to 2000 mm"),
        ("--left a --colours-left four.toml --arm-mm 4.9 --out o", "--arm-mm 4.9: a length from 5 to 2000"),
        ("--left a --colours-left four.toml --arm-mm 2001 --out o", "--arm-mm 2001: a length from 5 to 2000"),
        ("--left a --colours-left four.toml --arm-mm NaN --out o", "--arm-mm NaN"),
        ("--left a --colours-left four.toml --arm-mm x --out o", "invalid value 'x'"),
        ("--left a --colours-left four.toml --mode other --out o", "invalid value 'other'"),
        (
            "--left a --colours-left four.toml --focal-left 10 --out o",
            "--focal-left 10: a focal length from 50 to 50000",
        ),
        ("--left a --colours-left four.toml --focal-left NaN --out o", "--focal-left NaN"),
        ("--left a --colours-left four.toml --focal-right 800 --out o", "--right"),
        (
            "--left a --colours-left four.toml --arm-mm 80 --one-camera-pose --mode paper --out o",
            "the paper's method needs two cameras",
        ),
        ("--left a --colours-left four.toml --one-camera-pose --out o", "--arm-mm"),
        ("--left a --colours-left four.toml --balls red --one-camera-pose --out o", "needs all four balls"),
        ("--left a --scene loose.json --one-camera-pose --out o", "loose.json: rigid is false"),
        ("--left a --colours-left four.toml --balls red,pink --out o", "`pink`"),
        ("--left a --colours-left red.toml --out o", "the green ball is missing"),
        ("--left a --colours-left none.toml --out o", "none.toml"),
        ("--left a --scene scene.json --balls green --out o", "no seed for green"),
        ("--left a --right b --scene one.json --out o", "seeds.right is missing"),
    ];
    for (flags, words) in cases {
        let message = check(&dir, flags).expect_err(flags);
        assert!(message.contains(words), "{flags}: {message}");
    }
}
