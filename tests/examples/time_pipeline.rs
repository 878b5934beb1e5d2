//! Times a step of the pipeline on a recording that `export_scene` wrote, its pictures held in memory,
//! as a program is timed that gets pictures from nowhere: reading and decoding a picture between two
//! steps leaves the processor's caches and branch predictors to somebody else. For
//! `tests/scripts/opencv_compare.py`, which holds OpenCV's pictures in memory too.
//!
//! `cargo run --release -p tetrad-tests --example time_pipeline -- DIR paper|refined FRAMES OBSERVATIONS.csv`
//!
//! The cameras learn from their first picture what scene.json says, as `tetrad track --scene` does.
//! Prints a line of JSON, medians in microseconds: `{"tracking_us": of a camera's frame, "pose_us": ..}`.
//! The file gets what was measured: frame, camera, ball, u, v.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;
use tetrad::learning::{learn_at, start_with};
use tetrad::pipeline::{Pipeline, PipelineConfig, Step};
use tetrad::scene_file::SceneFile;
use tetrad_core::config::LearnConfig;
use tetrad_core::hand::affine::Arms;
use tetrad_core::observation::Ball;
use tetrad_core::vision::frame::{FrameView, PixelFormat};

const CAMERAS: [&str; 2] = ["left", "right"];

/// Passes over the recording. The first is not timed: OpenCV's is warm by then too.
const PASSES: usize = 4;

/// A decoded picture.
struct Picture {
    width: u16,
    height: u16,
    rgb: Vec<u8>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, mode, frames, observations] = arguments.as_slice() else {
        return Err("four arguments are needed: DIR paper|refined FRAMES OBSERVATIONS.csv".into());
    };
    let folder = Path::new(folder);
    let config = match mode.as_str() {
        "paper" => PipelineConfig::paper(),
        "refined" => PipelineConfig::refined(),
        other => return Err(format!("{other}: the modes are paper and refined").into()),
    };
    let scene_path = folder.join("scene.json");
    let scene = SceneFile::parse(&std::fs::read_to_string(&scene_path)?, &scene_path.to_string_lossy())?;
    let arms = Arms::equal(scene.arm_m.ok_or("scene.json: arm_m is missing")?)?;
    let frame_us = 1e6 / scene.fps.ok_or("scene.json: fps is missing")?;
    let right = scene.right.ok_or("scene.json: seeds.right is missing")?;
    let pictures = CAMERAS.map(|camera| read_all(&folder.join(camera), frames.parse().unwrap_or(usize::MAX)));
    let [left_pictures, right_pictures] = pictures;
    let pictures: Vec<(Picture, Picture)> = left_pictures?.into_iter().zip(right_pictures?).collect();
    let (first_left, first_right) = pictures.first().ok_or("there are no pictures")?;
    let mut starts = Vec::new();
    for (seeds, picture) in [(&scene.left, first_left), (&right, first_right)] {
        starts.push(start_with(&learn_at(&picture.view()?, seeds, &LearnConfig::default())?));
    }

    let (mut tracking, mut solving) = (Vec::new(), Vec::new());
    let mut places = String::from("frame,camera,ball,u,v\n");
    for pass in 0..PASSES {
        let mut pipeline = Pipeline::new(&starts, config, Some(arms)).map_err(|(_, error)| error)?;
        for (number, (left, right)) in pictures.iter().enumerate() {
            let t_us = (number as f64 * frame_us).round() as u64;
            let step = pipeline.step(&[(left.view()?, t_us), (right.view()?, t_us)]);
            if pass == 0 {
                note(&mut places, number, &step)?;
                continue;
            }
            tracking.extend(step.cameras.iter().map(|camera| camera.tracking));
            solving.extend(step.hand.iter().map(|hand| hand.solving));
        }
    }
    std::fs::write(observations, places)?;
    println!("{{\"tracking_us\": {:.3}, \"pose_us\": {:.3}}}", median_us(tracking), median_us(solving));
    Ok(())
}

/// The pictures of a folder, in the order of their names.
fn read_all(folder: &Path, most: usize) -> Result<Vec<Picture>, Box<dyn Error>> {
    let mut paths =
        std::fs::read_dir(folder)?.map(|file| Ok(file?.path())).collect::<std::io::Result<Vec<_>>>()?;
    paths.sort();
    paths.iter().take(most).map(|path| Picture::read(path)).collect()
}

impl Picture {
    fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let mut reader =
            png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path)?)).read_info()?;
        let size = reader.output_buffer_size().ok_or_else(|| format!("{}: too large", path.display()))?;
        let mut rgb = vec![0; size];
        let info = reader.next_frame(&mut rgb)?;
        if info.color_type != png::ColorType::Rgb || info.bit_depth != png::BitDepth::Eight {
            return Err(format!("{}: not 8-bit RGB, as export_scene writes", path.display()).into());
        }
        Ok(Self { width: info.width.try_into()?, height: info.height.try_into()?, rgb })
    }

    fn view(&self) -> Result<FrameView<'_>, Box<dyn Error>> {
        Ok(FrameView::packed(&self.rgb, self.width, self.height, PixelFormat::Rgb888)?)
    }
}

/// Adds what was measured in a step.
fn note(places: &mut String, number: usize, step: &Step) -> Result<(), std::fmt::Error> {
    for (name, camera) in CAMERAS.iter().zip(&step.cameras) {
        for (ball, seen) in Ball::ALL.iter().zip(&camera.report.observations) {
            if seen.state.is_measured() {
                let (ball, u, v) = (ball.name(), seen.centre.u, seen.centre.v);
                writeln!(places, "{number},{name},{ball},{u:.4},{v:.4}")?;
            }
        }
    }
    Ok(())
}

fn median_us(mut times: Vec<Duration>) -> f64 {
    times.sort();
    times.get(times.len() / 2).map_or(0.0, |time| time.as_secs_f64() * 1e6)
}
