//! Promise: `tetrad track` sees through a smart camera what it sees in the same pictures itself, to the last
//! digit: the camera is a board, taught and started over its line.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use std::{env, thread};
use tetrad_core::vision::frame::FrameView;
use tetrad_qemu::board::Target;
use tetrad_qemu::clip::{Clip, FORMAT, Sequence};
use tetrad_qemu::live::Plugged;
use tetrad_qemu::tape::{Event, Tape};

/// Names the program; `cargo verify` sets it.
const PROGRAM: &str = "TETRAD_PROGRAM";

/// The longest that a run may take.
const LIMIT: Duration = Duration::from_secs(180);

/// Rows of observations.csv that one picture gives.
const BALLS: usize = 4;

#[test]
fn balls_that_a_board_learns_are_tracked_as_on_the_desktop() -> io::Result<()> {
    let bench = Bench::of(&Sequence { scene: "demo", frames: (1..40).collect() })?;
    for target in Target::OWN {
        bench.check(target, "--scene scene.json")?;
    }
    Ok(())
}

#[test]
fn colours_that_a_board_learns_are_the_desktops_and_it_finds_the_balls_with_them() -> io::Result<()> {
    let bench = Bench::of(&Sequence { scene: "static-30px", frames: (1..4).collect() })?;
    let clip = Clip::named("static-30px", 0).ok_or(io::ErrorKind::NotFound)?;
    let points = clip.places(0).map(|(ball, at)| format!("--at {}={},{}", ball.name(), at.u, at.v));
    let camera = Plugged::start(Target::OWN[0], &bench.tape)?;
    let source = format!("node:serial:{}", camera.device().display());
    let [desktop, board] =
        [("left", "desktop.toml"), (source.as_str(), "board.toml")].map(|(source, out)| {
            let learnt = bench.start(&format!("learn --source {source} --out {out} {}", points.join(" ")))?;
            assert!(ended(learnt)?.success(), "{}", bench.said());
            fs::read_to_string(bench.path(out))
        });
    // the source, and the point that was pointed at in place of the centre that was found
    let learnt = |file: &str| {
        let same = |line: &&str| !line.starts_with("source") && !line.starts_with("at");
        file.lines().filter(same).map(str::to_owned).collect::<Vec<String>>()
    };
    assert_eq!(learnt(&board?), learnt(&desktop?));
    drop(camera);
    bench.check(Target::OWN[0], "--colours-left board.toml")
}

#[test]
fn a_place_without_a_ball_is_refused_by_the_board_too() -> io::Result<()> {
    let bench = Bench::of(&Sequence { scene: "static-30px", frames: vec![1] })?;
    let scene = r#"{"seeds": {"left": {"red": [3, 3]}}}"#;
    fs::write(bench.path("nowhere.json"), scene)?;
    let camera = Plugged::start(Target::OWN[0], &bench.tape)?;
    let source = format!("node:serial:{}", camera.device().display());
    for source in ["left", &source] {
        let ran = bench.start(&format!("track --left {source} --scene nowhere.json --out none"))?;
        assert_eq!(ended(ran)?.code(), Some(1), "{source}: {}", bench.said());
        assert!(bench.said().contains("red"), "{}", bench.said());
    }
    Ok(())
}

/// The same pictures on a tape and in a folder.
struct Bench {
    folder: tempfile::TempDir,
    tape: Tape,
}

impl Bench {
    fn of(sequence: &Sequence) -> io::Result<Self> {
        let bench = Self { folder: tempfile::tempdir()?, tape: Tape::of_pictures(sequence) };
        fs::create_dir(bench.path("left"))?;
        let mut times = File::create(bench.path("left/timestamps.csv"))?;
        writeln!(times, "frame,t")?;
        let pictures = bench.tape.events.iter().filter_map(|event| match event {
            Event::Picture(at_us, bytes) => Some((at_us, bytes)),
            Event::Line(_) | Event::Pause(_) | Event::Case(_) => None,
        });
        for (frame, (at_us, bytes)) in pictures.enumerate() {
            writeln!(times, "{frame},{:.6}", *at_us as f64 / 1e6)?;
            write_png(&bench.path(&format!("left/{frame:06}.png")), bench.tape.size, bytes)?;
        }
        let clip = Clip::named(sequence.scene, 0).ok_or(io::ErrorKind::NotFound)?;
        let seeds = clip.places(0).map(|(ball, at)| format!("\"{}\": [{}, {}]", ball.name(), at.u, at.v));
        let scene = format!("{{\"arm_m\": 0.08, \"seeds\": {{\"left\": {{{}}}}}}}", seeds.join(", "));
        fs::write(bench.path("scene.json"), scene)?;
        Ok(bench)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Tracks in the folder and through a board; `taught` is how either knows the balls.
    fn check(&self, target: Target, taught: &str) -> io::Result<()> {
        let tracked = ended(self.start(&format!("track --left left {taught} --out folder"))?)?;
        assert!(tracked.success(), "{}", self.said());
        let expected = fs::read_to_string(self.path("folder/observations.csv"))?;
        assert_eq!(expected.lines().count(), 1 + BALLS * self.tape.events.len());
        assert!(expected.contains(",visible"), "{expected}");

        // rows of the board before are not this one's
        if self.path("camera").exists() {
            fs::remove_dir_all(self.path("camera"))?;
        }
        let mut camera = Plugged::start(target, &self.tape)?;
        let source = format!("node:serial:{}", camera.device().display());
        let mut tracking = self.start(&format!("track --left {source} {taught} --out camera"))?;
        let rows = || fs::read_to_string(self.path("camera/observations.csv")).unwrap_or_default();
        let started = Instant::now();
        while rows().lines().count() < expected.lines().count() {
            camera.check()?;
            if let Some(status) = tracking.try_wait()? {
                return Err(io::Error::other(format!("{target:?}: {status}\n{}", self.said())));
            }
            if started.elapsed() > LIMIT {
                tracking.kill()?;
                return Err(io::Error::other(format!(
                    "{target:?}: {} rows\n{}",
                    rows().lines().count(),
                    self.said()
                )));
            }
            thread::sleep(Duration::from_millis(20));
        }
        // as Ctrl-C does
        let interrupted = Command::new("kill").args(["-INT", &tracking.id().to_string()]).status()?;
        assert!(interrupted.success());
        let status = ended(tracking)?;
        assert!(status.success(), "{target:?}: {status}\n{}", self.said());
        camera.check()?;
        assert!(rows() == expected, "{target:?}: the board\n{}\nand the folder\n{expected}", rows());
        Ok(())
    }

    /// Starts the program; what it says goes to a file.
    fn start(&self, arguments: &str) -> io::Result<Child> {
        let program = env::var_os(PROGRAM).ok_or_else(|| {
            io::Error::other(format!("{PROGRAM} is not set: run `cargo verify --only firmware-qemu`"))
        })?;
        let said = File::create(self.path("said"))?;
        Command::new(program)
            .args(arguments.split_whitespace())
            .current_dir(self.folder.path())
            .stdin(Stdio::null())
            .stdout(said.try_clone()?)
            .stderr(said)
            .spawn()
    }

    fn said(&self) -> String {
        fs::read_to_string(self.path("said")).unwrap_or_default()
    }
}

fn ended(mut program: Child) -> io::Result<ExitStatus> {
    let started = Instant::now();
    while started.elapsed() < LIMIT {
        if let Some(status) = program.try_wait()? {
            return Ok(status);
        }
        thread::sleep(Duration::from_millis(10));
    }
    program.kill()?;
    Err(io::Error::other("the program did not end"))
}

/// What core sees in the pixels: the same colours, three bytes each.
fn write_png(path: &Path, (width, height): (u16, u16), bytes: &[u8]) -> io::Result<()> {
    let view = FrameView::packed(bytes, width, height, FORMAT).map_err(io::Error::other)?;
    let places = (0..i32::from(height)).flat_map(|y| (0..i32::from(width)).map(move |x| (x, y)));
    let pixels = places.filter_map(|(x, y)| view.pixel(x, y));
    let rgb: Vec<u8> = pixels.flat_map(|rgb| [rgb.r, rgb.g, rgb.b]).collect();
    let mut encoder =
        png::Encoder::new(BufWriter::new(File::create(path)?), u32::from(width), u32::from(height));
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fastest);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&rgb)).map_err(io::Error::other)
}
