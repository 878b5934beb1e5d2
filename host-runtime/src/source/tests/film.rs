use super::*;
use std::path::PathBuf;
use tempfile::TempDir;
use tetrad_core::vision::frame::PixelFormat;

/// A film on the disk; the folder goes when this does.
struct Film {
    _folder: TempDir,
    path: PathBuf,
}

fn film(bytes: &[u8]) -> Film {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.y4m");
    std::fs::write(&path, bytes).unwrap();
    Film { _folder: folder, path }
}

/// A header and frames, each frame header followed by its planes.
fn bytes(header: &str, frames: &[(&str, &[u8])]) -> Vec<u8> {
    let mut bytes = format!("{header}\n").into_bytes();
    for (mark, planes) in frames {
        bytes.extend(format!("{mark}\n").into_bytes());
        bytes.extend(*planes);
    }
    bytes
}

/// A picture of 4 x 2 whose luma counts up from 100, U = 90 and 91, V = 200 and 201.
const QUARTER: [u8; 12] = [100, 101, 102, 103, 104, 105, 106, 107, 90, 91, 200, 201];

/// The same picture as YUYV rows, for comparison.
fn same_colours(view: &tetrad_core::vision::frame::FrameView<'_>, rows: &[u8]) {
    let expected = tetrad_core::vision::frame::FrameView::packed(rows, 4, 2, PixelFormat::Yuyv).unwrap();
    for y in 0..2 {
        for x in 0..4 {
            assert_eq!(view.pixel(x, y), expected.pixel(x, y), "({x}, {y})");
        }
    }
}

#[test]
fn each_sampling_gives_the_colours_of_its_samples() {
    let quarter_rows = [100, 90, 101, 200, 102, 91, 103, 201, 104, 90, 105, 200, 106, 91, 107, 201];
    let half: Vec<u8> = [100, 101, 102, 103, 104, 105, 106, 107, 90, 91, 92, 93, 200, 201, 202, 203].to_vec();
    let half_rows = [100, 90, 101, 200, 102, 91, 103, 201, 104, 92, 105, 202, 106, 93, 107, 203];
    let full: Vec<u8> = [
        [100, 101, 102, 103, 104, 105, 106, 107],
        [90, 90, 91, 91, 90, 90, 91, 91],
        [200, 200, 201, 201, 200, 200, 201, 201],
    ]
    .concat();
    for (tag, planes, format, rows) in [
        ("", &QUARTER[..], PixelFormat::Nv12, quarter_rows),
        (" C420jpeg", &QUARTER[..], PixelFormat::Nv12, quarter_rows),
        (" C420mpeg2", &QUARTER[..], PixelFormat::Nv12, quarter_rows),
        (" C420paldv", &QUARTER[..], PixelFormat::Nv12, quarter_rows),
        (" C422", &half, PixelFormat::Yuyv, half_rows),
        (" C444", &full, PixelFormat::Rgb888, quarter_rows),
    ] {
        let film = film(&bytes(&format!("YUV4MPEG2 W4 H2 F25:1 Ip A1:1{tag}"), &[("FRAME", planes)]));
        let mut source = open_path(&film.path).unwrap();
        assert_eq!(source.info().format, format, "{tag}");
        assert_eq!(source.info().frames, Some(1), "{tag}");
        same_colours(&source.next().unwrap().unwrap().view, &rows);
        assert!(source.next().unwrap().is_none());
    }
}

#[test]
fn full_range_luma_reaches_black_and_white() {
    let planes = [0, 0, 0, 0, 255, 255, 255, 255, 128, 128, 128, 128];
    let film = film(&bytes("YUV4MPEG2 W4 H2 F25:1 XCOLORRANGE=FULL", &[("FRAME", &planes)]));
    let mut source = open_path(&film.path).unwrap();
    let frame = source.next().unwrap().unwrap();
    assert_eq!(frame.view.pixel(0, 0), Some(Rgb::new(0, 0, 0)));
    assert_eq!(frame.view.pixel(0, 1), Some(Rgb::new(255, 255, 255)));
}

#[test]
fn frames_are_timed_by_the_films_rate() {
    let frames = [("FRAME", &QUARTER[..]), ("FRAME Ip", &QUARTER[..]), ("FRAME", &QUARTER[..])];
    for (header, given, fps) in [
        ("YUV4MPEG2 W4 H2 F30000:1001", Some(5.0), 30_000.0 / 1001.0),
        ("YUV4MPEG2 W4 H2 F0:0", Some(5.0), 5.0),
        ("YUV4MPEG2 W4 H2", None, 30.0),
    ] {
        let film = film(&bytes(header, &frames));
        let options = Options { fps: given, ..Options::default() };
        let mut source = open(film.path.to_str().unwrap(), &options).unwrap();
        assert_eq!(source.info().fps, Some(fps));
        assert_eq!(source.info().frames, None, "frame headers of unequal length are not counted beforehand");
        let (seen, error) = read_all(source.as_mut());
        assert!(error.is_none());
        assert_eq!(seen.iter().map(|frame| frame.number).collect::<Vec<_>>(), [0, 1, 2]);
        assert!((seen[2].t_s - 2.0 / fps).abs() < 1e-12);
    }
}

#[test]
fn headers_that_cannot_be_tracked_are_refused_with_a_reason() {
    for (header, words) in [
        ("RIFF....AVI ", vec!["YUV4MPEG2"]),
        ("YUV4MPEG2X W4 H2", vec!["YUV4MPEG2"]),
        ("YUV4MPEG2 H2 F25:1", vec!["no width"]),
        ("YUV4MPEG2 W4 F25:1", vec!["no height"]),
        ("YUV4MPEG2 Wx H2", vec!["width", "'x'"]),
        ("YUV4MPEG2 W-4 H2", vec!["width", "'-4'"]),
        ("YUV4MPEG2 W0 H2", vec!["width", "0 pixels"]),
        ("YUV4MPEG2 W4 H8194", vec!["height", "8194", "8192"]),
        ("YUV4MPEG2 W18446744073709551615 H18446744073709551615 C444", vec!["width", "8192"]),
        ("YUV4MPEG2 W99999999999999999999999 H2", vec!["width", "no number"]),
        ("YUV4MPEG2 W5 H2", vec!["5 x 2", "even"]),
        ("YUV4MPEG2 W4 H3", vec!["4 x 3", "even"]),
        ("YUV4MPEG2 W5 H3 C422", vec!["5 x 3", "even"]),
        ("YUV4MPEG2 W4 H2 F25", vec!["frame rate", "25"]),
        ("YUV4MPEG2 W4 H2 F25:0", vec!["frame rate", "25:0"]),
        ("YUV4MPEG2 W4 H2 F0:1", vec!["frame rate", "0:1"]),
        ("YUV4MPEG2 W4 H2 F-25:1", vec!["frame rate", "-25:1"]),
        ("YUV4MPEG2 W4 H2 F25:1 It", vec!["interlaced", "yadif"]),
        ("YUV4MPEG2 W4 H2 Cmono", vec!["grey"]),
        ("YUV4MPEG2 W4 H2 Cmono12", vec!["grey"]),
        ("YUV4MPEG2 W4 H2 C420p10", vec!["420p10", "8-bit", "yuv420p"]),
        ("YUV4MPEG2 W4 H2 C411", vec!["411", "yuv420p"]),
        ("YUV4MPEG2 W4 H2 C444alpha", vec!["444alpha", "yuv420p"]),
    ] {
        let film = film(&bytes(header, &[("FRAME", &QUARTER)]));
        let mut words = words;
        words.push("clip.y4m");
        assert_says(&refusal(open_path(&film.path)), Exit::Failed, &words);
    }
    let endless = film(&[b'Y'; 5000]);
    assert_says(&refusal(open_path(&endless.path)), Exit::Failed, &["does not begin"]);
    for cut in ["", "YUV4MPEG2 W4 H2"] {
        let film = film(cut.as_bytes());
        assert_says(&refusal(open_path(&film.path)), Exit::Failed, &["ends within its header"]);
    }
}

#[test]
fn odd_sizes_are_fine_without_shared_chroma() {
    let film = film(&bytes("YUV4MPEG2 W1 H1 C444", &[("FRAME", &[16, 128, 128])]));
    let (seen, error) = read_all(open_path(&film.path).unwrap().as_mut());
    assert!(error.is_none());
    assert_eq!(seen[0].corner, Rgb::new(0, 0, 0));
}

#[test]
fn a_film_cut_off_anywhere_delivers_its_whole_frames_and_says_where() {
    let header = "YUV4MPEG2 W4 H2 F25:1";
    let whole = bytes(header, &[("FRAME", &QUARTER), ("FRAME", &QUARTER), ("FRAME", &QUARTER)]);
    let start = header.len() + 1;
    let each = "FRAME\n".len() + QUARTER.len();
    for length in start..whole.len() {
        let film = film(&whole[..length]);
        let (seen, error) = read_all(open_path(&film.path).unwrap().as_mut());
        let frames = (length - start) / each;
        assert_eq!(seen.len(), frames, "{length} bytes");
        if (length - start).is_multiple_of(each) {
            assert!(error.is_none(), "{length} bytes");
        } else {
            let place = format!("frame {frames} (at byte {})", start + frames * each);
            assert_says(&error.unwrap(), Exit::Failed, &["clip.y4m", &place]);
        }
    }
}

#[test]
fn what_is_no_frame_is_named_with_its_byte() {
    for mark in ["FRAMES", "frame", "", "XXXXX"] {
        let film = film(&bytes("YUV4MPEG2 W4 H2 F25:1", &[("FRAME", &QUARTER), (mark, &QUARTER)]));
        let (seen, error) = read_all(open_path(&film.path).unwrap().as_mut());
        assert_eq!(seen.len(), 1);
        assert_says(&error.unwrap(), Exit::Failed, &["frame 1 (at byte 40)", "no frame begins here"]);
    }
}

proptest::proptest! {
    #[test]
    fn no_header_makes_it_panic_or_take_memory_without_bound(
        parameters in proptest::collection::vec("[WHFICAX]([0-9]{1,20}|[0-9:p?tb]{0,6}|4[124][024](jpeg|p10)?|COLORRANGE=FULL)", 0..7),
        tail in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..40),
    ) {
        let mut bytes = format!("YUV4MPEG2 {}\nFRAME\n", parameters.join(" ")).into_bytes();
        bytes.extend(tail);
        let film = film(&bytes);
        // Without an error every frame delivered was in the file, and that is short.
        if let Ok(mut source) = open_path(&film.path) {
            let (seen, _) = read_all(source.as_mut());
            proptest::prop_assert!(seen.len() <= bytes.len());
        }
    }
}
