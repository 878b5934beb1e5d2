use super::super::{Configuration, Singularity};
use super::{apart, arm, joints};
use crate::arm::puma560::{Joints, Puma560};
use crate::config::PumaConfig;
use crate::geometry::Pose;
use core::f64::consts::FRAC_PI_2;
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

/// The link table multiplied out row by row: its definition.
fn by_links(arm: &Puma560<f64>, joints: &Joints<f64>) -> Pose<f64> {
    let links = arm.links().iter().zip(joints).fold(Pose::identity(), |base, (link, &q)| {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), q);
        let tilt = Rotation3::from_axis_angle(&Vector3::x_axis(), link.alpha_rad);
        base.compose(&Pose {
            rotation: (turn * tilt).into_inner(),
            translation: turn * Vector3::new(link.a_m, 0.0, link.d_m),
        })
    });
    links.compose(&arm.config().tool)
}

/// A tool that is neither on the last axis nor in line with it.
fn with_tool() -> Puma560<f64> {
    let tool = Pose {
        rotation: Rotation3::from_euler_angles(0.3, -0.8, 1.9).into_inner(),
        translation: Vector3::new(0.02, -0.05, 0.11),
    };
    Puma560::new(&PumaConfig { tool, ..PumaConfig::default() }).expect("a valid tool")
}

#[test]
fn the_arm_at_zero_is_where_the_link_table_says() {
    let pose = arm::<f64>().forward(&[0.0; 6]);
    assert_eq!(pose.rotation, Matrix3::identity());
    let flange = 0.67183 + 0.4318 + 0.05625;
    assert!((pose.translation - Vector3::new(0.4318 + 0.0203, -0.15005, flange)).norm() < 1e-15);
}

#[test]
fn single_precision_is_the_same_arm() {
    let q = [0.3, -0.4, 0.5, -0.6, 0.7, -0.8];
    let single = arm::<f32>().forward(&q.map(|x| x as f32));
    let double = arm::<f64>().forward(&q);
    let widened = Pose { rotation: single.rotation.cast(), translation: single.translation.cast() };
    assert!(apart(&widened, &double) < 5e-7, "{}", apart(&widened, &double));
}

#[test]
fn each_singularity_is_the_nearest_where_it_is() {
    let arm = arm::<f64>();
    let nearest = |q: Joints<f64>| arm.nearest_singularity(&arm.singularities(&q));
    let (wrist, near) = nearest([0.1, 0.4, -0.3, 0.5, 0.0, 0.2]);
    assert!(wrist == Singularity::Wrist && near == 0.0);
    let stretched = -libm::atan2(0.4318, 0.0203);
    let (elbow, near) = nearest([0.1, 0.4, stretched, 0.5, 0.9, 0.2]);
    assert!(elbow == Singularity::Elbow && near < 1e-15);
    // upper arm up, forearm up: the wrist centre is a3 from the first axis' plane
    let (shoulder, near) = nearest([0.1, FRAC_PI_2, 0.0, 0.5, 0.9, 0.2]);
    assert!(shoulder == Singularity::Shoulder && near > 0.4 && near < 0.6);
    assert_eq!(arm.configuration(&[0.0, 0.0, -FRAC_PI_2 - 0.5, 0.0, -0.5, 0.0]).code(), "run");
}

#[test]
fn a_configuration_on_a_singularity_is_the_one_before() {
    let arm = arm::<f64>();
    let at = arm.singularities(&[0.1, 0.4, -0.3, 0.5, 0.0, 0.2]);
    for before in Configuration::ALL {
        assert_eq!(at.configuration(before).wrist, before.wrist);
    }
}

proptest! {
    #[test]
    fn forward_is_the_product_of_the_link_table(q in joints()) {
        let arm = with_tool();
        prop_assert!(apart(&arm.forward(&q), &by_links(&arm, &q)) < 1e-14);
    }

    #[test]
    fn the_jacobian_is_how_the_pose_changes(q in joints(), which in 0usize..6) {
        let (arm, step) = (with_tool(), 1e-6);
        let moved = |by: f64| {
            let mut q = q;
            q[which] += by;
            arm.forward(&q)
        };
        let (a, b) = (moved(-step), moved(step));
        let column = arm.jacobian(&q).column(which).into_owned();
        let velocity = (b.translation - a.translation) / (2.0 * step);
        prop_assert!((velocity - column.fixed_rows::<3>(0)).norm() < 1e-9);
        let spin = (b.rotation - a.rotation) * arm.forward(&q).rotation.transpose() / (2.0 * step);
        let spin = Vector3::new(spin.m32, spin.m13, spin.m21);
        prop_assert!((spin - column.fixed_rows::<3>(3)).norm() < 1e-9);
    }

    #[test]
    fn the_determinant_is_the_product_of_its_factors(q in joints()) {
        let arm = with_tool();
        let product = arm.determinant(&arm.singularities(&q));
        prop_assert!((arm.jacobian(&q).determinant() - product).abs() < 1e-14);
    }
}
