//! What arms are made of, as triangles that the light falls on.

use super::raster::{Colour, Corner, Raster, unit};
use nalgebra::{Matrix3, Vector3};

/// Sides of what is round.
const SIDES: usize = 20;

/// Rings of half a ball.
const RINGS: usize = 6;

/// What is bright though the light does not reach it.
const AMBIENT: f32 = 0.42;

/// Where the light comes from: from above, a little from the front and the side, so that no two faces of
/// a box look alike.
fn light() -> Vector3<f32> {
    unit(Vector3::new(0.45, -0.35, 0.82))
}

fn lit(colour: Colour, normal: &Vector3<f32>) -> Colour {
    let share = AMBIENT + (1.0 - AMBIENT) * normal.dot(&light()).max(0.0);
    colour.map(|channel| (channel * share).min(1.0))
}

/// A pass over all shapes: either their shadows on the floor or themselves.
pub(super) struct Pen<'a> {
    pub(super) raster: &'a mut Raster,
    pub(super) shadows: bool,
    /// Cosine and sine of each side's direction.
    pub(super) circle: &'a [(f32, f32)],
}

/// Directions of the sides of what is round, from what computes sines the same on every machine.
pub(super) fn circle() -> Vec<(f32, f32)> {
    let angle = |side: usize| std::f64::consts::TAU * side as f64 / SIDES as f64;
    (0..=SIDES).map(|side| sin_cos(angle(side))).map(|(sin, cos)| (cos as f32, sin as f32)).collect()
}

/// The same bits everywhere, unlike the standard library's.
pub(super) fn sin_cos(angle: f64) -> (f64, f64) {
    nalgebra::ComplexField::sin_cos(angle)
}

impl Pen<'_> {
    fn triangle(&mut self, colour: Colour, places: [Vector3<f32>; 3], normals: [Vector3<f32>; 3]) {
        if self.shadows {
            self.raster.shadow(&places);
            return;
        }
        let corner = |at: usize| Corner { place: places[at], colour: lit(colour, &normals[at]) };
        self.raster.triangle(&[corner(0), corner(1), corner(2)]);
    }

    fn quad(&mut self, colour: Colour, p: [Vector3<f32>; 4], n: [Vector3<f32>; 4]) {
        self.triangle(colour, [p[0], p[1], p[2]], [n[0], n[1], n[2]]);
        self.triangle(colour, [p[0], p[2], p[3]], [n[0], n[2], n[3]]);
    }

    /// A closed cone's part from one place to another, with a radius at each.
    pub(super) fn cone(&mut self, colour: Colour, ends: [Vector3<f32>; 2], radii: [f32; 2]) {
        let axis = unit(ends[1] - ends[0]);
        let aside = if axis.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
        let x = unit(axis.cross(&aside));
        let y = axis.cross(&x);
        let circle = self.circle;
        for pair in circle.windows(2) {
            let [out, next] = [pair[0], pair[1]].map(|(cos, sin)| x * cos + y * sin);
            let [a, b] = ends;
            let [r, s] = radii;
            let places = [a + out * r, a + next * r, b + next * s, b + out * s];
            self.quad(colour, places, [out, next, next, out]);
            self.triangle(colour, [a, places[1], places[0]], [-axis; 3]);
            self.triangle(colour, [b, places[3], places[2]], [axis; 3]);
        }
    }

    /// A ball.
    pub(super) fn ball(&mut self, colour: Colour, centre: Vector3<f32>, radius: f32) {
        let circle = self.circle;
        let level = |ring: usize| {
            let angle = std::f64::consts::PI * ring as f64 / (2 * RINGS) as f64;
            let (sin, cos) = sin_cos(angle);
            (cos as f32, sin as f32)
        };
        for ring in 0..2 * RINGS {
            let [upper, lower] = [level(ring), level(ring + 1)];
            for pair in circle.windows(2) {
                let out = |(cos, sin): (f32, f32), (z, r): (f32, f32)| Vector3::new(cos * r, sin * r, z);
                let normals =
                    [out(pair[0], upper), out(pair[1], upper), out(pair[1], lower), out(pair[0], lower)];
                self.quad(colour, normals.map(|normal| centre + normal * radius), normals);
            }
        }
    }

    /// A box around a centre, with axes and half its sides along them.
    pub(super) fn block(
        &mut self,
        colour: Colour,
        centre: Vector3<f32>,
        axes: &Matrix3<f32>,
        half: Vector3<f32>,
    ) {
        for axis in 0..3 {
            let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
            let side = |axis: usize| axes.column(axis) * half[axis];
            for sign in [-1.0, 1.0] {
                let middle = centre + side(axis) * sign;
                let (s, t) = (side(second), side(third));
                let normal: Vector3<f32> = axes.column(axis) * sign;
                let places = [middle - s - t, middle + s - t, middle + s + t, middle - s + t];
                self.quad(colour, places, [normal; 4]);
            }
        }
    }
}
