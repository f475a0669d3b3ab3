//! Errors of the simulator's settings.

/// Result of this module.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Error of the simulator's settings.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("{field} is {value}; allowed: {allowed}")]
    OutOfRange { field: &'static str, value: f64, allowed: &'static str },
    #[error("{field} needs {needed} kept readings at its rate and latency; at most {most} are kept: lower the latency or the rate")]
    LatencyTooLong { field: &'static str, needed: usize, most: usize },
    #[error(transparent)]
    Map(#[from] crate::map::Error),
    #[error("the file has no Table 1 for forward gear at {wheel_angle_deg}° to make a plant from")]
    NoForwardMap { wheel_angle_deg: f64 },
    #[error("the surface never accelerates at standstill: no torque up to {largest_nm} N·m sets the wheel in motion")]
    NeverMoves { largest_nm: f64 },
    #[error("line {line}: {message}{}", nearest.as_ref().map(|n| format!("; did you mean `{n}`?")).unwrap_or_default())]
    Toml { line: usize, message: String, nearest: Option<String> },
    #[error("the recorded run has {t_s} times, {torque_nm} torques and {speed_mps} speeds; the numbers must be equal and at least 2")]
    UnequalRun { t_s: usize, torque_nm: usize, speed_mps: usize },
}

/// Checks that `value` is within `range`, both ends included; NaN is not.
pub(crate) fn within(field: &'static str, value: f64, range: std::ops::RangeInclusive<f64>, allowed: &'static str) -> Result<()> {
    if range.contains(&value) { Ok(()) } else { Err(Error::OutOfRange { field, value, allowed }) }
}
