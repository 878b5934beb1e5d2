use super::*;
use crate::source::Gap;
use std::fs;
use tempfile::TempDir;
use tetrad_core::vision::frame::PixelFormat;

/// A PNG of `width` x `height` pixels, each with these samples.
fn png(width: u32, height: u32, colour: png::ColorType, depth: png::BitDepth, pixel: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    if colour == png::ColorType::Indexed {
        encoder.set_palette(vec![1, 2, 3, 40, 50, 60]);
    }
    let data = pixel.repeat((width * height) as usize);
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    bytes
}

fn rgb_png(width: u32, height: u32, pixel: [u8; 3]) -> Vec<u8> {
    png(width, height, png::ColorType::Rgb, png::BitDepth::Eight, &pixel)
}

/// A JPEG with some structure, so that its data is long enough to be cut.
fn jpeg(width: u16, height: u16, colour: jpeg_encoder::ColorType, progressive: bool) -> Vec<u8> {
    let components = match colour {
        jpeg_encoder::ColorType::Luma => 1,
        jpeg_encoder::ColorType::Cmyk => 4,
        _ => 3,
    };
    let data: Vec<u8> =
        (0..usize::from(width) * usize::from(height) * components).map(|at| (at * 37 % 251) as u8).collect();
    let mut bytes = Vec::new();
    let mut encoder = jpeg_encoder::Encoder::new(&mut bytes, 90);
    encoder.set_progressive(progressive);
    encoder.encode(&data, width, height, colour).unwrap();
    bytes
}

fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

/// What reading one picture as the second of a folder says.
fn second_picture_error(bytes: &[u8]) -> SourceError {
    let good = rgb_png(8, 8, [9, 9, 9]);
    let folder = folder(&[("1.png", &good), ("2.png", bytes)]);
    let (seen, error) = read_all(open_path(folder.path()).unwrap().as_mut());
    assert_eq!(seen.len(), 1, "the frame before the bad one is delivered");
    error.expect("the second picture is refused")
}

/// A name of a picture, or of the times, can be that of what never ends: nobody waits for it.
#[cfg(target_os = "linux")]
#[test]
fn pipes_among_pictures_are_refused() {
    for name in ["2.png", "timestamps.csv"] {
        let folder = folder(&[("1.png", &rgb_png(8, 8, [9, 9, 9]))]);
        let pipe = folder.path().join(name);
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let error = match open_path(folder.path()) {
            Ok(mut source) => read_all(source.as_mut()).1.expect("it is refused"),
            Err(error) => error,
        };
        let error = error.to_string();
        assert!(error.contains(name) && error.contains("it is a pipe or a device"), "{error}");
    }
}

#[test]
fn frames_come_in_the_order_of_their_numbers() {
    let shade = |value| rgb_png(4, 2, [value, 0, 0]);
    let folder = folder(&[
        ("f10.png", &shade(10)),
        ("f9.PNG", &shade(9)),
        ("f014.png", &shade(14)),
        ("notes.txt", b"passed over"),
        (".f11.png", b"hidden: passed over"),
    ]);
    fs::create_dir(folder.path().join("f12.png")).unwrap();
    let mut source = open_path(folder.path()).unwrap();
    let info = source.info().clone();
    assert_eq!((info.width, info.height, info.format), (4, 2, PixelFormat::Rgb888));
    assert_eq!((info.frames, info.fps, info.live), (Some(3), Some(30.0), false));

    let mut gaps = Vec::new();
    let mut seen = Vec::new();
    while let Some(frame) = source.next().unwrap() {
        gaps.push(frame.gap);
        seen.push((frame.number, frame.view.pixel(3, 1).unwrap().r, frame.t_s));
    }
    // Time goes by frame number: 9 is the first, 14 comes five frames later.
    assert_eq!(seen, [(9, 9, 0.0), (10, 10, 1.0 / 30.0), (14, 14, 5.0 / 30.0)]);
    assert_eq!(gaps, [Gap::None, Gap::None, Gap::Missed(3)]);
    assert!(source.next().unwrap().is_none());
}

#[test]
fn buffers_go_round_without_mixing_frames() {
    // More pictures than buffers, each of its own colour.
    let folder = tempfile::tempdir().unwrap();
    for number in 0..20 {
        fs::write(folder.path().join(format!("{number}.png")), rgb_png(5, 3, [number, 0, 0])).unwrap();
    }
    let (seen, error) = read_all(open_path(folder.path()).unwrap().as_mut());
    assert!(error.is_none());
    let shades: Vec<u8> = seen.iter().map(|frame| frame.corner.r).collect();
    assert_eq!(shades, (0..20).collect::<Vec<u8>>());
}

#[test]
fn a_source_may_be_dropped_before_its_end() {
    let folder = tempfile::tempdir().unwrap();
    for number in 0..20 {
        fs::write(folder.path().join(format!("{number}.png")), rgb_png(5, 3, [number, 0, 0])).unwrap();
    }
    let mut source = open_path(folder.path()).unwrap();
    assert!(source.next().unwrap().is_some());
    // Hangs if the decoding thread is not told.
    drop(source);
}

#[test]
fn every_kind_of_colour_picture_is_read() {
    let eight = png::BitDepth::Eight;
    for (name, bytes, corner, format) in [
        ("rgb", rgb_png(2, 2, [7, 8, 9]), Rgb::new(7, 8, 9), PixelFormat::Rgb888),
        (
            "rgba",
            png(2, 2, png::ColorType::Rgba, eight, &[7, 8, 9, 0]),
            Rgb::new(7, 8, 9),
            PixelFormat::Rgba8888,
        ),
        (
            "palette",
            png(2, 2, png::ColorType::Indexed, eight, &[1]),
            Rgb::new(40, 50, 60),
            PixelFormat::Rgb888,
        ),
        ("one pixel", rgb_png(1, 1, [1, 2, 3]), Rgb::new(1, 2, 3), PixelFormat::Rgb888),
    ] {
        let folder = folder(&[("1.png", &bytes)]);
        let mut source = open_path(folder.path()).unwrap();
        assert_eq!(source.info().format, format, "{name}");
        let (seen, error) = read_all(source.as_mut());
        assert!(error.is_none(), "{name}");
        assert_eq!(seen[0].corner, corner, "{name}");
    }
    for progressive in [false, true] {
        let folder = folder(&[("1.jpg", &jpeg(40, 24, jpeg_encoder::ColorType::Rgb, progressive))]);
        let mut source = open_path(folder.path()).unwrap();
        assert_eq!((source.info().width, source.info().height), (40, 24));
        assert_eq!(read_all(source.as_mut()).0.len(), 1);
    }
}

#[test]
fn a_jpeg_keeps_its_colours() {
    let data = [200, 40, 30].repeat(16 * 16);
    let mut bytes = Vec::new();
    let encoder = jpeg_encoder::Encoder::new(&mut bytes, 95);
    encoder.encode(&data, 16, 16, jpeg_encoder::ColorType::Rgb).unwrap();
    let folder = folder(&[("1.jpeg", &bytes)]);
    let (seen, _) = read_all(open_path(folder.path()).unwrap().as_mut());
    let Rgb { r, g, b } = seen[0].corner;
    assert!(r.abs_diff(200) <= 2 && g.abs_diff(40) <= 2 && b.abs_diff(30) <= 2, "{r} {g} {b}");
}

#[test]
fn a_mixture_of_rgb_and_rgba_is_one_stream() {
    let rgba = png(2, 2, png::ColorType::Rgba, png::BitDepth::Eight, &[4, 5, 6, 7]);
    let folder = folder(&[("1.png", &rgb_png(2, 2, [1, 2, 3])), ("2.png", &rgba)]);
    let (seen, error) = read_all(open_path(folder.path()).unwrap().as_mut());
    assert!(error.is_none());
    assert_eq!(seen[1].corner, Rgb::new(4, 5, 6));
}

#[test]
fn pictures_without_eight_bit_colours_are_refused_by_name() {
    let sixteen = png::BitDepth::Sixteen;
    for (bytes, words) in [
        (png(8, 8, png::ColorType::Rgb, sixteen, &[0; 6]), ["2.png", "16 bits", "-depth 8"]),
        (png(8, 8, png::ColorType::Rgba, sixteen, &[0; 8]), ["2.png", "16 bits", "-depth 8"]),
        (png(8, 8, png::ColorType::Grayscale, png::BitDepth::Eight, &[0]), ["2.png", "grey", "colour"]),
        (png(8, 8, png::ColorType::Grayscale, sixteen, &[0, 0]), ["2.png", "grey", "colour"]),
        (
            png(8, 8, png::ColorType::GrayscaleAlpha, png::BitDepth::Eight, &[0, 0]),
            ["2.png", "grey", "colour"],
        ),
        (jpeg(8, 8, jpeg_encoder::ColorType::Luma, false), ["2.png", "grey", "colour"]),
        (jpeg(8, 8, jpeg_encoder::ColorType::Cmyk, false), ["2.png", "CMYK", "magick"]),
        (b"GIF89a".to_vec(), ["2.png", "neither PNG nor JPEG", "convert"]),
        (Vec::new(), ["2.png", "empty", "file"]),
    ] {
        assert_says(&second_picture_error(&bytes), Exit::Failed, &words);
    }
}

#[test]
fn a_picture_cut_off_anywhere_is_refused() {
    let noise: Vec<u8> = (0..8 * 8 * 3).map(|at| (at * 73 % 251) as u8).collect();
    let mut png_bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut png_bytes, 8, 8);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&noise).unwrap();
    let baseline = jpeg(8, 8, jpeg_encoder::ColorType::Rgb, false);
    let progressive = jpeg(8, 8, jpeg_encoder::ColorType::Rgb, true);

    let mut picture = crate::source::picture::Picture::default();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.png");
    for (kind, bytes) in [("png", &png_bytes), ("jpeg", &baseline), ("progressive jpeg", &progressive)] {
        for length in 0..bytes.len() {
            fs::write(&path, &bytes[..length]).unwrap();
            let result = picture.load(&path);
            assert!(result.is_err(), "{kind}: {length} of {} bytes were taken for a picture", bytes.len());
        }
        fs::write(&path, bytes).unwrap();
        picture.load(&path).unwrap();
    }
}

#[test]
fn a_jpeg_may_carry_a_thumbnail_and_a_trailer() {
    let picture = jpeg(8, 8, jpeg_encoder::ColorType::Rgb, false);
    // An application segment that holds a whole small JPEG, end marker and all.
    let mut segment = vec![0xff, 0xe5];
    segment.extend(u16::try_from(picture.len() + 2).unwrap().to_be_bytes());
    segment.extend(&picture);
    let mut bytes = picture[..2].to_vec();
    bytes.extend(&segment);
    bytes.extend(&picture[2..]);
    let whole = bytes.len();
    bytes.extend(b"a camera maker's additions");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("1.jpg");
    let mut picture = crate::source::picture::Picture::default();
    fs::write(&path, &bytes).unwrap();
    picture.load(&path).unwrap();
    // The thumbnail's end is not the picture's.
    fs::write(&path, &bytes[..whole - 2]).unwrap();
    let error = picture.load(&path).unwrap_err();
    assert_says(&error, Exit::Failed, &["1.jpg", "cut-off"]);
}

#[test]
fn a_flipped_bit_in_a_png_is_noticed() {
    let mut bytes = rgb_png(8, 8, [1, 2, 3]);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    assert_says(&second_picture_error(&bytes), Exit::Failed, &["2.png", "damaged"]);
}

#[test]
fn sizes_are_checked_before_memory_is_taken() {
    // A header that promises 100000 x 100000 pixels; its checksum is right, its data is missing.
    let mut bytes = rgb_png(1, 1, [0, 0, 0]);
    bytes[16..24].copy_from_slice(&[0, 1, 0x86, 0xa0, 0, 1, 0x86, 0xa0]);
    let mut crc = crc_of(&bytes[12..29]);
    bytes[29..33].swap_with_slice(&mut crc);
    assert_says(&second_picture_error(&bytes), Exit::Failed, &["2.png", "100000 x 100000", "8192"]);
}

/// The checksum of a PNG chunk.
fn crc_of(bytes: &[u8]) -> [u8; 4] {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    (!crc).to_be_bytes()
}

#[test]
fn all_pictures_must_have_one_size() {
    let error = second_picture_error(&rgb_png(8, 9, [0, 0, 0]));
    assert_says(&error, Exit::Failed, &["2.png", "8 x 9", "8 x 8"]);
}

#[test]
fn an_empty_folder_is_a_bad_argument() {
    let empty = tempfile::tempdir().unwrap();
    let error = refusal(open_path(empty.path()));
    assert_says(&error, Exit::BadArguments, &[empty.path().to_str().unwrap(), "no PNG or JPEG"]);
}

#[test]
fn names_that_do_not_number_the_frames_are_refused() {
    let picture = rgb_png(1, 1, [0, 0, 0]);
    for (names, words) in [
        (vec!["1.png", "title.png"], vec!["title.png", "no frame number"]),
        (vec!["1.png", "01.jpg"], vec!["01.jpg", "1.png", "each once"]),
        (vec!["1_left.png", "1_right.png"], vec!["1_left.png", "1_right.png", "each once"]),
        (vec!["1305031102.175304.png", "1305031103.011215.png"], vec!["1305031103.011215.png", "must count"]),
        (vec!["1.png", "99999999999999999999.png"], vec!["99999999999999999999", "too large"]),
        (
            vec!["1403636579763555584.png", "1403636579813555456.png"],
            vec!["look like times", "timestamps.csv"],
        ),
    ] {
        let files: Vec<(&str, &[u8])> = names.iter().map(|name| (*name, picture.as_slice())).collect();
        let folder = folder(&files);
        assert_says(&refusal(open_path(folder.path())), Exit::Failed, &words);
    }
}

#[test]
fn a_single_picture_needs_no_number() {
    let folder = folder(&[("still.png", &rgb_png(3, 3, [5, 0, 0]))]);
    let (seen, error) = read_all(open_path(folder.path()).unwrap().as_mut());
    assert!(error.is_none());
    assert_eq!(seen, [Seen { number: 0, t_s: 0.0, corner: Rgb::new(5, 0, 0) }]);
}

/// Three pictures, 008 to 010, and a timestamps.csv.
fn stamped(csv: &str) -> TempDir {
    let picture = rgb_png(1, 1, [0, 0, 0]);
    let files: [(&str, &[u8]); 3] = [("008.png", &picture), ("009.png", &picture), ("010.png", &picture)];
    let folder = folder(&files);
    fs::write(folder.path().join("timestamps.csv"), csv).unwrap();
    folder
}

#[test]
fn timestamps_are_found_by_name_or_number() {
    for csv in [
        "frame,t\n008,1.5\n009,1.6\n010,2.5\n",
        // Numbers without leading zeros, any order, rows to spare, Windows line ends, a byte mark.
        "\u{feff}frame, t\r\n10, 2.5\r\n\r\n 8 ,1.5\r\n7,0\r\n9,1.6",
    ] {
        let folder = stamped(csv);
        let options = Options { fps: Some(10.0), ..Options::default() };
        let mut source = open(folder.path().to_str().unwrap(), &options).unwrap();
        assert_eq!(source.info().fps, None, "no nominal rate where every frame has its time");
        let (seen, _) = read_all(source.as_mut());
        let times: Vec<(u64, f64)> = seen.iter().map(|frame| (frame.number, frame.t_s)).collect();
        assert_eq!(times, [(8, 1.5), (9, 1.6), (10, 2.5)]);
    }
}

#[test]
fn bad_timestamps_are_refused_with_file_and_line() {
    for (csv, words) in [
        ("frame,t\n8,1.0\n9,0.9\n10,2\n", vec!["line 3", "frame 009", "0.9", "must increase"]),
        ("frame,t\n8,1.0\n9,1.0\n10,2\n", vec!["line 3", "must increase"]),
        ("frame,t\n8,-1.0\n9,0.5\n10,2\n", vec!["line 2", "-1.0", "from 0 on"]),
        ("frame,t\n8,1.0\n9,NaN\n10,2\n", vec!["line 3", "NaN", "finite"]),
        ("frame,t\n8,1.0\n9,inf\n10,2\n", vec!["line 3", "finite"]),
        ("frame,t\n8,1.0\n9,soon\n10,2\n", vec!["line 3", "'soon'"]),
        ("frame,t\n8,1.0\n9;1.1\n10,2\n", vec!["line 3", "9;1.1"]),
        ("frame,t\n8,1.0\n8,1.1\n", vec!["line 3", "line 2", "already"]),
        ("frame,t\n9,1.0\n", vec!["no row for 008, 010"]),
        ("8,1.0\n9,1.1\n10,1.2\n", vec!["first line", "'frame,t'", "8,1.0"]),
        ("", vec!["first line", "'frame,t'"]),
    ] {
        let folder = stamped(csv);
        let mut words = words;
        words.push("timestamps.csv");
        assert_says(&refusal(open_path(folder.path())), Exit::Failed, &words);
    }
}

#[test]
fn long_lists_of_missing_rows_are_cut() {
    let picture = rgb_png(1, 1, [0, 0, 0]);
    let folder = folder(&[("timestamps.csv", b"frame,t\n")]);
    for number in 0..9 {
        fs::write(folder.path().join(format!("{number}.png")), &picture).unwrap();
    }
    assert_says(&refusal(open_path(folder.path())), Exit::Failed, &["0, 1, 2, 3, 4 and 4 more"]);
}

#[test]
fn the_given_rate_is_the_rate_of_frame_numbers() {
    let picture = rgb_png(1, 1, [0, 0, 0]);
    let folder = folder(&[("60.png", &picture), ("62.png", &picture)]);
    let options = Options { fps: Some(8.0), ..Options::default() };
    let mut source = open(folder.path().to_str().unwrap(), &options).unwrap();
    assert_eq!(source.info().fps, Some(8.0));
    let (seen, _) = read_all(source.as_mut());
    assert_eq!((seen[0].t_s, seen[1].t_s), (0.0, 0.25));
}

proptest::proptest! {
    #[test]
    fn damaged_pictures_are_refused_or_read_and_never_more(
        kind in 0..3usize,
        at in proptest::prelude::any::<proptest::sample::Index>(),
        value in proptest::prelude::any::<u8>(),
    ) {
        let mut bytes = match kind {
            0 => rgb_png(9, 7, [1, 2, 3]),
            1 => jpeg(9, 7, jpeg_encoder::ColorType::Rgb, false),
            _ => jpeg(9, 7, jpeg_encoder::ColorType::Rgb, true),
        };
        let at = at.index(bytes.len());
        bytes[at] = value;
        let folder = folder(&[("1.png", &bytes)]);
        let mut picture = crate::source::picture::Picture::default();
        let result = picture.load(&folder.path().join("1.png"));
        let pixels = usize::from(picture.width) * usize::from(picture.height);
        if result.is_ok() {
            let whole = picture.format.row_bytes(usize::from(picture.width)) * usize::from(picture.height);
            proptest::prop_assert!(pixels > 0 && picture.pixels.len() == whole);
        } else {
            proptest::prop_assert_eq!(pixels, 0);
        }
    }
}
