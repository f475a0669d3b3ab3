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
    #[error("{found} breaks per axis cannot be placed; allowed: 3 to 200")]
    BadPlace { found: usize },
    #[error(
        "Table 1 ({gear}) goes from {low_mps2:.0} to {high_mps2:.0} m/s², which no vehicle does; at most {most_mps2:.0} m/s² are allowed. Look at the units of torque and speed, and fit it again"
    )]
    NotPhysical { gear: Gear, low_mps2: f64, high_mps2: f64, most_mps2: f64 },
    #[error(transparent)]
    Map(#[from] crate::map::Error),
}
