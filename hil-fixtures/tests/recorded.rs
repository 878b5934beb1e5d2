//! The small frames in `data/`, for programs that cannot render: they are what the scenes give, and
//! the truth beside them is theirs.

use std::fmt::Write as _;
use tetrad_core::observation::Ball;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_fixtures::{Scene, golden, to_format};

/// Top left corner of the part that is kept, in the whole picture.
const CORNER: (usize, usize) = (250, 180);

/// Its width and height.
const SIZE: (usize, usize) = (160, 120);

const SIDES: [&str; 2] = ["left", "right"];

/// RGB888 of the part of frame 0 of `still` that is kept.
fn part(camera: usize) -> Vec<u8> {
    let scene = Scene::named("still").expect("a scene of that name");
    let mut rgb = Vec::new();
    scene.render_rgb(0, camera, &mut rgb);
    let stride = 3 * usize::from(scene.width);
    let rows = rgb.chunks_exact(stride).skip(CORNER.1).take(SIZE.1);
    rows.flat_map(|row| &row[3 * CORNER.0..3 * (CORNER.0 + SIZE.0)]).copied().collect()
}

#[test]
fn recorded_frames_are_those_of_still() {
    for (camera, side) in SIDES.iter().enumerate() {
        let bytes = to_format(&part(camera), SIZE.0 as u16, SIZE.1 as u16, PixelFormat::Rgb565Le);
        let file = golden::data(&format!("still_{side}_160x120.rgb565"));
        golden::check_file(&file, &bytes).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn recorded_truth_is_that_of_still() {
    let scene = Scene::named("still").expect("a scene of that name");
    let mut text = String::from(
        "# Where the balls are in the recorded frames of `still`: outline centre and diameter, pixels of\n\
         # the 160 x 120 frame, (0, 0) the centre of its top-left pixel.\n\
         # camera ball u v diameter\n",
    );
    for (camera, side) in SIDES.iter().enumerate() {
        for (ball, truth) in Ball::ALL.iter().zip(scene.truth(0, camera)) {
            let (u, v) = (truth.outline_centre.0 - CORNER.0 as f64, truth.outline_centre.1 - CORNER.1 as f64);
            assert!(u > 24.0 && u < SIZE.0 as f64 - 24.0, "{side} {ball:?}: {u}");
            assert!(v > 12.0 && v < SIZE.1 as f64 - 12.0, "{side} {ball:?}: {v}");
            // writing to a string cannot fail
            let _ = writeln!(text, "{side} {} {u:.3} {v:.3} {:.3}", ball.name(), truth.diameter);
        }
    }
    golden::check_file(&golden::data("still_160x120.txt"), text.as_bytes())
        .unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn recorded_frames_show_each_ball_where_the_truth_says() {
    let scene = Scene::named("still").expect("a scene of that name");
    for camera in 0..2 {
        let bytes = to_format(&part(camera), SIZE.0 as u16, SIZE.1 as u16, PixelFormat::Rgb565Le);
        let view = FrameView::packed(&bytes, SIZE.0 as u16, SIZE.1 as u16, PixelFormat::Rgb565Le)
            .expect("a whole picture");
        for (ball, truth) in Ball::ALL.iter().zip(scene.truth(0, camera)) {
            let (u, v) = (truth.outline_centre.0 - CORNER.0 as f64, truth.outline_centre.1 - CORNER.1 as f64);
            // a little below the middle, away from the highlight
            let pixel = view.pixel(u.round() as i32, v.round() as i32 + 3).expect("inside");
            let [r, g, b] = scene.colours()[ball.index()];
            let brightness = (f64::from(pixel.r) + f64::from(pixel.g) + f64::from(pixel.b)) / (r + g + b);
            for (is, albedo) in [pixel.r, pixel.g, pixel.b].into_iter().zip([r, g, b]) {
                let expected = albedo * brightness;
                assert!((f64::from(is) - expected).abs() < 16.0, "{ball:?}: {pixel:?}, colour {expected}");
            }
        }
    }
}
