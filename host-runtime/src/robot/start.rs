//! Where an arm that is not there stands at first.

use tetrad_core::arm::puma560::Joints;
use tetrad_core::config::PumaConfig;

/// Degrees: elbow and wrist bent, the tool in front of the arm and pointing down, far from every
/// singularity; the "nominal" pose of the Robotics Toolbox.
const START_DEG: Joints<f64> = [0.0, 45.0, -180.0, 0.0, 45.0, 0.0];

/// That place, or the nearest to it in the joints' ranges.
pub(super) fn start_joints(puma: &PumaConfig) -> Joints<f64> {
    let mut joints = START_DEG.map(f64::to_radians);
    for (angle, joint) in joints.iter_mut().zip(&puma.joints) {
        *angle = angle.max(joint.min_rad).min(joint.max_rad);
    }
    joints
}

/// The first joint whose range excludes that place: its number and its angle there, degrees.
pub(crate) fn excluded(puma: &PumaConfig) -> Option<(usize, f64)> {
    let nearest = start_joints(puma).map(f64::to_degrees);
    let mut joints = (1..).zip(START_DEG.iter().zip(&nearest));
    // degrees there and back are not to the bit
    joints
        .find(|(_, (place, nearest))| (*place - *nearest).abs() > 1e-9)
        .map(|(number, (place, _))| (number, *place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::arm::puma560::Puma560;

    #[test]
    fn it_is_in_range_and_far_from_singularities() {
        let puma = PumaConfig::default();
        let joints = start_joints(&puma);
        assert_eq!(joints, START_DEG.map(f64::to_radians));
        let arm = Puma560::<f64>::new(&puma).unwrap();
        let (nearest, share) = arm.nearest_singularity(&arm.singularities(&joints));
        assert!(share > 0.5, "{nearest:?} {share}");
    }

    #[test]
    fn a_narrower_range_moves_it() {
        let mut puma = PumaConfig::default();
        puma.joints[1].max_rad = 0.5;
        assert_eq!(start_joints(&puma)[1], 0.5);
    }
}
