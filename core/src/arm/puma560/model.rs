//! The arm as it is computed with: the configuration in the precision of choice, and what is derived
//! from it once.

use crate::config::{JOINTS, PumaConfig, PumaConfigError};
use crate::geometry::Pose;
use crate::real::Real;

/// One angle a joint, from base to wrist, radians.
pub type Joints<T> = [T; JOINTS];

/// One row of the standard Denavit-Hartenberg table: the link's transform is
/// `Rz(q) Tz(d) Tx(a) Rx(alpha)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkRow<T> {
    /// Along the joint's axis, metres.
    pub d_m: T,
    /// Across it, metres.
    pub a_m: T,
    /// From this axis to the next, radians.
    pub alpha_rad: T,
}

/// What one joint can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range<T> {
    pub(super) min: T,
    pub(super) max: T,
}

/// A PUMA 560 in single (f32) or double precision (f64).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Puma560<T> {
    config: PumaConfig,
    pub(super) geometry: Geometry<T>,
    /// The same to all digits, for poses told in another precision than the joints.
    pub(super) exact: Geometry<f64>,
    pub(super) ranges: [Range<T>; JOINTS],
}

/// What of an arm places its tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Geometry<T> {
    /// d1, a2, d3, a3, d4 of the link table.
    pub(super) base: T,
    pub(super) upper_arm: T,
    pub(super) offset: T,
    pub(super) elbow: T,
    pub(super) forearm: T,
    /// From the elbow straight to the wrist centre: the hypotenuse of a3 and d4.
    pub(super) lower_arm: T,
    /// The angle between both: atan2(d4, a3).
    pub(super) bend: T,
    /// `wrist_from_tool` and `tool_from_wrist`.
    pub(super) tool: Pose<T>,
    pub(super) wrist_in_tool: Pose<T>,
}

impl Geometry<f64> {
    fn new(config: &PumaConfig) -> Self {
        let lengths = &config.lengths;
        Self {
            base: lengths.base_m,
            upper_arm: lengths.upper_arm_m,
            offset: lengths.offset_m,
            elbow: lengths.elbow_m,
            forearm: lengths.forearm_m,
            lower_arm: libm::sqrt(lengths.elbow_m * lengths.elbow_m + lengths.forearm_m * lengths.forearm_m),
            bend: libm::atan2(lengths.forearm_m, lengths.elbow_m),
            tool: config.tool,
            wrist_in_tool: config.tool.inverse(),
        }
    }

    /// In another precision.
    #[inline]
    pub(super) fn rounded<P: Real>(&self) -> Geometry<P> {
        let pose = |pose: &Pose<f64>| Pose {
            rotation: pose.rotation.map(P::of),
            translation: pose.translation.map(P::of),
        };
        Geometry {
            base: P::of(self.base),
            upper_arm: P::of(self.upper_arm),
            offset: P::of(self.offset),
            elbow: P::of(self.elbow),
            forearm: P::of(self.forearm),
            lower_arm: P::of(self.lower_arm),
            bend: P::of(self.bend),
            tool: pose(&self.tool),
            wrist_in_tool: pose(&self.wrist_in_tool),
        }
    }
}

impl<T: Real> Geometry<T> {
    /// From the shoulder to the wrist centre of the stretched arm, metres.
    pub(super) fn reach(&self) -> T {
        self.upper_arm + self.lower_arm
    }

    /// The same of the folded arm, metres.
    pub(super) fn inner_reach(&self) -> T {
        (self.upper_arm - self.lower_arm).abs()
    }
}

impl<T: Real> Puma560<T> {
    /// An arm.
    ///
    /// # Errors
    /// [`PumaConfigError`] for a setting that cannot be worked with.
    pub fn new(config: &PumaConfig) -> Result<Self, PumaConfigError> {
        config.check()?;
        let exact = Geometry::new(config);
        Ok(Self {
            config: *config,
            geometry: exact.rounded(),
            exact,
            ranges: config.joints.map(|joint| Range { min: T::of(joint.min_rad), max: T::of(joint.max_rad) }),
        })
    }

    /// The configuration it was made from.
    #[must_use]
    pub const fn config(&self) -> &PumaConfig {
        &self.config
    }

    /// The link table, from base to wrist. The tool comes on top.
    #[must_use]
    pub fn links(&self) -> [LinkRow<T>; JOINTS] {
        let of = &self.geometry;
        let right = T::frac_pi_2();
        let zero = T::zero();
        let row = |d_m, a_m, alpha_rad| LinkRow { d_m, a_m, alpha_rad };
        [
            row(of.base, zero, right),
            row(zero, of.upper_arm, zero),
            row(of.offset, of.elbow, -right),
            row(of.forearm, zero, right),
            row(zero, zero, -right),
            row(zero, zero, zero),
        ]
    }

    /// From the shoulder to the wrist centre of the stretched arm, metres.
    #[must_use]
    pub fn reach(&self) -> T {
        self.geometry.reach()
    }

    /// The same of the folded arm, metres: 0.5 mm.
    #[must_use]
    pub fn inner_reach(&self) -> T {
        self.geometry.inner_reach()
    }
}
