use super::*;
use crate::geometry::Pose;
use crate::hand::synthetic::{Camera, arms, cameras, number, pose, two_cameras};
use proptest::prelude::*;
use std::vec::Vec;

fn frame(reference: &[Centres]) -> Result<AffineFrame, AffineRefusal> {
    AffineFrame::new(reference, arms(), &HandConfig::default())
}

fn centres(cameras: &[Camera], hand: &Pose) -> Vec<Centres> {
    cameras.iter().map(|camera| camera.centres(hand)).collect()
}

proptest! {
    #[test]
    fn orthographic_cameras_place_any_point_exactly(
        cameras in cameras(),
        hand in pose(3.1, 0.2),
        point in prop::array::uniform3(-0.3_f32..0.3),
    ) {
        let frame = frame(&centres(&cameras, &hand)).unwrap();
        let alpha = Vector3::from(point);
        let seen: Vec<_> =
            cameras.iter().map(|c| c.project(hand.rotation * alpha + hand.translation)).collect();
        let located = frame.locate(&seen).unwrap();
        prop_assert!((located.alpha - alpha).norm() < 2e-5, "{}", (located.alpha - alpha).norm());
        prop_assert!(located.residual_px < 2e-3, "{}", located.residual_px);
    }

    #[test]
    fn noise_goes_where_least_squares_puts_it(
        cameras in cameras(),
        hand in pose(3.1, 0.2),
        noise in prop::array::uniform16(-1.0_f32..1.0),
    ) {
        // the residual of a least squares solution is orthogonal to every column of M
        let reference = centres(&cameras, &hand);
        let frame = frame(&reference).unwrap();
        let seen: Vec<_> = reference
            .iter()
            .zip(noise.chunks(2))
            .map(|(centres, n)| centres[0] + ImagePoint::new(n[0], n[1]))
            .collect();
        let located = frame.locate(&seen).unwrap();
        let mut gradient = Vector3::zeros();
        let mut squares = 0.0;
        for (view, point) in frame.views.iter().zip(&seen) {
            let error = *point - view.project(&located.alpha);
            let [row_u, row_v] = view.rows();
            gradient += row_u * error.u + row_v * error.v;
            squares += error.u * error.u + error.v * error.v;
        }
        let largest = frame.views.iter().flat_map(AffineView::rows).map(|r| r.norm()).fold(0.0, f32::max);
        prop_assert!(gradient.norm() < 2e-3 * largest, "{} of {largest}", gradient.norm());
        let rms = (squares / (2.0 * seen.len() as f32)).sqrt();
        prop_assert!((located.residual_px - rms).abs() < 1e-6);
    }

    #[test]
    fn the_singular_value_ratio_is_that_of_the_known_matrix(
        singular in prop::array::uniform3(0.0_f32..1.0),
        scale in 0.1_f32..3000.0,
        r in crate::hand::synthetic::rotation(3.1),
    ) {
        let largest = singular.iter().copied().fold(0.0, f32::max);
        prop_assume!(largest > 0.1);
        let smallest = singular.iter().copied().fold(1.0, f32::min);
        let m = Matrix3::from_diagonal(&(Vector3::from(singular) * scale)) * r;
        let ratio = singular_value_ratio(&(m.transpose() * m)).unwrap();
        // squares of singular values are compared: that is what M^t M holds to f32's precision
        let (got, want) = (ratio * ratio, (smallest / largest).powi(2));
        prop_assert!((got - want).abs() < 3e-4, "{got} {want}");
    }

    #[test]
    fn nothing_but_a_finite_place_comes_out(values in prop::collection::vec(number(), 24)) {
        let centres: Vec<Centres> = values
            .chunks(8)
            .map(|c| core::array::from_fn(|i| ImagePoint::new(c[2 * i], c[2 * i + 1])))
            .collect();
        if let Ok(frame) = frame(&centres) {
            prop_assert!(frame.conditioning() >= HandConfig::default().min_conditioning);
            let seen: Vec<_> = centres.iter().map(|c| c[2]).collect();
            if let Ok(located) = frame.locate(&seen) {
                prop_assert!(located.alpha.iter().all(|a| a.is_finite()) && located.residual_px.is_finite());
            }
        }
    }
}

#[test]
fn conditioning_of_two_cameras_is_the_sine_of_half_their_angle() {
    for degrees in [4.0_f32, 10.0, 30.0, 60.0, 90.0] {
        let angle = degrees.to_radians();
        let pair = [Camera::orthographic(0.2, 0.0, 600.0), Camera::orthographic(0.2 + angle, 0.0, 600.0)];
        let frame = frame(&centres(&pair, &Pose::identity())).unwrap();
        assert!(
            (frame.conditioning() - (angle / 2.0).sin()).abs() < 2e-3,
            "{degrees}: {}",
            frame.conditioning()
        );
    }
}

#[test]
fn the_projection_is_eq_6() {
    let [camera, _] = two_cameras();
    let view = AffineView::new(&camera.centres(&Pose::identity()), arms());
    for (ball, centre) in arms().balls_in_frame().iter().zip(camera.centres(&Pose::identity())) {
        assert!(view.project(ball).distance(centre) < 1e-4);
    }
}

#[test]
fn an_arm_in_millimetres_is_refused() {
    assert!(Arms::equal(0.08).is_ok());
    for bad in [80.0, 0.0, -0.08, 0.004, f32::NAN, f32::INFINITY] {
        assert_eq!(Arms::new([0.08, 0.08, bad]), Err(AffineRefusal::BadArmLength), "{bad}");
    }
}

#[test]
fn refusals() {
    use AffineRefusal::*;
    let hand = Pose { rotation: Matrix3::identity(), translation: Vector3::new(0.02, -0.03, 0.1) };
    let good = centres(&two_cameras(), &hand);
    let refused = |reference: &[Centres]| frame(reference).map(|f| f.conditioning()).unwrap_err();

    assert_eq!(refused(&[]), TooFewViews);
    assert_eq!(refused(&good[..1]), TooFewViews, "one view is under-determined");
    assert_eq!(refused(&[good[0]; 9]), TooManyViews);
    assert_eq!(refused(&[good[0], good[0]]), IllConditioned, "identical views");
    let parallel = [Camera::orthographic(0.3, 0.2, 600.0), Camera::orthographic(0.3, 0.2, 300.0)];
    assert_eq!(refused(&centres(&parallel, &hand)), IllConditioned, "parallel cameras of unlike zoom");
    let narrow = [Camera::orthographic(0.3, 0.2, 600.0), Camera::orthographic(0.33, 0.2, 600.0)];
    assert_eq!(refused(&centres(&narrow, &hand)), IllConditioned, "cameras 1.7 degrees apart");

    // three arms in one plane: E3 seen halfway between E1 and E2 everywhere
    let flat: Vec<_> = good.iter().map(|&[o, a, b, _]| [o, a, b, (a + b) * 0.5]).collect();
    assert_eq!(refused(&flat), IllConditioned, "balls in one plane");
    let coincident: Vec<_> = good.iter().map(|&[o, a, _, b]| [o, a, o, b]).collect();
    assert_eq!(refused(&coincident), CoincidentBalls);
    assert_eq!(refused(&[[ImagePoint::new(9.0, 9.0); 4]; 2]), CoincidentBalls, "all in one place");
    let one_end_on = [good[0], [good[1][0], good[1][0], good[1][2], good[1][3]]];
    assert!(frame(&one_end_on).is_ok(), "an arm seen end-on by one camera is seen by the other");

    for bad in [f32::NAN, f32::INFINITY] {
        let mut broken = good.clone();
        broken[1][2].v = bad;
        assert_eq!(refused(&broken), NotFinite);
    }
    let huge: Vec<_> = good.iter().map(|c| c.map(|p| p * 1e30)).collect();
    assert_eq!(refused(&huge), NotFinite, "its squares overflow");

    let frame = frame(&good).unwrap();
    let zero = ImagePoint::default();
    assert_eq!(frame.locate(&[zero]), Err(UnequalViews));
    assert_eq!(frame.locate(&[zero; 3]), Err(UnequalViews));
    assert_eq!(frame.locate(&[zero, ImagePoint::new(f32::NAN, 0.0)]), Err(NotFinite));
    assert_eq!(frame.locate(&[zero, ImagePoint::new(1e30, 0.0)]), Err(NotFinite));
}
