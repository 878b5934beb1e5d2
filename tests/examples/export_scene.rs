//! Writes a simulated scene as a recording: numbered PNG frames of each camera, scene.json with the
//! places of the balls in the first frame, and truth.csv. For programs that cannot render a scene
//! themselves, such as `tests/scripts/opencv_compare.py`.
//!
//! `cargo run --release -p tetrad-tests --example export_scene -- SCENE FRAMES DIR`

use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;
use tetrad_core::observation::Ball;
use tetrad_fixtures::Scene;

const CAMERAS: [&str; 2] = ["left", "right"];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, frames, folder] = arguments.as_slice() else {
        return Err("three arguments are needed: SCENE FRAMES DIR".into());
    };
    let scene = Scene::named(name).ok_or_else(|| format!("{name}: there is no such scene"))?;
    let frames = frames.parse::<usize>()?.min(scene.frames());
    let folder = Path::new(folder);

    let mut truth = String::from("frame,camera,ball,u,v,diameter,visible\n");
    let mut rgb = Vec::new();
    for (camera, camera_name) in CAMERAS.into_iter().enumerate() {
        fs::create_dir_all(folder.join(camera_name))?;
        for frame in 0..frames {
            scene.render_rgb(frame, camera, &mut rgb);
            write_png(&folder.join(camera_name).join(format!("{frame:06}.png")), &scene, &rgb)?;
            for (ball, is) in Ball::ALL.iter().zip(scene.truth(frame, camera)) {
                let (u, v) = is.outline_centre;
                let (name, diameter, visible) = (ball.name(), is.diameter, is.visible_fraction);
                writeln!(truth, "{frame},{camera_name},{name},{u:.4},{v:.4},{diameter:.4},{visible:.4}")?;
            }
        }
    }
    fs::write(folder.join("truth.csv"), truth)?;
    fs::write(folder.join("scene.json"), scene_json(&scene)?)?;
    Ok(())
}

fn write_png(path: &Path, scene: &Scene, rgb: &[u8]) -> Result<(), Box<dyn Error>> {
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, scene.width.into(), scene.height.into());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.write_header()?.write_image_data(rgb)?;
    Ok(())
}

fn scene_json(scene: &Scene) -> Result<String, std::fmt::Error> {
    let mut json = format!(
        "{{\"fps\": {}, \"arm_m\": {}, \"ball_diameter_m\": {},\n \"seeds\": {{",
        scene.fps, scene.arm_m, scene.ball_diameter_m
    );
    for (camera, camera_name) in CAMERAS.into_iter().enumerate() {
        write!(json, "{}\"{camera_name}\": {{", if camera == 0 { "" } else { ",\n  " })?;
        for (ball, is) in Ball::ALL.iter().zip(scene.truth(0, camera)) {
            let (u, v) = is.outline_centre;
            let comma = if *ball == Ball::Red { "" } else { ", " };
            write!(json, "{comma}\"{}\": [{u:.2}, {v:.2}]", ball.name())?;
        }
        json.push('}');
    }
    json.push_str("}}\n");
    Ok(json)
}
