//! Why a table cannot be inverted.

use crate::map::Gear;

/// Result of this room.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why a table cannot be inverted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("the file holds no table to invert")]
    NoTables,
    #[error(
        "Table 1 ({gear}) does not rise with torque at {speed_mps:.3} m/s: {low_mps2:.4} m/s² at {low_nm:.3} N·m, {high_mps2:.4} m/s² at {high_nm:.3} N·m; it has no inverse there. Fit it again"
    )]
    NotMonotone { gear: Gear, speed_mps: f64, low_nm: f64, low_mps2: f64, high_nm: f64, high_mps2: f64 },
    #[error("the least-squares programme of Table 2 ({gear}) did not finish; exact nodes need no such programme")]
    NotSolved { gear: Gear },
    #[error("{found} breaks on an axis cannot be placed; allowed: 3 to 200")]
    BadPlace { found: usize },
    #[error("the raw unit of the {axis} has the scale {scale} and the offset {offset}; allowed: a scale above 0, and numbers")]
    RawUnit { axis: &'static str, scale: f64, offset: f64 },
    #[error(
        "the {axis} {value} of the {gear} map does not fit into 16 bits with the scale {scale} and the offset {offset}, which hold {low} to {high}; take a larger scale"
    )]
    RawRange { axis: &'static str, gear: Gear, value: f64, scale: f64, offset: f64, low: f64, high: f64 },
    #[error(
        "the raw unit of {scale} is too coarse for the {axis} axis of the {gear} map: its {breaks} breaks fall on {counts} counts; take a smaller scale or fewer breaks"
    )]
    RawTooCoarse { axis: &'static str, gear: Gear, scale: f64, breaks: usize, counts: usize },
    #[error(
        "Table 1 ({gear}) goes from {low_mps2:.0} to {high_mps2:.0} m/s², which no vehicle does; at most {most_mps2:.0} m/s² are allowed. Look at the units of torque and speed, and fit it again"
    )]
    NotPhysical { gear: Gear, low_mps2: f64, high_mps2: f64, most_mps2: f64 },
    #[error(transparent)]
    Map(#[from] crate::map::Error),
}
