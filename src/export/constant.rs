//! A number with its name and unit, as calibration data holds it.

/// A number that belongs to the map.
pub(crate) struct Constant {
    pub(crate) name: String,
    pub(crate) what: String,
    pub(crate) unit: &'static str,
    pub(crate) value: f64,
}
