use super::*;
use crate::source::View;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_fixtures::Scene;

fn open_scene(spec: &str, view: View) -> Result<Box<dyn Source>, SourceError> {
    open(spec, &Options { view, ..Options::default() })
}

#[test]
fn a_scene_is_delivered_as_it_is_rendered() {
    let scene = Scene::named("demo").unwrap();
    let mut rendered = Vec::new();
    for view in [View::Left, View::Right] {
        let mut source = open_scene("sim:demo", view).unwrap();
        let info = source.info().clone();
        assert_eq!((info.width, info.height), (scene.width, scene.height));
        assert_eq!((info.fps, info.frames), (Some(scene.fps), Some(scene.frames() as u64)));
        assert!(!info.live);
        for number in 0..2 {
            scene.render_rgb(number, view.index(), &mut rendered);
            let frame = source.next().unwrap().unwrap();
            assert_eq!((frame.index, frame.number), (number as u64, number as u64));
            assert_eq!(frame.t_s, scene.time_s(number));
            for (x, y) in [(0, 0), (320, 240), (639, 479), (17, 400)] {
                let at = (y * i32::from(scene.width) + x) as usize * 3;
                let [r, g, b] = [rendered[at], rendered[at + 1], rendered[at + 2]];
                assert_eq!(frame.view.pixel(x, y), Some(Rgb { r, g, b }), "{view:?} {number} ({x}, {y})");
            }
        }
    }
}

#[test]
fn a_scene_ends_after_its_last_frame() {
    let mut source = open_scene("sim:static-8px", View::Left).unwrap();
    let frames = source.info().frames.unwrap();
    let (seen, error) = read_all(source.as_mut());
    assert!(error.is_none());
    assert_eq!(seen.len() as u64, frames);
    assert!(source.next().unwrap().is_none());
}

#[test]
fn pictures_come_in_the_format_asked_for() {
    for (name, format, tolerance) in [
        ("rgb", PixelFormat::Rgb888, 0),
        ("bgr", PixelFormat::Bgr888, 0),
        ("rgba", PixelFormat::Rgba8888, 0),
        ("rgb565le", PixelFormat::Rgb565Le, 4),
        ("rgb565be", PixelFormat::Rgb565Be, 4),
        ("yuyv", PixelFormat::Yuyv, 12),
        ("uyvy", PixelFormat::Uyvy, 12),
        ("nv12", PixelFormat::Nv12, 12),
    ] {
        let mut plain = open_scene("sim:demo", View::Left).unwrap();
        let mut source = open_scene(&format!("sim:demo?format={name}"), View::Left).unwrap();
        assert_eq!(source.info().format, format);
        let (plain, frame) = (plain.next().unwrap().unwrap(), source.next().unwrap().unwrap());
        assert_eq!(frame.view.format(), format);
        // The centre of a background pixel block: chroma is shared there too, yet changes little.
        let (expected, found) = (plain.view.pixel(40, 40).unwrap(), frame.view.pixel(40, 40).unwrap());
        for (a, b) in [(expected.r, found.r), (expected.g, found.g), (expected.b, found.b)] {
            assert!(a.abs_diff(b) <= tolerance, "{name}: {expected:?} became {found:?}");
        }
    }
}

#[test]
fn an_unknown_scene_lists_the_known_ones_alike_first() {
    let error = refusal(open_scene("sim:dimmed", View::Left));
    assert_says(
        &error,
        Exit::BadArguments,
        &["sim:dimmed", "'dimmed'", "there are dimming, d", "and", "more"],
    );
    let error = refusal(open_scene("sim:", View::Left));
    assert_says(&error, Exit::BadArguments, &["demo"]);
}
