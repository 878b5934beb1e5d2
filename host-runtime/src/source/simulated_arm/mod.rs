//! `sim:arm`: a drawing of the slave's arm as it stands, for operators whose slave has no camera.
//!
//! | job | file |
//! |---|---|
//! | the arm and the floor it stands on | here |
//! | cylinders, balls and boxes as lit triangles | `shapes` |
//! | triangles into pixels | `raster` |
//!
//! Two eyes stand before the arm to its right, 0.12 m apart, and look at the middle of where it works. The
//! floor has a line every 0.25 m, a thicker one each metre; the x axis is red, the y axis green. What is
//! drawn throws a shadow straight down, and a plumb line hangs from the tool, so that it can be seen how
//! high it is. Lengths and joints
//! are the arm's own; how thick it is drawn is a PUMA's, roughly.
//!
//! The same joints give the same picture on every machine.

mod raster;
mod shapes;

use super::View;
use nalgebra::{Matrix3, Vector3};
use raster::{Colour, Eye, Raster};
use shapes::{Pen, circle, sin_cos};
use tetrad_core::arm::puma560::{Joints, LinkRow, Puma560};
use tetrad_core::config::{JOINTS, PumaConfig, PumaConfigError};
use tetrad_core::geometry::Pose;

/// Where the eyes stand and what they look at, metres in the arm's base; the focal length in picture
/// widths; and how far the eyes are apart: twice a head's, for at this distance a head's is hardly seen as
/// depth, and more is hard to look at.
const STAND_M: [f32; 3] = [2.50, -1.70, 1.60];
const LOOK_AT_M: [f32; 3] = [0.15, 0.00, 0.80];
const FOCAL_WIDTHS: f32 = 1.15;
const EYES_APART_M: f32 = 0.12;

/// Light grey paint, dark castings, and the tool.
const PAINT: Colour = [0.93, 0.91, 0.84];
const CASTING: Colour = [0.36, 0.38, 0.42];
const STEEL: Colour = [0.62, 0.65, 0.70];
const PLUMB: Colour = [0.90, 0.15, 0.60];
const FINGERS: [Colour; 2] = [[0.95, 0.45, 0.10], [0.15, 0.45, 0.95]];

/// Along the second joint's axis from the base's axis to the middle of the upper arm, metres (a PUMA's
/// shoulder is this much wider than the forearm is beside it).
const UPPER_ARM_OUT_M: f32 = 0.22;

/// A drawing of one arm from one eye.
pub struct ArmDrawing {
    arm: Puma560<f64>,
    circle: Vec<(f32, f32)>,
    background: Raster,
    raster: Raster,
}

impl ArmDrawing {
    /// Sets up a drawing.
    ///
    /// # Errors
    /// [`PumaConfigError`] for an arm that cannot be computed with.
    pub fn new(puma: &PumaConfig, view: View, size: (u16, u16)) -> Result<Self, PumaConfigError> {
        let arm = Puma560::new(puma)?;
        let side = match view {
            View::Left => -0.5,
            View::Right => 0.5,
        };
        let focal_px = FOCAL_WIDTHS * f32::from(size.0);
        let at = Vector3::from(LOOK_AT_M);
        let middle = Eye::looking_at(size, focal_px, Vector3::from(STAND_M), at);
        let eye = Eye::looking_at(size, focal_px, middle.beside(side * EYES_APART_M), at);
        let mut background = Raster::new(eye);
        floor(&mut background);
        Ok(Self { arm, circle: circle(), raster: background.clone(), background })
    }

    /// Pixels.
    #[must_use]
    pub const fn size(&self) -> (usize, usize) {
        (self.raster.eye.width, self.raster.eye.height)
    }

    /// Draws the arm with its joints there, radians; the picture as RGB, row by row.
    pub fn draw(&mut self, joints: &Joints<f64>) -> &[u8] {
        self.raster.start_from(&self.background);
        let frames = frames(&self.arm.links(), joints);
        let tool = single(&self.arm.forward(joints));
        let offset = self.arm.links()[2].d_m as f32;
        for shadows in [true, false] {
            let mut pen = Pen { raster: &mut self.raster, shadows, circle: &self.circle };
            draw_arm(&mut pen, &frames, offset, &tool);
        }
        &self.raster.rgb
    }
}

/// The links' frames in the base, the base's own first.
fn frames(links: &[LinkRow<f64>; JOINTS], joints: &Joints<f64>) -> [Pose<f32>; JOINTS + 1] {
    let mut at = Pose::<f64>::identity();
    let mut frames = [single(&at); JOINTS + 1];
    for ((link, angle), frame) in links.iter().zip(joints).zip(frames.iter_mut().skip(1)) {
        at = at.compose(&link_pose(link, *angle));
        *frame = single(&at);
    }
    frames
}

/// `Rz(q) Tz(d) Tx(a) Rx(alpha)`.
fn link_pose(link: &LinkRow<f64>, angle: f64) -> Pose<f64> {
    let ((s, c), (sa, ca)) = (sin_cos(angle), sin_cos(link.alpha_rad));
    #[rustfmt::skip]
    let rotation = Matrix3::new(
        c, -s * ca, s * sa,
        s, c * ca, -c * sa,
        0.0, sa, ca,
    );
    Pose { rotation, translation: Vector3::new(link.a_m * c, link.a_m * s, link.d_m) }
}

fn single(pose: &Pose<f64>) -> Pose<f32> {
    Pose { rotation: pose.rotation.map(|x| x as f32), translation: pose.translation.map(|x| x as f32) }
}

fn draw_arm(pen: &mut Pen<'_>, frames: &[Pose<f32>; JOINTS + 1], offset: f32, tool: &Pose<f32>) {
    let [base, shoulder, elbow, forearm, wrist, ..] = frames;
    let axis = |pose: &Pose<f32>, at: usize| -> Vector3<f32> { pose.rotation.column(at).into() };
    let up = Vector3::z();
    // the column
    pen.cone(CASTING, [base.translation, base.translation + up * 0.04], [0.17, 0.16]);
    let top = shoulder.translation;
    pen.cone(PAINT, [base.translation + up * 0.04, top - up * 0.10], [0.10, 0.09]);
    pen.cone(PAINT, [top - up * 0.14, top + up * 0.11], [0.115, 0.115]);
    // the shoulder lies across, the upper arm outside of it, the forearm back in
    let across = axis(shoulder, 2);
    let out = if offset < 0.0 { -1.0 } else { 1.0 };
    let beside = across * (UPPER_ARM_OUT_M * out);
    pen.cone(PAINT, [top - across * (0.11 * out), top + beside], [0.095, 0.095]);
    let [hip, knee] = [top + beside, elbow.translation + beside];
    let thick = across * 0.055;
    pen.cone(CASTING, [hip - thick, hip + thick], [0.105, 0.105]);
    pen.cone(PAINT, [hip, knee], [0.085, 0.065]);
    pen.cone(CASTING, [knee - thick, knee + thick], [0.075, 0.075]);
    let bend = elbow.translation + across * offset;
    pen.cone(PAINT, [knee, bend], [0.06, 0.06]);
    pen.ball(CASTING, bend, 0.07);
    let [from, hand] = [forearm.translation, wrist.translation];
    pen.cone(PAINT, [bend, from], [0.06, 0.06]);
    pen.cone(PAINT, [from, hand], [0.06, 0.042]);
    pen.ball(CASTING, hand, 0.047);
    draw_tool(pen, hand, tool);
}

/// The flange and a gripper: what it points along is the tool's z axis, its fingers lie along x, one in
/// orange (+x), one in blue.
fn draw_tool(pen: &mut Pen<'_>, hand: Vector3<f32>, tool: &Pose<f32>) {
    let [x, z]: [Vector3<f32>; 2] = [0, 2].map(|at| tool.rotation.column(at).into());
    let at = tool.translation;
    pen.cone(STEEL, [hand, at], [0.034, 0.034]);
    pen.cone(CASTING, [at - z * 0.008, at + z * 0.006], [0.045, 0.045]);
    pen.block(STEEL, at + z * 0.025, &tool.rotation, Vector3::new(0.055, 0.03, 0.02));
    if !pen.shadows {
        // a plumb line to where the tool would touch the floor
        let foot = Vector3::new(at.x, at.y, 0.0);
        pen.cone(PLUMB, [foot, at], [0.0025, 0.0025]);
        pen.cone(PLUMB, [foot, foot + Vector3::z() * 0.002], [0.02, 0.02]);
    }
    for (side, colour) in [1.0, -1.0].into_iter().zip(FINGERS) {
        let middle = at + z * 0.075 + x * (0.042 * side);
        pen.block(colour, middle, &tool.rotation, Vector3::new(0.010, 0.018, 0.035));
    }
}

/// The floor with its lines, and what is behind it.
fn floor(raster: &mut Raster) {
    let eye = raster.eye;
    for v in 0..eye.height {
        for u in 0..eye.width {
            let pixel = v * eye.width + u;
            let (colour, nearness) = match eye.floor(u, v) {
                Some((place, depth)) => (floor_colour(&place, depth, eye.width), 1.0 / depth),
                None => (BEHIND, 0.0),
            };
            raster.nearness[pixel] = nearness;
            for (value, channel) in raster.rgb[3 * pixel..3 * pixel + 3].iter_mut().zip(colour) {
                *value = (channel * 255.0 + 0.5) as u8;
            }
        }
    }
}

const BEHIND: Colour = [0.72, 0.78, 0.84];
const GROUND: Colour = [0.58, 0.60, 0.58];
const LINE: Colour = [0.40, 0.42, 0.41];

/// Lines of the floor, metres: from one to the next, and half as wide as they are.
const LINE_EVERY_M: f32 = 0.25;
const LINE_HALF_M: f32 = 0.003;

/// From here on the floor fades, up to where it is gone, metres from the eye.
const FADES_M: [f32; 2] = [4.0, 9.0];

fn floor_colour(place: &Vector3<f32>, depth: f32, width: usize) -> Colour {
    // what a pixel covers there: a line is never thinner
    let pixel_m = depth / (FOCAL_WIDTHS * width as f32);
    let line = |x: f32, every: f32, half: f32| {
        let off = (x - (x / every).round() * every).abs();
        let half = half.max(0.5 * pixel_m);
        ((half + 0.5 * pixel_m - off) / pixel_m).clamp(0.0, 1.0)
    };
    let thin = line(place.x, LINE_EVERY_M, LINE_HALF_M).max(line(place.y, LINE_EVERY_M, LINE_HALF_M));
    let thick = line(place.x, 1.0, 2.5 * LINE_HALF_M).max(line(place.y, 1.0, 2.5 * LINE_HALF_M));
    let mut colour = mix(GROUND, LINE, thin.max(thick));
    // the axes, a metre each
    let axis = |along: f32, across: f32| {
        if (0.0..1.0).contains(&along) { line(across, f32::MAX, 3.0 * LINE_HALF_M) } else { 0.0 }
    };
    colour = mix(colour, [0.85, 0.20, 0.15], axis(place.x, place.y));
    colour = mix(colour, [0.15, 0.60, 0.20], axis(place.y, place.x));
    let [from, to] = FADES_M;
    mix(colour, BEHIND, ((depth - from) / (to - from)).clamp(0.0, 1.0))
}

fn mix(a: Colour, b: Colour, share: f32) -> Colour {
    [0, 1, 2].map(|channel| a[channel] + (b[channel] - a[channel]) * share)
}

#[cfg(test)]
mod tests;
