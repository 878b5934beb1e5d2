//! What is wrong with the input is said once, by name, with the right exit code, and what was written
//! before it stays.

mod common;

use common::{Clip, csv, json, tetrad, write_png};
use std::fs;

const TRACK: &str = "track --left left --right right --scene scene.json --out out";

#[test]
fn unequal_frame_counts_are_both_named_after_the_common_part() {
    let clip = Clip::of("still", 5);
    for frame in 3..5 {
        fs::remove_file(clip.frame("right", frame)).unwrap();
    }
    let words = ["left has 5 frames", "right has 3"];
    let ran = clip.tetrad(TRACK).refused(1, &words);
    assert_eq!(ran.stdout, "");
    assert_eq!(csv(&clip.path("out/observations.csv")).len(), 1 + 3 * 8);
    assert_eq!(csv(&clip.path("out/pose.csv")).len(), 1 + 3);
    let summary = json(&clip.path("out/summary.json"));
    assert_eq!((summary["frames"].as_u64(), summary["complete"].as_bool()), (Some(3), Some(false)));
    assert!(summary["stopped_by"].as_str().unwrap().contains("right has 3"), "{summary}");
}

#[test]
fn a_picture_that_is_missing_in_one_camera_is_named_before_pairs_go_wrong() {
    let clip = Clip::of("still", 5);
    fs::remove_file(clip.frame("left", 2)).unwrap();
    clip.tetrad(TRACK).refused(1, &["the left source lacks picture 2", "2 pairs"]);
    assert_eq!(csv(&clip.path("out/pose.csv")).len(), 1 + 2);
}

#[test]
fn recordings_of_equal_length_that_begin_and_end_apart_are_not_paired() {
    let clip = Clip::of("still", 4);
    fs::remove_file(clip.frame("right", 0)).unwrap();
    let words = ["left frame 0", "right frame 1", "the right source lacks picture 0"];
    // as well when only the first picture of one is missing
    clip.tetrad(TRACK).refused(2, &words);
    fs::remove_file(clip.frame("left", 3)).unwrap();
    clip.tetrad(TRACK).refused(2, &words);
    assert!(!clip.path("out/pose.csv").exists());
}

#[test]
fn recorded_times_that_are_apart_are_both_named() {
    let clip = Clip::of("still", 3);
    let write = |view: &str, text: &str| fs::write(clip.path(view).join("timestamps.csv"), text).unwrap();
    write("left", "frame,t\n0,0\n1,0.1\n2,0.2\n");
    write("right", "frame,t\n0,0.01\n1,0.11\n2,0.31\n");
    clip.tetrad(TRACK).refused(1, &["left frame 2 was taken at 0.2 s", "right frame 2 at 0.31 s"]);
    assert_eq!(csv(&clip.path("out/pose.csv")).len(), 1 + 2);
    write("right", "frame,t\n0,0.01\n1,0.11\n2,0.21\n");
    clip.tetrad(TRACK).done();
}

#[test]
fn a_truncated_picture_is_named_and_the_frames_before_it_are_kept() {
    let clip = Clip::of("still", 4);
    let path = clip.frame("left", 2);
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    clip.tetrad(TRACK).refused(1, &["left", "0002.png"]);
    assert_eq!(csv(&clip.path("out/observations.csv")).len(), 1 + 2 * 8);
    assert_eq!(csv(&clip.path("out/motion.csv")).len(), 1 + 2);
    assert_eq!(json(&clip.path("out/summary.json"))["frames"].as_u64(), Some(2));
}

#[test]
fn a_seed_outside_the_picture_names_the_ball_and_the_size() {
    let clip = Clip::of("still", 1);
    let scene = fs::read_to_string(clip.path("scene.json")).unwrap();
    let (u, v) = clip.seed(1, tetrad_core::observation::Ball::Blue);
    fs::write(clip.path("scene.json"), scene.replace(&format!("[{u}, {v}]"), "[640, 10]")).unwrap();
    clip.tetrad(TRACK).refused(2, &["scene.json", "right", "blue", "640x480"]);
    assert!(!clip.path("out/observations.csv").exists());
}

#[test]
fn a_seed_that_teaches_nothing_names_the_ball_and_the_reason() {
    let clip = Clip::of("static-16px", 1);
    let scene = fs::read_to_string(clip.path("scene.json")).unwrap();
    let (u, v) = clip.seed(0, tetrad_core::observation::Ball::Yellow);
    fs::write(clip.path("scene.json"), scene.replace(&format!("[{u}, {v}]"), "[20, 20]")).unwrap();
    clip.tetrad(TRACK)
        .refused(1, &["scene.json", "seeds.left", "yellow at (20, 20)", "point inside the ball"]);
}

#[test]
fn a_picture_of_one_pixel_is_refused() {
    let clip = Clip::of("still", 1);
    let (u, v) = clip.seed(0, tetrad_core::observation::Ball::Red);
    clip.tetrad(&format!("learn --source left --at red={u},{v} --out red.toml")).done();
    for view in ["left", "right"] {
        write_png(&clip.frame(view, 0), (1, 1), png::ColorType::Rgb, png::BitDepth::Eight, &[9, 9, 9]);
    }
    clip.tetrad(TRACK).refused(2, &["red", "1x1"]);
    let track = "track --left left --colours-left red.toml --balls red --out out";
    clip.tetrad(track).refused(2, &["left", "1x1", "red"]);
    clip.tetrad("learn --source left --at red=0,0 --out c.toml").refused(1, &["red at (0, 0)", "1x1"]);
    assert!(!clip.path("c.toml").exists());
}

#[test]
fn colours_that_cannot_be_used_name_the_file_and_the_key() {
    let clip = Clip::of("still", 1);
    let (u, v) = clip.seed(0, tetrad_core::observation::Ball::Red);
    clip.tetrad(&format!("learn --source left --at red={u},{v} --out red.toml")).done();
    let red = fs::read_to_string(clip.path("red.toml")).unwrap();
    let track = "track --left left --out out --colours-left";
    clip.tetrad(&format!("{track} red.toml")).refused(2, &["red.toml", "[green]", "missing"]);
    clip.tetrad(&format!("{track} red.toml --balls red")).done();

    let line = red.lines().find(|line| line.starts_with("typical")).unwrap();
    fs::write(clip.path("nan.toml"), red.replace(line, "typical = [nan, 1, 2]")).unwrap();
    clip.tetrad(&format!("{track} nan.toml --balls red"))
        .refused(2, &["nan.toml", "[red] typical", "0 to 255"]);
    clip.tetrad(&format!("{track} none.toml --balls red")).refused(2, &["none.toml", "No such file"]);
}

#[test]
fn a_source_that_is_not_there_is_a_bad_argument() {
    let clip = Clip::of("still", 1);
    clip.tetrad("track --left nowhere --scene scene.json --out out").refused(2, &["nowhere"]);
    fs::create_dir(clip.path("empty")).unwrap();
    clip.tetrad("track --left empty --scene scene.json --out out").refused(2, &["empty", "no PNG or JPEG"]);
}

#[test]
fn wrong_usage_is_exit_code_2_and_help_is_0() {
    let dir = tempfile::tempdir().unwrap();
    for arguments in
        ["", "trakc", "track", "track --left a --scene s --colours-left c --out o", "demo --second 3"]
    {
        assert_eq!(tetrad(dir.path(), arguments).code, Some(2), "{arguments:?}");
    }
    tetrad(dir.path(), "track --left a --scene s.json --mode other --out o")
        .refused(2, &["other", "refined", "paper"]);
    tetrad(dir.path(), "demo --seconds nan").refused(2, &["--seconds"]);
    tetrad(dir.path(), "demo --scene nothing").refused(2, &["nothing", "linear-0.5-30fps"]);
    for command in ["track", "learn", "demo", "keys"] {
        let help = tetrad(dir.path(), &format!("{command} --help")).done().stdout;
        assert!(help.contains("Examples:") && help.contains(&format!("tetrad {command}")), "{help}");
    }
}

#[test]
fn results_that_cannot_be_written_name_the_path() {
    let clip = Clip::of("still", 1);
    fs::write(clip.path("file"), "").unwrap();
    clip.tetrad("track --left left --scene scene.json --out file/out").refused(2, &["file/out"]);
    fs::create_dir_all(clip.path("out/pose.csv")).unwrap();
    clip.tetrad(TRACK).refused(1, &["cannot write out/pose.csv"]);
}

#[test]
fn an_earlier_summary_does_not_outlive_the_start_of_another_run() {
    let clip = Clip::of("still", 2);
    clip.tetrad(TRACK).done();
    assert_eq!(json(&clip.path("out/summary.json"))["complete"].as_bool(), Some(true));
    fs::remove_file(clip.frame("left", 0)).unwrap();
    clip.tetrad(TRACK).refused(2, &["the left source lacks picture 0"]);
    assert!(!clip.path("out/summary.json").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_printed_are_a_failure() {
    let clip = Clip::of("still", 1);
    let print = |arguments: &str| {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_tetrad"));
        program.args(arguments.split_whitespace()).current_dir(&clip.dir).stdout(full).output().unwrap()
    };
    let output = print(TRACK);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("cannot write to standard output"), "{stderr}");
    assert_eq!(json(&clip.path("out/summary.json"))["complete"].as_bool(), Some(true));
    assert_eq!(print("--help").status.code(), Some(1));
    assert_eq!(print("trakc").status.code(), Some(2));
}
