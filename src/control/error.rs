//! Why a pivot cannot even be requested, or settings cannot be used.

/// Result of this room.
pub type Result<T> = core::result::Result<T, Error>;

/// Why a pivot cannot be requested, or settings cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the fields are what the message says
pub enum Error {
    #[error("a turn of {found_deg}° cannot be planned; allowed: from {smallest_deg:.2}° to 360° either way")]
    Turn { found_deg: f64, smallest_deg: f64 },
    #[error("the pose is not a number: x {x_m} m, y {y_m} m, heading {heading_rad} rad")]
    Pose { x_m: f64, y_m: f64, heading_rad: f64 },
    #[error("the arc of {arc_m:.2} m needs {needed} waypoints; {allowed} are allowed: widen the spacing")]
    TooManyWaypoints { arc_m: f64, needed: usize, allowed: usize },
    #[error("a pivot is in progress; wait for its end")]
    Busy,
    #[error("there is no torque table for {gear} gear")]
    NoTable { gear: crate::map::Gear },
    #[error("{field} is {value}; allowed: {allowed}")]
    Setting { field: &'static str, value: f64, allowed: &'static str },
}
