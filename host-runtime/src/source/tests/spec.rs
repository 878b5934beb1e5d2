use super::*;
use crate::source::Spec;
use std::path::PathBuf;
use tetrad_core::vision::frame::PixelFormat;

#[test]
fn src_is_told_apart_by_its_looks() {
    let folder = tempfile::tempdir().unwrap();
    let film = folder.path().join("clip.Y4M");
    std::fs::write(&film, "").unwrap();
    let parse = |spec: &str| Spec::parse(spec).unwrap();
    assert_eq!(parse("/dev/video3"), Spec::Camera(PathBuf::from("/dev/video3")));
    assert_eq!(parse("/dev/v4l/by-id/cam"), Spec::Camera(PathBuf::from("/dev/v4l/by-id/cam")));
    assert_eq!(parse(folder.path().to_str().unwrap()), Spec::Folder(folder.path().to_owned()));
    assert_eq!(parse(film.to_str().unwrap()), Spec::Y4m(film.clone()));
    let scene = |name: &str, format| Spec::Simulated { name: name.to_owned(), format };
    assert_eq!(parse("sim:demo"), scene("demo", PixelFormat::Rgb888));
    assert_eq!(parse("sim:demo?format=nv12"), scene("demo", PixelFormat::Nv12));
}

#[test]
fn what_cannot_be_read_is_a_bad_argument_that_says_what_can() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["clip.mp4", "still.png"] {
        std::fs::write(folder.path().join(name), "x").unwrap();
    }
    let inside = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    for (spec, words) in [
        ("node:7", vec!["node:7", "[[operator.camera]]"]),
        ("session.mcap", vec!["session.mcap", "no such file"]),
        ("no/such/folder", vec!["no/such/folder", "no such file or folder", "sim:NAME"]),
        ("", vec!["no such file or folder"]),
        ("sim:demo?format=grey", vec!["'grey'", "yuyv"]),
        ("sim:demo?speed=2", vec!["'speed=2'", "format"]),
        (&inside("clip.mp4"), vec!["clip.mp4", "ffmpeg"]),
        (&inside("still.png"), vec!["still.png", "folder"]),
    ] {
        assert_says(&refusal(open(spec, &Options::default())), Exit::BadArguments, &words);
    }
}

#[test]
fn a_senseless_frame_rate_is_refused() {
    for fps in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        let options = Options { fps: Some(fps), ..Options::default() };
        assert_says(&refusal(open("sim:demo", &options)), Exit::BadArguments, &["frame rate"]);
    }
}
