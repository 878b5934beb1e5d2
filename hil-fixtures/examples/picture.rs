//! Writes frames of a scene as PPM pictures and prints their ground truth:
//! `cargo run --release -p tetrad-fixtures --example picture -- OUT_DIR SCENE:FRAME...`; without
//! arguments it lists the scenes.

use std::error::Error;
use std::time::Instant;
use std::{env, fs, path::Path};
use tetrad_core::observation::Ball;
use tetrad_fixtures::Scene;

/// Frames over which the time of rendering is averaged.
const TIMED: usize = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let Some((out_dir, wanted)) = arguments.split_first() else {
        for (name, about) in Scene::names() {
            println!("{name:<20} {about}");
        }
        return Ok(());
    };
    let mut rgb = Vec::new();
    for item in wanted {
        let (name, frame) = item.split_once(':').ok_or_else(|| format!("{item}: write SCENE:FRAME"))?;
        let frame: usize = frame.parse()?;
        let scene = Scene::named(name).ok_or_else(|| format!("{name}: no such scene"))?;
        for camera in 0..scene.cameras() {
            scene.render_rgb(frame, camera, &mut rgb);
            let start = Instant::now();
            for later in frame..frame + TIMED {
                scene.render_rgb(later, camera, &mut rgb);
            }
            let each_ms = start.elapsed().as_secs_f64() * 1000.0 / TIMED as f64;
            scene.render_rgb(frame, camera, &mut rgb);
            let file = Path::new(out_dir).join(format!("{name}_{frame}_{camera}.ppm"));
            let mut bytes = format!("P6 {} {} 255\n", scene.width, scene.height).into_bytes();
            bytes.extend_from_slice(&rgb);
            fs::write(&file, bytes)?;
            println!("{} ({each_ms:.2} ms a frame)", file.display());
            for (ball, truth) in Ball::ALL.iter().zip(scene.truth(frame, camera)) {
                let (u, v) = truth.outline_centre;
                println!(
                    "  {:<6} u {u:8.3} v {v:8.3} diameter {:6.3} visible {:.3}",
                    ball.name(),
                    truth.diameter,
                    truth.visible_fraction
                );
            }
        }
    }
    Ok(())
}
