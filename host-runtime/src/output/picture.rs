//! A picture with what was seen drawn over it.

use super::csv::OutputError;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;
use tetrad_core::observation::{Ball, ObservationState, Observations};
use tetrad_core::vision::frame::{FrameView, PixelFormat, Rgb};
use tetrad_core::vision::tracker::StepReport;

/// Marks of a ball that was seen whole.
const WHITE: Rgb = Rgb::new(255, 255, 255);
/// Marks of a ball that was not, and the outline of every mark.
const BLACK: Rgb = Rgb::new(0, 0, 0);
/// Half the length of a centre cross, pixels.
const CROSS: i32 = 5;

/// An RGB picture to draw on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Canvas {
    width: i32,
    height: i32,
    rgb: Vec<u8>,
}

impl Canvas {
    /// Copies of pictures side by side.
    #[must_use]
    pub fn side_by_side(frames: &[FrameView<'_>]) -> Self {
        let width = frames.iter().map(|frame| i32::from(frame.width())).sum();
        let height = frames.iter().map(|frame| i32::from(frame.height())).max().unwrap_or(0);
        let mut canvas = Self { width, height, rgb: vec![0; (width * height * 3) as usize] };
        let mut left = 0;
        for frame in frames {
            let (w, h) = (i32::from(frame.width()), i32::from(frame.height()));
            for y in 0..h {
                for x in 0..w {
                    if let Some(colour) = frame.pixel(x, y) {
                        canvas.set(left + x, y, colour);
                    }
                }
            }
            left += w;
        }
        canvas
    }

    /// Draws a camera's search windows and centres; its picture's first column is at `left`. White is
    /// seen whole, black in part or predicted; a lost ball has no cross.
    pub fn draw(&mut self, left: i32, report: &StepReport) {
        for ball in Ball::ALL {
            let seen = &report.observations[ball.index()];
            if let Some(window) = report.windows[ball.index()] {
                self.rectangle((left + window.x0, window.y0), (left + window.x1, window.y1), WHITE);
            }
            let colour = match seen.state {
                ObservationState::Visible => WHITE,
                ObservationState::Occluded | ObservationState::Predicted => BLACK,
                ObservationState::Lost => continue,
            };
            let (x, y) = (left + seen.centre.u.round() as i32, seen.centre.v.round() as i32);
            for d in -CROSS..=CROSS {
                self.set(x + d, y, colour);
                self.set(x, y + d, colour);
            }
        }
    }

    /// Draws a circle around each ball that has a place: white where it is seen whole, black where it is
    /// seen in part or predicted.
    pub fn circles(&mut self, balls: &Observations) {
        for ball in balls {
            let colour = match ball.state {
                ObservationState::Visible => WHITE,
                ObservationState::Occluded | ObservationState::Predicted => BLACK,
                ObservationState::Lost => continue,
            };
            let radius = 0.5 * f64::from(ball.diameter);
            let (u, v) = (f64::from(ball.centre.u), f64::from(ball.centre.v));
            // two marks a pixel of the rim leave no hole; a nonsense size costs no more than this
            let marks = (4.0 * std::f64::consts::PI * radius).clamp(8.0, 50_000.0).ceil();
            for mark in 0..marks as u32 {
                let (sin, cos) = (f64::from(mark) / marks * std::f64::consts::TAU).sin_cos();
                self.set((u + radius * cos).round() as i32, (v + radius * sin).round() as i32, colour);
            }
        }
    }

    /// The pixels, row by row: red, green, blue.
    #[must_use]
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// The picture as a frame; `None` where it is too wide or too high for one.
    #[must_use]
    pub fn view(&self) -> Option<FrameView<'_>> {
        let (width, height) = (u16::try_from(self.width).ok()?, u16::try_from(self.height).ok()?);
        FrameView::new(&self.rgb, width, height, 3 * usize::from(width), PixelFormat::Rgb888).ok()
    }

    /// Writes a PNG file.
    ///
    /// # Errors
    /// [`OutputError`] naming the file.
    pub fn save(&self, path: &Path) -> Result<(), OutputError> {
        let save = || -> Result<(), io::Error> {
            let file = BufWriter::new(File::create(path)?);
            let mut encoder = png::Encoder::new(file, self.width as u32, self.height as u32);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&self.rgb)?;
            writer.finish()?;
            Ok(())
        };
        save().map_err(|cause| OutputError { path: path.to_owned(), cause })
    }

    fn rectangle(&mut self, (x0, y0): (i32, i32), (x1, y1): (i32, i32), colour: Rgb) {
        for x in x0..=x1 {
            self.set(x, y0, colour);
            self.set(x, y1, colour);
        }
        for y in y0..=y1 {
            self.set(x0, y, colour);
            self.set(x1, y, colour);
        }
    }

    /// Sets a pixel; one outside the picture is left out.
    fn set(&mut self, x: i32, y: i32, colour: Rgb) {
        if (0..self.width).contains(&x) && (0..self.height).contains(&y) {
            let at = (y * self.width + x) as usize * 3;
            self.rgb[at..at + 3].copy_from_slice(&[colour.r, colour.g, colour.b]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::geometry::ImagePoint;
    use tetrad_core::observation::Observation;
    use tetrad_core::vision::frame::PixelFormat;

    const GREY: Rgb = Rgb::new(90, 90, 90);

    fn at(canvas: &Canvas, x: i32, y: i32) -> Rgb {
        let i = (y * canvas.width + x) as usize * 3;
        Rgb::new(canvas.rgb[i], canvas.rgb[i + 1], canvas.rgb[i + 2])
    }

    #[test]
    fn marks_are_where_the_balls_are_in_the_second_picture() {
        let bytes = [90; 20 * 10 * 3];
        let frame = FrameView::packed(&bytes, 20, 10, PixelFormat::Rgb888).unwrap();
        let mut canvas = Canvas::side_by_side(&[frame, frame]);
        let mut report = StepReport::default();
        let visible = ObservationState::Visible;
        report.observations[1] = Observation {
            state: visible,
            centre: ImagePoint::new(18.4, 4.0),
            diameter: 5.0,
            ..Observation::default()
        };
        canvas.draw(20, &report);
        assert_eq!((at(&canvas, 38, 4), at(&canvas, 33, 4), at(&canvas, 38, 9)), (WHITE, WHITE, WHITE));
        assert_eq!((at(&canvas, 18, 4), at(&canvas, 32, 4), at(&canvas, 37, 3)), (GREY, GREY, GREY));

        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("seen.png");
        canvas.save(&path).unwrap();
        let decoder = png::Decoder::new(io::BufReader::new(File::open(&path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, canvas.rgb);
    }
}
