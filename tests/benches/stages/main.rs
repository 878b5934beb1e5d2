//! How long each stage takes, on rendered frames of 640x480 that are prepared outside the timing.
//!
//! `cargo bench -p tetrad-tests` runs all; `cargo bench -p tetrad-tests -- camera` those with `camera`
//! in their path; `-- --test` each of them once, without figures. A figure is good to compare with one
//! of the same run. For the whole program beside OpenCV see `tests/scripts/opencv_compare.py`.

mod arm;
mod camera;
mod chain;
mod clip;
mod hand;
mod slave;
mod vision;
mod wire;

fn main() {
    divan::main();
}
