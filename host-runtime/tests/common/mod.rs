//! What the tests of the `tetrad` program share: running it, clips rendered to disk, reading results.
#![allow(dead_code, reason = "every test file uses its own part")]

pub(crate) mod console;

use std::fs::{self, File};
use std::io::{BufWriter, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tetrad_core::observation::Ball;
use tetrad_fixtures::Scene;

/// How a run of the program ended.
#[derive(Debug)]
pub(crate) struct Ran {
    /// The exit code.
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ran {
    /// The run ended with 0.
    #[track_caller]
    pub(crate) fn done(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:#?}");
        self
    }

    /// The run ended with this code and one error that has all of these words.
    #[track_caller]
    pub(crate) fn refused(self, code: i32, words: &[&str]) -> Self {
        assert_eq!(self.code, Some(code), "{self:#?}");
        assert_eq!(self.stderr.matches("error:").count(), 1, "{self:#?}");
        for word in words {
            assert!(self.stderr.contains(word), "no {word:?} in {self:#?}");
        }
        self
    }
}

/// Runs `tetrad` in `dir` with these words as arguments.
#[track_caller]
pub(crate) fn tetrad(dir: &Path, arguments: &str) -> Ran {
    ended(command(arguments).current_dir(dir).stdin(Stdio::null()).output().expect("the program starts"))
}

/// Runs `tetrad` with these words as arguments and this text on its standard input.
#[track_caller]
pub(crate) fn tetrad_with_input(arguments: &str, input: &[u8]) -> Ran {
    let mut file = tempfile::tempfile().expect("a file");
    file.write_all(input).and_then(|()| file.rewind()).expect("the input is written");
    ended(command(arguments).stdin(file).output().expect("the program starts"))
}

pub(crate) fn command(arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tetrad"));
    command.args(arguments.split_whitespace());
    command
}

fn ended(output: Output) -> Ran {
    Ran {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("stdout is text"),
        stderr: String::from_utf8(output.stderr).expect("stderr is text"),
    }
}

/// A directory with a clip of a simulated scene: `left/` and `right/` with PNG frames, and scene.json
/// with the balls' true places in the first frame.
pub(crate) struct Clip {
    pub(crate) dir: tempfile::TempDir,
    pub(crate) scene: Scene,
}

impl Clip {
    /// Renders the first `frames` frames of the scene.
    pub(crate) fn of(name: &str, frames: usize) -> Self {
        let scene = Scene::named(name).expect("the scene exists");
        let clip = Self { dir: tempfile::tempdir().expect("a directory"), scene };
        let mut rgb = Vec::new();
        for (camera, view) in ["left", "right"].into_iter().enumerate() {
            fs::create_dir(clip.path(view)).expect("a new directory");
            for frame in 0..frames {
                clip.scene.render_rgb(frame, camera, &mut rgb);
                let size = (u32::from(clip.scene.width), u32::from(clip.scene.height));
                write_png(&clip.frame(view, frame), size, png::ColorType::Rgb, png::BitDepth::Eight, &rgb);
            }
        }
        fs::write(clip.path("scene.json"), clip.scene_json()).expect("scene.json is written");
        clip
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub(crate) fn frame(&self, view: &str, frame: usize) -> PathBuf {
        self.path(view).join(format!("{frame:04}.png"))
    }

    pub(crate) fn tetrad(&self, arguments: &str) -> Ran {
        tetrad(self.dir.path(), arguments)
    }

    /// Where a ball is in the first frame, in whole pixels.
    pub(crate) fn seed(&self, camera: usize, ball: Ball) -> (i32, i32) {
        let (u, v) = self.scene.truth(0, camera)[ball.index()].outline_centre;
        (u.round() as i32, v.round() as i32)
    }

    fn scene_json(&self) -> String {
        let seeds = |camera| {
            let seed = |ball: Ball| {
                let (u, v) = self.seed(camera, ball);
                format!("\"{}\": [{u}, {v}]", ball.name())
            };
            Ball::ALL.map(seed).join(", ")
        };
        format!(
            "{{\"fps\": {}, \"arm_m\": {}, \"ball_diameter_m\": {},\n \"seeds\": {{\"left\": {{{}}},\n\"right\": {{{}}}}}}}",
            self.scene.fps,
            self.scene.arm_m,
            self.scene.ball_diameter_m,
            seeds(0),
            seeds(1)
        )
    }
}

/// Writes a PNG of any kind.
pub(crate) fn write_png(
    path: &Path,
    size: (u32, u32),
    colour: png::ColorType,
    depth: png::BitDepth,
    bytes: &[u8],
) {
    let file = BufWriter::new(File::create(path).expect("the picture is created"));
    let mut encoder = png::Encoder::new(file, size.0, size.1);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Fastest);
    encoder.write_header().expect("a header").write_image_data(bytes).expect("the pixels");
}

/// A CSV file as rows of fields, the header first.
#[track_caller]
pub(crate) fn csv(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    assert!(text.ends_with('\n'), "{}: the last row is whole", path.display());
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[track_caller]
pub(crate) fn json(path: &Path) -> serde_json::Value {
    let bytes = fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_slice(&bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
