use super::*;

#[test]
fn uniform_search_visits_the_centre_then_quarters() {
    let region = Region { x0: 0, y0: 0, x1: 64, y1: 64 };
    let first: [(i32, i32); 5] = core::array::from_fn({
        let mut search = UniformSearch::new(region, 8.0);
        move |_| search.next().unwrap()
    });
    assert_eq!(first, [(32, 32), (16, 16), (48, 16), (16, 48), (48, 48)]);
}

#[test]
fn uniform_search_ends_with_a_box_under_half_the_diameter() {
    for side in [1, 7, 48, 64, 480, 640] {
        for diameter in [2.0, 5.0, 16.0, 65.0] {
            let region = Region { x0: 3, y0: 5, x1: 3 + side, y1: 5 + side };
            let search = UniformSearch::new(region, diameter);
            assert!(search.finest_box() < (diameter * 0.5f32).max(1.0));
            let mut count = 0u32;
            for (x, y) in search {
                assert!(x >= region.x0 && x < region.x1 && y >= region.y0 && y < region.y1);
                count += 1;
            }
            let levels = search.last_level;
            assert_eq!(count, (4u32.pow(levels + 1) - 1) / 3);
            let ratio = 2.0 * side as f32 / diameter.max(2.0);
            assert!(count as f32 <= (16.0 / 3.0) * ratio * ratio + 1.0, "{count} {side} {diameter}");
        }
    }
}

#[test]
fn every_disc_of_the_expected_diameter_is_hit() {
    let region = Region { x0: 0, y0: 0, x1: 48, y1: 48 };
    for i in 0..400 {
        let (u, v) = (8.0 + (i % 20) as f32 * 1.6, 8.0 + (i / 20) as f32 * 1.6);
        let hit = UniformSearch::new(region, 16.0).any(|(x, y)| {
            let (du, dv) = (x as f32 - u, y as f32 - v);
            du * du + dv * dv < 64.0
        });
        assert!(hit, "{u} {v}");
    }
}

#[test]
fn a_copy_of_the_search_goes_on_from_the_same_place() {
    let mut search = UniformSearch::new(Region { x0: 0, y0: 0, x1: 100, y1: 80 }, 10.0);
    for _ in 0..17 {
        search.next();
    }
    let kept = search;
    let mut rest = kept;
    assert!(search.by_ref().eq(rest.by_ref()));
}

#[test]
fn spiral_segments_are_1_1_2_2_3_3() {
    let mut spiral = Spiral::new(0, 0, 9.0);
    let mut at = spiral.next().unwrap();
    assert_eq!(at, (0, 0));
    for n in [1, 1, 2, 2, 3, 3, 4, 4, 5] {
        let first = spiral.next().unwrap();
        let step = (first.0 - at.0, first.1 - at.1);
        at = first;
        for _ in 1..n {
            let next = spiral.next().unwrap();
            assert_eq!((next.0 - at.0, next.1 - at.1), step);
            at = next;
        }
    }
}

#[test]
fn spiral_covers_a_square_once_and_is_bounded_by_nine_d_squared() {
    for d in [2.0f32, 5.0, 16.0] {
        let side = 3.0 * d;
        let mut seen = [[false; 80]; 80];
        let mut count = 0;
        for (x, y) in Spiral::new(0, 0, side) {
            let cell = &mut seen[(y + 40) as usize][(x + 40) as usize];
            assert!(!*cell, "visited twice");
            *cell = true;
            count += 1;
        }
        assert!(count as f32 >= side * side, "{count} for {d}");
        assert!((count as f32) <= (side + 2.0) * (side + 2.0), "{count} for {d}");
    }
}

#[test]
fn turns_close_on_complete_squares() {
    let mut spiral = Spiral::new(0, 0, 21.0);
    let mut count = 0u32;
    let mut closed = 0;
    while spiral.next().is_some() {
        count += 1;
        if spiral.closed_a_turn() {
            let side = libm::sqrtf(count as f32) as u32;
            assert_eq!(side * side, count, "a turn closes on a square of odd side");
            assert_eq!(side % 2, 1);
            closed += 1;
        }
    }
    assert!(closed >= 10, "{closed}");
}

#[test]
fn a_window_outside_the_picture_is_none() {
    assert_eq!(Region::square(-100.0, 10.0, 48.0, 640, 480), None);
    assert_eq!(Region::square(f32::NAN, 10.0, 48.0, 640, 480), None);
    assert_eq!(Region::square(1e30, 1e30, 48.0, 640, 480), None);
    let cut = Region::square(0.0, 479.0, 48.0, 640, 480).unwrap();
    assert_eq!((cut.x0, cut.y1), (0, 480));
}

#[test]
fn impossible_coordinates_do_not_overflow() {
    for (a, b) in [(i32::MIN, i32::MAX), (i32::MAX, i32::MIN), (i32::MAX, i32::MAX)] {
        let region = Region { x0: a, y0: a, x1: b, y1: b };
        assert!(
            UniformSearch::new(region, 4000.0)
                .take(10_000)
                .all(|(x, y)| x.abs() <= 1 << 15 && y.abs() <= 1 << 15)
        );
        assert!(Spiral::new(a, b, 50.0).all(|(x, y)| x.abs() <= 1 << 15 && y.abs() <= 1 << 15));
    }
}
