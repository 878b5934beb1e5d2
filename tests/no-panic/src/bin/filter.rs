//! The pose filter with any settings, times and poses.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::config::FilterConfig;
use tetrad_core::geometry::Pose;
use tetrad_core::hand::filter::PoseFilter;

tetrad_no_panic::program!({
    if let Ok(mut filter) = PoseFilter::new(black_box(FilterConfig::default())) {
        let _ = black_box(filter.measure(black_box(1), black_box(&Pose::identity())));
        let _ = black_box(filter.measure(black_box(2), black_box(&Pose::identity())));
        black_box(filter.coast(black_box(3)));
        filter.reset();
    }
});
