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
    pub(super) ranges: [Range<T>; JOINTS],
    /// `wrist_from_tool` and `tool_from_wrist`.
    pub(super) tool: Pose<T>,
    pub(super) wrist_in_tool: Pose<T>,
}

impl<T: Real> Puma560<T> {
    /// An arm.
    ///
    /// # Errors
    /// [`PumaConfigError`] for a setting that cannot be worked with.
    pub fn new(config: &PumaConfig) -> Result<Self, PumaConfigError> {
        config.check()?;
        let lengths = &config.lengths;
        let tool = Pose {
            rotation: config.tool.rotation.map(T::of),
            translation: config.tool.translation.map(T::of),
        };
        Ok(Self {
            config: *config,
            base: T::of(lengths.base_m),
            upper_arm: T::of(lengths.upper_arm_m),
            offset: T::of(lengths.offset_m),
            elbow: T::of(lengths.elbow_m),
            forearm: T::of(lengths.forearm_m),
            lower_arm: T::of(libm::sqrt(
                lengths.elbow_m * lengths.elbow_m + lengths.forearm_m * lengths.forearm_m,
            )),
            bend: T::of(libm::atan2(lengths.forearm_m, lengths.elbow_m)),
            ranges: config.joints.map(|joint| Range { min: T::of(joint.min_rad), max: T::of(joint.max_rad) }),
            tool,
            wrist_in_tool: tool.inverse(),
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
        let right = T::frac_pi_2();
        let zero = T::zero();
        let row = |d_m, a_m, alpha_rad| LinkRow { d_m, a_m, alpha_rad };
        [
            row(self.base, zero, right),
            row(zero, self.upper_arm, zero),
            row(self.offset, self.elbow, -right),
            row(self.forearm, zero, right),
            row(zero, zero, -right),
            row(zero, zero, zero),
        ]
    }

    /// From the shoulder to the wrist centre of the stretched arm, metres.
    #[must_use]
    pub fn reach(&self) -> T {
        self.upper_arm + self.lower_arm
    }

    /// The same of the folded arm, metres: 0.5 mm.
    #[must_use]
    pub fn inner_reach(&self) -> T {
        (self.upper_arm - self.lower_arm).abs()
    }
}
