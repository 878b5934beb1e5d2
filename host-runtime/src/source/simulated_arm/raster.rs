//! Triangles into a picture with a depth for each pixel.

use nalgebra::{Matrix3, Vector3};

/// Nearer than this to the eye nothing is drawn, metres.
const NEAR_M: f32 = 0.05;

/// Red, green and blue, 0 to 1.
pub(super) type Colour = [f32; 3];

/// A pinhole camera: x right, y down, z ahead, pixel centres at integers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    pub(super) width: usize,
    pub(super) height: usize,
    focal_px: f32,
    place: Vector3<f32>,
    /// eye_from_world.
    turn: Matrix3<f32>,
}

impl Eye {
    /// An eye at a place that looks at another; up is z.
    pub(super) fn looking_at(
        (width, height): (u16, u16),
        focal_px: f32,
        place: Vector3<f32>,
        at: Vector3<f32>,
    ) -> Self {
        let ahead = unit(at - place);
        let right = unit(ahead.cross(&Vector3::z()));
        let down = ahead.cross(&right);
        let turn = Matrix3::from_rows(&[right.transpose(), down.transpose(), ahead.transpose()]);
        Self { width: usize::from(width), height: usize::from(height), focal_px, place, turn }
    }

    /// The place, to the right by so much: for the second of two eyes.
    pub(super) fn beside(&self, right_m: f32) -> Vector3<f32> {
        self.place + self.turn.row(0).transpose() * right_m
    }

    /// Where the ray through a pixel meets the floor z = 0: the place there, and its depth.
    pub(super) fn floor(&self, u: usize, v: usize) -> Option<(Vector3<f32>, f32)> {
        let x = (u as f32 - self.middle().0) / self.focal_px;
        let y = (v as f32 - self.middle().1) / self.focal_px;
        let ray = self.turn.transpose() * Vector3::new(x, y, 1.0);
        let depth = -self.place.z / ray.z;
        (ray.z < 0.0 && depth > NEAR_M).then(|| (self.place + ray * depth, depth))
    }

    /// Column, row and depth of a place; `None` behind the eye.
    pub(super) fn project(&self, place: &Vector3<f32>) -> Option<[f32; 3]> {
        let seen = self.turn * (place - self.place);
        let (u, v) = self.middle();
        (seen.z > NEAR_M)
            .then(|| [u + self.focal_px * seen.x / seen.z, v + self.focal_px * seen.y / seen.z, seen.z])
    }

    fn middle(&self) -> (f32, f32) {
        (0.5 * (self.width as f32 - 1.0), 0.5 * (self.height as f32 - 1.0))
    }
}

/// A vector of length 1 along this one, by a square root and a division alone: the same everywhere.
pub(super) fn unit(v: Vector3<f32>) -> Vector3<f32> {
    v / v.dot(&v).sqrt().max(f32::MIN_POSITIVE)
}

/// A corner, and the colour that the light makes there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) place: Vector3<f32>,
    pub(super) colour: Colour,
}

/// A picture that is being drawn.
#[derive(Clone, Debug)]
pub(super) struct Raster {
    pub(super) eye: Eye,
    /// Red, green, blue of each pixel, row by row.
    pub(super) rgb: Vec<u8>,
    /// One over the depth: 0 where there is nothing.
    pub(super) nearness: Vec<f32>,
    /// Pixels that lie in the shadow already.
    shaded: Vec<bool>,
}

impl Raster {
    pub(super) fn new(eye: Eye) -> Self {
        let pixels = eye.width * eye.height;
        Self { eye, rgb: vec![0; 3 * pixels], nearness: vec![0.0; pixels], shaded: vec![false; pixels] }
    }

    /// Begins anew from a picture of the same eye.
    pub(super) fn start_from(&mut self, background: &Self) {
        self.rgb.copy_from_slice(&background.rgb);
        self.nearness.copy_from_slice(&background.nearness);
        self.shaded.copy_from_slice(&background.shaded);
    }

    /// Draws a triangle where nothing is nearer.
    pub(super) fn triangle(&mut self, corners: &[Corner; 3]) {
        let colours = corners.map(|corner| corner.colour);
        let width = self.eye.width;
        let Some(spans) = Spans::of(&self.eye, &corners.map(|corner| corner.place)) else { return };
        spans.each(|u, v, shares, nearness| {
            let pixel = v * width + u;
            let (Some(before), Some(rgb)) =
                (self.nearness.get_mut(pixel), self.rgb.get_mut(3 * pixel..3 * pixel + 3))
            else {
                return;
            };
            if nearness <= *before {
                return;
            }
            *before = nearness;
            for (channel, value) in rgb.iter_mut().enumerate() {
                let sum: f32 = (0..3).map(|corner| shares[corner] * colours[corner][channel]).sum();
                *value = (sum * 255.0 + 0.5) as u8;
            }
        });
    }

    /// Darkens the floor under a triangle, once.
    pub(super) fn shadow(&mut self, corners: &[Vector3<f32>; 3]) {
        let width = self.eye.width;
        let corners = corners.map(|corner| Vector3::new(corner.x, corner.y, 0.0));
        let Some(spans) = Spans::of(&self.eye, &corners) else { return };
        spans.each(|u, v, _, _| {
            let pixel = v * width + u;
            let (Some(shaded), Some(rgb)) =
                (self.shaded.get_mut(pixel), self.rgb.get_mut(3 * pixel..3 * pixel + 3))
            else {
                return;
            };
            if !std::mem::replace(shaded, true) {
                rgb.iter_mut().for_each(|value| *value = (u16::from(*value) * 5 / 8) as u8);
            }
        });
    }
}

/// A triangle on the picture, as what is added from pixel to pixel.
struct Spans {
    /// Each corner's share of the first pixel, and what it gains a column and a row.
    at: [f32; 3],
    column: [f32; 3],
    row: [f32; 3],
    nearness: [f32; 3],
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Spans {
    /// `None` where nothing of it is to be seen.
    fn of(eye: &Eye, corners: &[Vector3<f32>; 3]) -> Option<Self> {
        let [Some(a), Some(b), Some(c)] = [0, 1, 2].map(|at| eye.project(&corners[at])) else { return None };
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 || !area.is_finite() {
            return None;
        }
        let range = |axis: usize, size: usize| {
            let least = a[axis].min(b[axis]).min(c[axis]).max(0.0).ceil();
            let most = a[axis].max(b[axis]).max(c[axis]).min(size as f32 - 1.0).floor();
            (least <= most).then_some([least as usize, most as usize])
        };
        let (columns, rows) = (range(0, eye.width)?, range(1, eye.height)?);
        let (u, v) = (columns[0] as f32, rows[0] as f32);
        // a corner's share is the area across from it
        let share = |p: [f32; 3], q: [f32; 3]| {
            let at = (q[0] - p[0]) * (v - p[1]) - (q[1] - p[1]) * (u - p[0]);
            [at, -(q[1] - p[1]), q[0] - p[0]].map(|value| value / area)
        };
        let shares = [share(b, c), share(c, a), share(a, b)];
        let pick = |place: usize| [0, 1, 2].map(|corner| shares[corner][place]);
        Some(Self {
            at: pick(0),
            column: pick(1),
            row: pick(2),
            nearness: [a, b, c].map(|corner| 1.0 / corner[2]),
            columns,
            rows,
        })
    }

    /// Column, row, shares of the corners and nearness of each pixel within.
    fn each(&self, mut pixel: impl FnMut(usize, usize, &[f32; 3], f32)) {
        let [first, last] = self.columns;
        for v in self.rows[0]..=self.rows[1] {
            let down = (v - self.rows[0]) as f32;
            let start = [0, 1, 2].map(|corner| self.at[corner] + down * self.row[corner]);
            for u in first..=last {
                let across = (u - first) as f32;
                let shares = [0, 1, 2].map(|corner| start[corner] + across * self.column[corner]);
                if shares.iter().all(|share| *share >= 0.0) {
                    let nearness = (0..3).map(|corner| shares[corner] * self.nearness[corner]).sum();
                    pixel(u, v, &shares, nearness);
                }
            }
        }
    }
}
