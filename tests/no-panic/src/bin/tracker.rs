//! Teaching, placing and tracking four balls in any picture, with any settings.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::config::TrackerConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::{Primary, Reference};
use tetrad_core::vision::frame::{FrameView, PixelFormat, Rgb};
use tetrad_core::vision::tracker::CameraTracker;

tetrad_no_panic::program!({
    let colour = || black_box(Rgb::new(1, 2, 3));
    let balls = black_box([(); 4]).map(|()| {
        let reference = Reference {
            primary: black_box(Primary::Green),
            reference: colour(),
            typical: colour(),
            background: colour(),
        };
        black_box(Some(LearntBall { reference, diameter: black_box(9.0), aspect: black_box(1.0) }))
    });
    if let Ok(mut tracker) = CameraTracker::new(black_box(TrackerConfig::default()), balls) {
        tracker.place(black_box(Ball::Blue), black_box(ImagePoint::new(1.0, 2.0)));
        let format = black_box(PixelFormat::Yuyv);
        let frame = FrameView::new(black_box(&[0; 64]), black_box(8), black_box(4), black_box(16), format);
        if let Ok(frame) = frame {
            let prediction = black_box([Some(ImagePoint::new(1.0, 2.0)); 4]);
            black_box(tracker.step(&frame, black_box(1), &prediction));
            black_box(tracker.step(&frame, black_box(0), &prediction));
        }
    }
});
