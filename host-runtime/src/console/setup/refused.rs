//! Why something was not set up, in words for the page.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde_json::json;
use tetrad_core::observation::Ball;

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum Refused {
    #[error("the cameras are being opened: wait a moment")]
    TooEarly,
    #[error("this is not understood: {0}")]
    Unreadable(String),
    #[error("there is no camera {0}: they are counted from 0, and there are {1}")]
    NoCamera(usize, usize),
    #[error("{0}: {1}")]
    Elsewhere(String, &'static str),
    #[error("no camera of the hand is at this computer: teach each at its own station, with `tetrad learn`")]
    NoneHere,
    #[error("{0} is in control: only that page may set up; it can give control up")]
    AnotherDrives(String),
    #[error("the arm follows the hand: let go of the button first, then set up")]
    Engaged,
    #[error("other work of the set-up is going on: try again in a moment")]
    Busy,
    #[error("{0} gives no picture at the moment: see that it is plugged in and nothing else uses it")]
    NoPicture(String),
    #[error("{0}: there is no still picture yet: take one first")]
    NoStill(String),
    #[error("({0}, {1}) is outside the picture of {2}x{3} pixels")]
    Outside(f32, f32, u16, u16),
    #[error("{0}: nothing is known of the {ball} ball: find the balls, or point at it", ball = .1.name())]
    Unknown(String, Ball),
    /// In words of whoever found it: a file, a ball.
    #[error("{0}")]
    Wrong(String),
    #[error("{0}")]
    Failed(String),
}

impl Refused {
    const fn status(&self) -> StatusCode {
        match self {
            Self::Unreadable(_) => StatusCode::BAD_REQUEST,
            Self::NoCamera(..) => StatusCode::NOT_FOUND,
            Self::AnotherDrives(_) | Self::Engaged | Self::NoStill(_) | Self::Unknown(..) => {
                StatusCode::CONFLICT
            }
            Self::Elsewhere(..) | Self::NoneHere | Self::Outside(..) | Self::Wrong(_) => {
                StatusCode::UNPROCESSABLE_ENTITY
            }
            Self::TooEarly | Self::Busy | Self::NoPicture(_) => StatusCode::SERVICE_UNAVAILABLE,
            Self::Failed(_) => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        (self.status(), Json(json!({ "why": self.to_string() }))).into_response()
    }
}
