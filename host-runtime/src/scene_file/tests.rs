use super::*;

const SCENE: &str = r#"{"fps": 30, "arm_m": 0.08, "ball_diameter_m": 0.03,
 "seeds": {"left": {"red": [312.5, 201], "green": [352, 204]},
           "right": {"red": [298.1, 203.3], "green": [340, 206]}}}"#;

fn problem(text: &str) -> String {
    SceneFile::parse(text, "scene.json").unwrap_err().to_string()
}

#[test]
fn a_scene_with_two_balls_is_read() {
    let scene = SceneFile::parse(SCENE, "scene.json").unwrap();
    assert_eq!((scene.fps, scene.arm_m, scene.ball_diameter_m), (Some(30.0), Some(0.08), Some(0.03)));
    assert_eq!(
        scene.left,
        [Some(ImagePoint::new(312.5, 201.0)), Some(ImagePoint::new(352.0, 204.0)), None, None]
    );
    assert_eq!(scene.right.unwrap()[0], Some(ImagePoint::new(298.1, 203.3)));
    assert_eq!(scene.balls().to_string(), "red,green");
    assert_eq!(scene.rigid, None);
}

#[test]
fn one_camera_and_no_lengths_are_enough() {
    let scene = SceneFile::parse(r#"{"seeds": {"left": {"blue": [1, 2]}}, "rigid": false}"#, "s").unwrap();
    assert_eq!((scene.fps, scene.arm_m, scene.right, scene.rigid), (None, None, None, Some(false)));
}

#[test]
fn every_bad_value_is_named_by_file_and_key() {
    let cases = [
        (
            "\"fps\": 30",
            "\"fps\": 0",
            "scene.json: fps: a number from 0.1 to 1000 frames/s is needed, not 0.0",
        ),
        (
            "\"fps\": 30",
            "\"fps\": 5e-324",
            "scene.json: fps: a number from 0.1 to 1000 frames/s is needed, not 5e-324",
        ),
        (
            "\"fps\": 30",
            "\"fps\": 1e300",
            "scene.json: fps: a number from 0.1 to 1000 frames/s is needed, not 1e300",
        ),
        (
            "\"fps\": 30",
            "\"fps\": NaN",
            "scene.json: fps: JSON has no NaN: a number is needed at line 1 column 9",
        ),
        (
            "\"fps\": 30",
            "\"fps\": -Infinity",
            "scene.json: fps: JSON has no -Infinity: a number is needed at line 1 column 9",
        ),
        (
            "[298.1, 203.3]",
            "[298.1, nan]",
            "scene.json: red: JSON has no nan: a number is needed at line 3 column 37",
        ),
        ("\"fps\": 30", "\"fps\": x", "scene.json: expected value at line 1"),
        ("\"fps\": 30", "\"fps\": 1e999", "scene.json: number out of range"),
        ("\"fps\": 30", "\"fps\": \"30\"", "scene.json: invalid type"),
        (
            "\"arm_m\": 0.08",
            "\"arm_m\": -0.08",
            "scene.json: arm_m: a number from 0.005 to 2 m is needed, not -0.08",
        ),
        (
            "\"arm_m\": 0.08",
            "\"arm_m\": 80",
            "scene.json: arm_m: a number from 0.005 to 2 m is needed, not 80",
        ),
        ("\"arm_m\": 0.08", "\"arm_mm\": 80", "unknown field `arm_mm`"),
        ("0.03", "0", "scene.json: ball_diameter_m: a number from 0.001 to 1 m"),
        ("\"green\": [352, 204]", "\"pink\": [352, 204]", "unknown field `pink`"),
        ("\"green\": [352, 204]", "\"green\": [352]", "scene.json: invalid length"),
        ("\"green\": [352, 204]", "\"red\": [352, 204]", "duplicate field `red`"),
        (", \"green\": [352, 204]", "", "scene.json: seeds.left.green: the green ball is missing"),
        (", \"green\": [340, 206]", "", "scene.json: seeds.right.green: the green ball is missing"),
        ("\"red\": [312.5, 201], \"green\": [352, 204]", "", "scene.json: seeds.left: it names no ball"),
        ("}}}", "}}", "scene.json: EOF"),
    ];
    for (from, to, words) in cases {
        assert!(SCENE.contains(from), "{from}");
        let message = problem(&SCENE.replacen(from, to, 1));
        assert!(message.starts_with("scene.json: ") && message.contains(words), "{to}: {message}");
    }
    assert!(problem(r#"{"fps": 30}"#).contains("missing field `seeds`"));
    assert!(problem(r#"{"seeds": {}}"#).contains("missing field `left`"));
}

#[test]
fn a_seed_outside_the_picture_is_named_with_the_pictures_size() {
    let seeds = |u, v| [None, None, None, Some(ImagePoint::new(u, v))];
    for (u, v) in [(-0.6, 0.0), (639.5, 0.0), (0.0, 479.5), (f32::NAN, 0.0), (0.0, f32::INFINITY)] {
        let error = check_seeds(&seeds(u, v), "right", (640, 480), "scene.json").unwrap_err();
        assert_eq!(error.key, "seeds.right.yellow", "{u} {v}");
        assert!(error.problem.contains("yellow") && error.problem.contains("640x480"), "{error}");
    }
    for (u, v) in [(-0.5, -0.5), (639.4, 479.4), (0.0, 0.0)] {
        assert_eq!(check_seeds(&seeds(u, v), "right", (640, 480), "scene.json"), Ok(()), "{u} {v}");
    }
}
