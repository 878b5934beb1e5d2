//! `[governor]`: how far, how fast and how abruptly the joints may go.

use super::super::file::Problem;
use super::{mm, set, workspace_problem};
use serde::Deserialize;
use tetrad_core::arm::governor::Governor;
use tetrad_core::arm::puma560::Puma560;
use tetrad_core::config::{GovernorConfig, GovernorConfigError, JOINTS, PumaConfig, Workspace};

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::settings) struct GovernorToml {
    cycle_ms: Option<f64>,
    speed_share: Option<f64>,
    max_acceleration_deg_s2: Option<[f64; JOINTS]>,
    max_jerk_deg_s3: Option<[f64; JOINTS]>,
    max_tool_speed_mm_s: Option<f64>,
    response_per_s: Option<f64>,
    limit_margin_deg: Option<f64>,
    max_outside_deg: Option<f64>,
    singularity_margin: Option<f64>,
    creep_share: Option<f64>,
    pass_wrist: Option<bool>,
    pass_elbow: Option<bool>,
    pass_shoulder: Option<bool>,
    full_speed_to_mm: Option<f64>,
    creep_from_mm: Option<f64>,
    full_speed_to_deg: Option<f64>,
    creep_from_deg: Option<f64>,
    home_deg: Option<[f64; JOINTS]>,
    home_speed_share: Option<f64>,
}

impl GovernorToml {
    /// The governor of this arm in this workspace.
    ///
    /// # Errors
    /// The keys of what cannot be worked with, and why.
    pub(super) fn config(&self, workspace: &Workspace, puma: &PumaConfig) -> Result<GovernorConfig, Problem> {
        let mut governor = GovernorConfig { workspace: *workspace, ..GovernorConfig::default() };
        if let Some(ms) = self.cycle_ms {
            // what does not fit ends as 0 or the largest, and is refused for that
            governor.cycle_us = (ms * 1000.0).round() as u32;
        }
        set(&mut governor.speed_share, self.speed_share, f64::from);
        for place in 0..JOINTS {
            let acceleration = self.max_acceleration_deg_s2.map(|all| all[place]);
            set(&mut governor.max_acceleration_rad_s2[place], acceleration, f64::to_radians);
            let jerk = self.max_jerk_deg_s3.map(|all| all[place]);
            set(&mut governor.max_jerk_rad_s3[place], jerk, f64::to_radians);
        }
        set(&mut governor.max_tool_speed_m_s, self.max_tool_speed_mm_s, mm);
        set(&mut governor.response_per_s, self.response_per_s, f64::from);
        set(&mut governor.limit_margin_rad, self.limit_margin_deg, f64::to_radians);
        set(&mut governor.max_outside_rad, self.max_outside_deg, f64::to_radians);
        set(&mut governor.singularity_margin, self.singularity_margin, f64::from);
        set(&mut governor.creep_share, self.creep_share, f64::from);
        let passages = &mut governor.passages;
        for (may, said) in [
            (&mut passages.wrist, self.pass_wrist),
            (&mut passages.elbow, self.pass_elbow),
            (&mut passages.shoulder, self.pass_shoulder),
        ] {
            *may = said.unwrap_or(*may);
        }
        let uncertainty = &mut governor.uncertainty;
        set(&mut uncertainty.full_m, self.full_speed_to_mm, mm);
        set(&mut uncertainty.creep_m, self.creep_from_mm, mm);
        set(&mut uncertainty.full_rad, self.full_speed_to_deg, f64::to_radians);
        set(&mut uncertainty.creep_rad, self.creep_from_deg, f64::to_radians);
        governor.home_rad = self.home_deg.map(|joints| joints.map(f64::to_radians));
        set(&mut governor.home_speed_share, self.home_speed_share, f64::from);
        let checked = governor.check(&puma.joints.map(|joint| joint.max_speed_rad_s));
        // where the tool is at home only the arm itself knows; what is wrong with it is told by its own check
        let at_home =
            |()| Puma560::<f64>::new(puma).map_or(Ok(()), |arm| Governor::new(&arm, &governor).map(|_| ()));
        match checked.and_then(at_home) {
            Ok(()) => Ok(governor),
            Err(GovernorConfigError::Workspace) => Err(workspace_problem()),
            Err(error) => {
                let (keys, problem) = explained(error);
                Err((format!("[governor] {keys}"), problem))
            }
        }
    }
}

/// The keys that are meant, and what would be right, in the units of this file.
fn explained(error: GovernorConfigError) -> (&'static str, String) {
    use GovernorConfigError as E;
    let (keys, problem) = match error {
        E::Acceleration(joint) => {
            let problem = format!("joint {joint}: above 0 and at most 572957 is needed");
            return ("max_acceleration_deg_s2", problem);
        }
        E::Jerk(joint) => {
            return ("max_jerk_deg_s3", format!("joint {joint}: above 0 and at most 57295779 is needed"));
        }
        E::SlowToStop(joint) => {
            let problem = format!("joint {joint} would take over 2 s to stop: raise one of them");
            return ("max_acceleration_deg_s2, max_jerk_deg_s3", problem);
        }
        E::Home(joint) => return ("home_deg", format!("joint {joint}: an angle within its range is needed")),
        E::HomeOutside => {
            ("home_deg", "there the tool must be in the workspace; [workspace] has its corners")
        }
        E::HomeSpeedShare => ("home_speed_share", "0.05 to 1 is needed"),
        E::SpeedShare => ("speed_share", "above 0 and at most 1 is needed"),
        E::ToolSpeed => ("max_tool_speed_mm_s", "above 0 and at most 10000 is needed"),
        E::Response => ("response_per_s", "0.1 to 100 is needed"),
        E::LimitMargin => ("limit_margin_deg", "0 to 57.29 is needed"),
        E::MaxOutside => ("max_outside_deg", "0 to 57.29 is needed"),
        E::SingularityMargin => ("singularity_margin", "0 to 0.9 is needed"),
        E::CreepShare => ("creep_share", "above 0 and at most 1 is needed"),
        E::Uncertainty => (
            "full_speed_to_mm, creep_from_mm, full_speed_to_deg, creep_from_deg",
            "each creep must be above its full, from 0 to 10000 mm and to 572 degrees",
        ),
        E::Cycle => ("cycle_ms", "1 to 100 is needed"),
        // the workspace has a table of its own
        E::Workspace => return ("", error.to_string()),
    };
    (keys, problem.to_owned())
}
