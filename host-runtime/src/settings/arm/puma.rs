//! `[arm]`: lengths, ranges, speeds and the tool.

use super::super::file::Problem;
use super::{mm, problem, set, turned};
use nalgebra::Vector3;
use serde::Deserialize;
use tetrad_core::config::{JOINTS, PumaConfig, PumaConfigError};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::settings) struct ArmToml {
    base_mm: Option<f64>,
    upper_arm_mm: Option<f64>,
    offset_mm: Option<f64>,
    elbow_mm: Option<f64>,
    forearm_mm: Option<f64>,
    min_deg: Option<[f64; JOINTS]>,
    max_deg: Option<[f64; JOINTS]>,
    max_speed_deg_s: Option<[f64; JOINTS]>,
    tool_mm: Option<[f64; 3]>,
    tool_rpy_deg: Option<[f64; 3]>,
}

impl ArmToml {
    /// The arm.
    ///
    /// # Errors
    /// The keys of what cannot be worked with, and why.
    pub(super) fn config(&self) -> Result<PumaConfig, Problem> {
        let mut puma = PumaConfig::default();
        let lengths = &mut puma.lengths;
        set(&mut lengths.base_m, self.base_mm, mm);
        set(&mut lengths.upper_arm_m, self.upper_arm_mm, mm);
        set(&mut lengths.offset_m, self.offset_mm, mm);
        set(&mut lengths.elbow_m, self.elbow_mm, mm);
        set(&mut lengths.forearm_m, self.forearm_mm, mm);
        for (place, joint) in puma.joints.iter_mut().enumerate() {
            set(&mut joint.min_rad, self.min_deg.map(|all| all[place]), f64::to_radians);
            set(&mut joint.max_rad, self.max_deg.map(|all| all[place]), f64::to_radians);
            set(&mut joint.max_speed_rad_s, self.max_speed_deg_s.map(|all| all[place]), f64::to_radians);
        }
        if let Some(place) = self.tool_mm {
            puma.tool.translation = Vector3::from(place.map(mm));
        }
        if let Some(angles) = self.tool_rpy_deg {
            puma.tool.rotation = turned(angles, "arm", "tool_rpy_deg")?;
        }
        puma.check().map_err(|error| {
            let keys = match error {
                PumaConfigError::Length => "base_mm, upper_arm_mm, offset_mm, elbow_mm, forearm_mm",
                PumaConfigError::Range(_) => "min_deg, max_deg",
                PumaConfigError::Speed(_) => "max_speed_deg_s",
                PumaConfigError::Tool => "tool_mm, tool_rpy_deg",
            };
            problem("arm", keys, &error)
        })?;
        Ok(puma)
    }
}
