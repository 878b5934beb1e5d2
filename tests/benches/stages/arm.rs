//! The arm's kinematics at a thousand random poses, beside those of rs-opw-kinematics.
//!
//! Random poses are the worst case: which way each arc goes cannot be foretold. `inverse` gives all
//! eight solutions with the turns of their joints brought near to given ones, as the peer's
//! `inverse_continuing` does; the peer's `inverse` leaves out that and the ordering.

use divan::{Bencher, black_box};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use rs_opw_kinematics::kinematic_traits::{Kinematics, Pose as PeerPose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use std::f64::consts::FRAC_PI_2;
use tetrad_core::arm::governor::Governor;
use tetrad_core::arm::puma560::{Joints, Policy, Puma560, Recent};
use tetrad_core::arm::teleop::Order;
use tetrad_core::config::{GovernorConfig, PumaConfig};
use tetrad_core::geometry::Pose;
use tetrad_core::real::Real;

/// The poses are taken in turn, all of them in a sample.
const POSES: usize = 1000;

/// A pose, and the joints it comes from.
type At<T> = (Pose<T>, Joints<T>);

/// The arm without a tool, joints in their ranges, and the poses at them.
fn arm<T: Real>() -> (Puma560<T>, Vec<At<T>>) {
    let arm = Puma560::new(&PumaConfig::bare()).expect("the default");
    let ranges = PumaConfig::default().joints;
    // Knuth's generator of MMIX: any will do
    let mut state = 560u64;
    let mut share = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut poses = Vec::new();
    poses.resize_with(POSES, || {
        let joints = ranges.map(|j| T::of(j.min_rad + (j.max_rad - j.min_rad) * share()));
        (arm.forward(&joints), joints)
    });
    (arm, poses)
}

/// The same arm and poses for the peer.
fn peer() -> (OPWKinematics, Vec<(PeerPose, Joints<f64>)>) {
    let peer = OPWKinematics::new(Parameters {
        a1: 0.0,
        a2: 0.0203,
        b: -0.15005,
        c1: 0.67183,
        c2: 0.4318,
        c3: 0.4318,
        c4: 0.0,
        offsets: [0.0, -FRAC_PI_2, FRAC_PI_2, 0.0, 0.0, 0.0],
        sign_corrections: [1, -1, -1, 1, -1, 1],
        dof: 6,
    });
    let (_, poses) = arm::<f64>();
    let poses: Vec<_> = poses.iter().map(|(_, joints)| (peer.forward(joints), *joints)).collect();
    check(&peer, &poses);
    (peer, poses)
}

/// Both place the tool alike, and the peer finds as many solutions.
fn check(peer: &OPWKinematics, theirs: &[(PeerPose, Joints<f64>)]) {
    let (arm, ours) = arm::<f64>();
    for ((our, joints), (their, _)) in ours.iter().zip(theirs) {
        let q = their.rotation;
        let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z));
        let turned: Matrix3<f64> = Rotation3::from(turn).into_inner() - our.rotation;
        let moved = our.translation - nalgebra::Vector3::from(their.translation.to_array());
        assert!(turned.amax() < 1e-12 && moved.amax() < 1e-12, "{joints:?}");
        let found = arm.inverse(our, joints).map_or(0, |solutions| solutions.iter().count());
        assert_eq!(found, peer.inverse(their).len(), "{joints:?}");
    }
}

/// All eight solutions.
#[divan::bench(types = [f32, f64], sample_size = 1000)]
fn inverse<T: Real>(bencher: Bencher<'_, '_>) {
    let (arm, poses) = arm::<T>();
    let mut poses = poses.iter().cycle();
    bencher.bench_local(|| poses.next().map(|(pose, joints)| arm.inverse(black_box(pose), joints)));
}

/// The peer's.
#[divan::bench(sample_size = 1000)]
fn inverse_of_opw(bencher: Bencher<'_, '_>) {
    let (peer, poses) = peer();
    let mut poses = poses.iter().cycle();
    bencher.bench_local(|| poses.next().map(|(pose, _)| peer.inverse(black_box(pose))));
}

/// The peer's, beside given joints.
#[divan::bench(sample_size = 1000)]
fn inverse_continuing_of_opw(bencher: Bencher<'_, '_>) {
    let (peer, poses) = peer();
    let mut poses = poses.iter().cycle();
    bencher
        .bench_local(|| poses.next().map(|(pose, joints)| peer.inverse_continuing(black_box(pose), joints)));
}

/// The one solution to follow.
#[divan::bench(types = [f32, f64], sample_size = 1000)]
fn choose<T: Real>(bencher: Bencher<'_, '_>) {
    let (arm, poses) = arm::<T>();
    let poses: Vec<_> = poses.iter().map(|(pose, joints)| (pose, Recent::at_rest(&arm, joints))).collect();
    let mut poses = poses.iter().cycle();
    let policy = Policy::default();
    bencher.bench_local(|| poses.next().map(|(pose, recent)| arm.choose(black_box(pose), recent, &policy)));
}

/// Where the tool is.
#[divan::bench(types = [f32, f64])]
fn forward<T: Real>(bencher: Bencher<'_, '_>) {
    let (arm, poses) = arm::<T>();
    let mut poses = poses.iter().cycle();
    bencher.bench_local(|| poses.next().map(|(_, joints)| arm.forward(black_box(joints))));
}

/// How it moves.
#[divan::bench(types = [f32, f64])]
fn jacobian<T: Real>(bencher: Bencher<'_, '_>) {
    let (arm, poses) = arm::<T>();
    let mut poses = poses.iter().cycle();
    bencher.bench_local(|| poses.next().map(|(_, joints)| arm.jacobian(black_box(joints))));
}

/// A governor at rest at joints well inside their ranges.
fn governor<T: Real>(joints: &Joints<f64>) -> (Puma560<T>, Governor<T>) {
    let arm = Puma560::new(&PumaConfig::default()).expect("the default");
    let mut governor = Governor::new(&arm, &GovernorConfig::default()).expect("the default");
    governor.start(&joints.map(T::of)).expect("in range");
    (arm, governor)
}

/// Two places between which the arm goes to and fro.
const TO_AND_FRO: [Joints<f64>; 2] = [[0.3, 1.9, -2.6, 0.4, 0.9, -0.5], [0.6, 1.7, -2.3, 0.5, 0.7, -0.2]];

/// A cycle of the governor on straight ways to and fro.
#[divan::bench(types = [f32, f64], sample_size = 1000)]
fn governed<T: Real>(bencher: Bencher<'_, '_>) {
    let [here, there] = TO_AND_FRO;
    let (arm, mut governor) = governor::<T>(&here);
    let orders = [there, here].map(|joints| Order::Follow(arm.forward(&joints.map(T::of))));
    let mut cycle = 0usize;
    bencher.bench_local(|| {
        cycle += 1;
        governor.step(black_box(&orders[cycle / 50 % 2]), None)
    });
}

/// A cycle where the goal is out of the joints' ranges: every way is tried, least squares the last.
#[divan::bench(types = [f32, f64], sample_size = 1000)]
fn governed_out_of_range<T: Real>(bencher: Bencher<'_, '_>) {
    let [here, _] = TO_AND_FRO;
    let (arm, mut governor) = governor::<T>(&here);
    let mut beyond = here;
    beyond[4] = 2.3;
    let goal = arm.forward(&beyond.map(T::of));
    let home = arm.forward(&here.map(T::of));
    let mut cycle = 0usize;
    bencher.bench_local(|| {
        cycle += 1;
        // never at rest: the goal moves a little
        let mut goal = if cycle % 400 < 40 { home } else { goal };
        goal.translation.x += T::of((cycle % 100) as f64 * 1e-4);
        governor.step(black_box(&Order::Follow(goal)), None)
    });
}
