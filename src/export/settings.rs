//! Settings of an export.

use crate::export::Precision;
use crate::export::user_unit::UserUnits;

/// Settings of an export.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExportSettings {
    /// Floating-point type of C and Rust. Default double.
    pub precision: Precision,
    /// Whether C and Rust store whole counts of 16 bits; the map must have been inverted with raw units. Default no.
    pub int16: bool,
    /// Units of the tables. Default SI.
    pub units: UserUnits,
    /// Torque that is 100 % of a pedal in Autoware and Apollo [N·m]. Default the vehicle's limit, or the largest torque of the map.
    pub full_scale_nm: Option<f64>,
    /// Whether FMUs hold their C sources alone, without a binary for this machine. Default no.
    pub without_binary: bool,
}
