//! lab (not committed)
#[path = "../tests/common/mod.rs"]
mod common;
use std::time::Instant;
use tetrad_core::config::*;
use tetrad_core::observation::*;
use tetrad_core::vision::frame::*;
use tetrad_core::vision::tracker::CameraTracker;
use tetrad_fixtures::*;

#[derive(Default)]
struct S {
    e: Vec<f64>,
    z2: f64,
    zn: f64,
    bias: (f64, f64),
    n: usize,
    lost: usize,
    vis: f64,
    worst: String,
    dia: f64,
}
impl S {
    fn add(&mut self, e: (f64, f64), o: &Observation, what: String) {
        let d = e.0.hypot(e.1);
        if self.e.iter().all(|x| d > *x) {
            self.worst = what;
        }
        self.e.push(d);
        let c = o.covariance;
        let (uu, uv, vv) = (f64::from(c.uu), f64::from(c.uv), f64::from(c.vv));
        let det = uu * vv - uv * uv;
        if det > 0.0 {
            self.z2 += (e.0 * e.0 * vv - 2.0 * e.0 * e.1 * uv + e.1 * e.1 * uu) / det;
            self.zn += 2.0;
        }
        self.bias.0 += e.0;
        self.bias.1 += e.1;
        self.n += 1;
        self.vis += f64::from(o.visible);
    }
    fn text(&self) -> String {
        let n = self.e.len().max(1) as f64;
        let mut s = self.e.clone();
        s.sort_by(f64::total_cmp);
        let p95 = s.get((n * 0.95) as usize).copied().unwrap_or(f64::NAN);
        format!(
            "n {:5} mean {:.4} p95 {:.3} max {:.4} bias ({:+.3},{:+.3}) z {:.2} vis {:.2} dia {:+.3} lost {} worst {}",
            self.n,
            self.e.iter().sum::<f64>() / n,
            p95,
            s.last().copied().unwrap_or(0.0),
            self.bias.0 / n,
            self.bias.1 / n,
            (self.z2 / self.zn.max(1.0)).sqrt(),
            self.vis / n,
            self.dia / n,
            self.lost,
            self.worst
        )
    }
}
fn blur(rgb: &mut Vec<u8>, w: usize, h: usize) {
    let src = rgb.clone();
    for y in 1..h - 1 {
        for x in 1..w - 1 {
            for c in 0..3 {
                let p = |dx: usize, dy: usize| u32::from(src[((y + dy - 1) * w + x + dx - 1) * 3 + c]);
                let v = p(0, 0)
                    + p(2, 0)
                    + p(0, 2)
                    + p(2, 2)
                    + 2 * (p(1, 0) + p(0, 1) + p(2, 1) + p(1, 2))
                    + 4 * p(1, 1);
                rgb[(y * w + x) * 3 + c] = ((v + 8) / 16) as u8;
            }
        }
    }
}
fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let mut format = PixelFormat::Rgb888;
    let mut mode = CentreMode::Refined;
    let mut light = None;
    let mut noise = None;
    let mut bg = None;
    let mut exposure = None;
    let mut doblur = false;
    let mut perball = false;
    let mut time = false;
    let mut frames = None;
    let mut from = None;
    let mut arrive = 1.4;
    let mut dump = false;
    for a in &args {
        let (k, v) = a.split_once('=').unwrap_or((a, ""));
        match k {
            "yuyv" => format = PixelFormat::Yuyv,
            "uyvy" => format = PixelFormat::Uyvy,
            "nv12" => format = PixelFormat::Nv12,
            "565" => format = PixelFormat::Rgb565Le,
            "paper" => mode = CentreMode::RowEdge,
            "side" => light = Some(Light::side(v.parse().unwrap())),
            "even" => light = Some(Light::even()),
            "room" => light = Some(Light::room()),
            "noise" => noise = Some(v.parse::<f64>().unwrap()),
            "plain" => bg = Some(Background::Plain(v.parse().unwrap())),
            "clutter" => bg = Some(Background::Clutter { seed: v.parse().unwrap() }),
            "exp" => exposure = Some(v.parse::<f64>().unwrap()),
            "blur" => doblur = true,
            "perball" => perball = true,
            "time" => time = true,
            "frames" => frames = Some(v.parse::<usize>().unwrap()),
            "from" => from = Some(v.parse::<f64>().unwrap()),
            "arrive" => arrive = v.parse().unwrap(),
            "dump" => dump = true,
            name => {
                let mut scene = common::scene(name);
                if let Some(l) = &light {
                    scene.light = l.clone();
                }
                if let Some(n) = noise {
                    scene.noise_sigma = n;
                }
                if let Some(b) = &bg {
                    scene.background = b.clone();
                }
                if let Some(e) = exposure {
                    scene.exposure_s = e;
                }
                if let Some(f) = frames {
                    scene.frames = f;
                }
                if let Some(f) = from {
                    for o in &mut scene.occluders {
                        o.from_rad = f;
                    }
                }
                let _ = arrive;
                let mut stats: std::collections::BTreeMap<String, S> = Default::default();
                let mut rgb = Vec::new();
                let mut took = [0.0f64; 2];
                let mut steps = 0;
                for cam in 0..scene.cameras() {
                    let mut trackers: Vec<CameraTracker> = Vec::new();
                    for frame in 0..scene.frames() {
                        scene.render_rgb(frame, cam, &mut rgb);
                        if doblur {
                            blur(&mut rgb, scene.width.into(), scene.height.into());
                        }
                        let bytes = tetrad_fixtures::to_format(&rgb, scene.width, scene.height, format);
                        let view = FrameView::packed(&bytes, scene.width, scene.height, format).unwrap();
                        if frame == 0 {
                            for m in [mode, CentreMode::RowEdge] {
                                let mut c = TrackerConfig::default();
                                c.centre.mode = m;
                                trackers.push(common::taught_with(&view, &scene.truth(0, cam), c));
                                if !time {
                                    break;
                                }
                            }
                        }
                        let mut report = None;
                        for (i, t) in trackers.iter_mut().enumerate() {
                            let start = Instant::now();
                            let r = t.step(&view, common::time_us(&scene, frame), &[None; BALLS]);
                            took[i] += start.elapsed().as_secs_f64() * 1e6;
                            if i == 0 {
                                report = Some(r);
                            }
                        }
                        steps += 1;
                        let report = report.unwrap();
                        let truth = scene.truth(frame, cam);
                        for b in Ball::ALL {
                            let (o, t) = (&report.observations[b.index()], &truth[b.index()]);
                            let key = if perball {
                                format!("{} {} {}", o.state.name(), b.name(), cam)
                            } else {
                                o.state.name().to_owned()
                            };
                            let s = stats.entry(key).or_default();
                            if o.state == ObservationState::Lost {
                                s.lost += 1;
                                continue;
                            }
                            if dump {
                                println!(
                                    "{frame} {cam} {} {} err {:+.3} {:+.3} sig {:.3} visible {:.2}/{:.2} dia {:.2}/{:.2}",
                                    b.name(),
                                    o.state.name(),
                                    f64::from(o.centre.u) - t.outline_centre.0,
                                    f64::from(o.centre.v) - t.outline_centre.1,
                                    o.covariance.uu.sqrt(),
                                    o.visible,
                                    t.visible_fraction,
                                    o.diameter,
                                    t.diameter
                                );
                            }
                            s.dia += f64::from(o.diameter) - t.diameter;
                            s.add(
                                (
                                    f64::from(o.centre.u) - t.outline_centre.0,
                                    f64::from(o.centre.v) - t.outline_centre.1,
                                ),
                                o,
                                format!(
                                    "{} cam {cam} frame {frame} true-vis {:.2}",
                                    b.name(),
                                    t.visible_fraction
                                ),
                            );
                        }
                    }
                }
                for (k, s) in &stats {
                    println!("{name:18} {k:10} {}", s.text());
                }
                if time {
                    println!(
                        "{name:18} time refined {:.2} us paper {:.2} us ratio {:.2}",
                        took[0] / steps as f64,
                        took[1] / steps as f64,
                        took[0] / took[1]
                    );
                }
            }
        }
    }
}
