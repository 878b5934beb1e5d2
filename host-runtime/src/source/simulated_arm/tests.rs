//! That the drawing is of the arm: where it is said to be, from both eyes, the same each time.

use super::*;

const SIZE: (u16, u16) = (640, 480);

/// In degrees: the elbow and the wrist bent, the tool in front of the arm.
const READY: Joints<f64> = [0.0, 45.0, -180.0, 0.0, 45.0, 0.0];

const POSES: [(&str, Joints<f64>); 4] = [
    ("ready", READY),
    ("up", [0.0, 90.0, -90.0, 0.0, 0.0, 0.0]),
    ("low", [-40.0, 20.0, -190.0, 30.0, 60.0, 45.0]),
    ("side", [70.0, 60.0, -150.0, 0.0, 30.0, 0.0]),
];

fn drawing(view: View) -> ArmDrawing {
    ArmDrawing::new(&PumaConfig::default(), view, SIZE).unwrap()
}

fn at(degrees: Joints<f64>) -> Joints<f64> {
    degrees.map(f64::to_radians)
}

/// Where a colour is on average, and on how many pixels.
fn centre(rgb: &[u8], is: impl Fn(&[u8]) -> bool) -> (f32, f32, u32) {
    let (mut u, mut v, mut count) = (0.0, 0.0, 0);
    for (pixel, value) in rgb.chunks(3).enumerate() {
        if is(value) {
            (u, v) = (u + (pixel % 640) as f32, v + (pixel / 640) as f32);
            count += 1;
        }
    }
    (u / count as f32, v / count as f32, count)
}

/// The finger, whatever light falls on it; not the red axis of the floor.
fn orange(rgb: &[u8]) -> bool {
    let [r, g, b] = [rgb[0], rgb[1], rgb[2]].map(u16::from);
    r > 90 && 5 * g > 2 * r && 2 * g < r + 24 && 3 * b < r
}

/// Writes pictures to look at: `TETRAD_PICTURES=DIR cargo test -p tetrad --lib simulated_arm`.
fn show(name: &str, rgb: &[u8]) {
    let Ok(dir) = std::env::var("TETRAD_PICTURES") else { return };
    let file = std::fs::File::create(std::path::Path::new(&dir).join(format!("{name}.png"))).unwrap();
    let mut encoder = png::Encoder::new(file, u32::from(SIZE.0), u32::from(SIZE.1));
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(rgb).unwrap();
}

/// FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3)
    })
}

#[test]
fn the_same_joints_are_the_same_picture() {
    let mut drawing = drawing(View::Left);
    let first = hash(drawing.draw(&at(READY)));
    for (_, joints) in POSES {
        drawing.draw(&at(joints));
    }
    let picture = drawing.draw(&at(READY));
    assert_eq!(hash(picture), first, "nothing is left of the pictures between");
    assert_eq!(first, HASH, "0x{first:016X}: look at the picture, then write this down");
}

const HASH: u64 = 0xEC13_AEB5_02E0_F408;

#[test]
fn what_turns_is_seen_to_turn_and_both_eyes_see_it() {
    for (name, joints) in POSES {
        let [left, right] = [View::Left, View::Right].map(|view| drawing(view).draw(&at(joints)).to_vec());
        show(&format!("{name}-left"), &left);
        show(&format!("{name}-right"), &right);
        let differing = left.chunks(3).zip(right.chunks(3)).filter(|(a, b)| a != b).count();
        assert!(differing > 5_000, "{name}: {differing}");
        let moved = drawing(View::Left).draw(&at(joints.map(|degrees| degrees + 1.0))).to_vec();
        let differing = left.chunks(3).zip(moved.chunks(3)).filter(|(a, b)| a != b).count();
        assert!(differing > 1_000, "{name}, a degree on: {differing}");
    }
}

/// The orange finger is where the arm's own kinematics say, in both eyes.
#[test]
fn the_tool_is_drawn_where_it_is() {
    for (name, joints) in POSES {
        let puma = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
        let tool = single(&puma.forward(&at(joints)));
        let finger = tool.translation + tool.rotation * Vector3::new(0.042, 0.0, 0.075);
        for view in [View::Left, View::Right] {
            let mut drawing = drawing(view);
            let expected = drawing.raster.eye.project(&finger).unwrap();
            let (u, v, count) = centre(drawing.draw(&at(joints)), orange);
            assert!(count > 60, "{name}: {count} pixels");
            let off = (u - expected[0]).hypot(v - expected[1]);
            assert!(off < 8.0, "{name} {view:?}: {off} px, {u} {v} and not {expected:?}");
        }
    }
}

#[test]
fn whatever_the_joints_are_there_is_a_picture() {
    let mut drawing = ArmDrawing::new(&PumaConfig::default(), View::Right, (64, 48)).unwrap();
    for angle in [0.0, 1e3, f64::MAX, f64::INFINITY, f64::NAN] {
        assert_eq!(drawing.draw(&[angle; JOINTS]).len(), 64 * 48 * 3);
    }
}

/// `cargo test --release -p tetrad --lib simulated_arm -- --ignored --nocapture`
#[test]
#[ignore = "a measurement"]
fn how_long_a_picture_takes() {
    let mut drawing = drawing(View::Left);
    let began = std::time::Instant::now();
    for step in 0..200 {
        drawing.draw(&at(READY.map(|degrees| degrees + 0.1 * f64::from(step))));
    }
    println!("{:.2} ms a picture of 640x480", began.elapsed().as_secs_f64() * 5.0);
}
