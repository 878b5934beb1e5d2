//! bench (not committed)
#[path = "../tests/common/mod.rs"]
mod common;
use std::time::Instant;
use tetrad_core::config::*;
use tetrad_core::observation::*;
use tetrad_core::vision::frame::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let scene = common::scene(&a[1]);
    let rounds: usize = a[2].parse().unwrap();
    let format = match a.get(3).map(String::as_str) {
        Some("yuyv") => PixelFormat::Yuyv,
        _ => PixelFormat::Rgb888,
    };
    let only = a.get(4).cloned();
    let frames: Vec<Vec<u8>> = (0..60)
        .map(|f| {
            let mut r = Vec::new();
            scene.render_rgb(f, 0, &mut r);
            tetrad_fixtures::to_format(&r, 640, 480, format)
        })
        .collect();
    let views: Vec<_> = frames.iter().map(|b| FrameView::packed(b, 640, 480, format).unwrap()).collect();
    let mut trackers: Vec<_> = [TrackerConfig::paper(), TrackerConfig::default()]
        .map(|c| common::taught_with(&views[0], &scene.truth(0, 0), c))
        .into();
    let mut times = [Vec::new(), Vec::new()];
    let mut t_us = 0;
    for round in 0..rounds {
        for v in &views {
            t_us += 33333;
            for k in 0..2 {
                let i = (k + round) % 2;
                if only.is_some() && i == 0 {
                    continue;
                }
                let s = Instant::now();
                std::hint::black_box(trackers[i].step(v, t_us, &[None; BALLS]));
                times[i].push(s.elapsed().as_nanos() as f64 / 1e3);
            }
        }
    }
    for t in &mut times {
        t.sort_by(f64::total_cmp);
        if t.is_empty() {
            t.push(0.0);
        }
    }
    let m: Vec<_> = times.iter().map(|t| (t[t.len() / 10], t[t.len() / 2])).collect();
    println!(
        "{} {:?} paper p10 {:.2} p50 {:.2}  refined p10 {:.2} p50 {:.2}  ratio p10 {:.2} p50 {:.2}",
        a[1],
        format,
        m[0].0,
        m[0].1,
        m[1].0,
        m[1].1,
        m[1].0 / m[0].0,
        m[1].1 / m[0].1
    );
}
