//! `/api/arm`: the links of the arm, for the page that draws it.

use axum::Json;
use axum::http::StatusCode;
use serde::Serialize;
use tetrad_core::arm::puma560::Puma560;
use tetrad_core::config::{JOINTS, PumaConfig};

/// The arm's table.
#[derive(Serialize)]
pub(super) struct Arm {
    /// From base to wrist; the tool is where the slave says.
    links: [Link; JOINTS],
}

/// One row of the standard Denavit-Hartenberg table: `Rz(q) Tz(d) Tx(a) Rx(alpha)`.
#[derive(Serialize)]
struct Link {
    /// Along the joint's axis, metres.
    d_m: f64,
    /// Across it, metres.
    a_m: f64,
    /// From this axis to the next, radians.
    alpha_rad: f64,
}

/// A PUMA 560 as it is made. A slave may have set its lengths otherwise; its tool is told by itself.
pub(super) async fn arm() -> Result<Json<Arm>, StatusCode> {
    // the default is sound; were it not, there is nothing to draw
    let arm = Puma560::<f64>::new(&PumaConfig::default()).map_err(|_| StatusCode::INTERNAL_SERVER_ERROR)?;
    let links = arm.links().map(|row| Link { d_m: row.d_m, a_m: row.a_m, alpha_rad: row.alpha_rad });
    Ok(Json(Arm { links }))
}
