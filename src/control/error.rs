//! Why a pivot cannot be requested, or settings cannot be used.

use crate::Gear;
use core::fmt;

/// Result of this module.
pub(crate) type Result<T> = core::result::Result<T, Error>;

/// Why a pivot cannot be requested, or settings cannot be used.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    Turn { found_deg: f64, smallest_deg: f64 },
    Pose { x_m: f64, y_m: f64, heading_rad: f64 },
    TooManyWaypoints { arc_m: f64, needed: usize, allowed: usize },
    Busy,
    NoTable { gear: Gear },
    Setting { field: &'static str, value: f64, allowed: &'static str },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Turn { found_deg, smallest_deg } => {
                write!(f, "a turn of {found_deg}° cannot be planned; allowed: from {smallest_deg:.2}° to 360° either way")
            }
            Self::Pose { x_m, y_m, heading_rad } => {
                write!(f, "the pose is not a number: x {x_m} m, y {y_m} m, heading {heading_rad} rad")
            }
            Self::TooManyWaypoints { arc_m, needed, allowed } => {
                write!(f, "the arc of {arc_m:.2} m needs {needed} waypoints; {allowed} are allowed: widen the spacing")
            }
            Self::Busy => f.write_str("a pivot is in progress; wait for its end"),
            Self::NoTable { gear } => write!(f, "there is no torque table for {gear} gear"),
            Self::Setting { field, value, allowed } => write!(f, "{field} is {value}; allowed: {allowed}"),
        }
    }
}

impl core::error::Error for Error {}
