//! Errors of logs without usable data for a calibration.

/// Result of this module.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// A gate removes all samples: each message gives its threshold, the values found, and values that would pass.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error(
        "no run at the test angle: the wheel was never within {tolerance_deg}° of {wanted_deg}°; while the vehicle moved it was between {low_deg:.1}° and {high_deg:.1}° (median {median_deg:.1}°). If the runs were driven there, give --test-angle-deg {median_deg:.0}; if the sensor has an offset, give `offset` in the signal map"
    )]
    NothingAtAngle { tolerance_deg: f64, wanted_deg: f64, low_deg: f64, high_deg: f64, median_deg: f64 },
    #[error(
        "no torque step: the torque command stays between {low_nm:.2} and {high_nm:.2} N·m. A campaign holds torque at fixed steps; check the path of `torque`"
    )]
    NoTorqueStep { low_nm: f64, high_nm: f64 },
    #[error(
        "the vehicle never moves at the test angle: the largest speed there is {largest_mps:.3} m/s. Either every torque step (up to {torque_nm:.1} N·m) is below breakaway, or `speed` names the wrong signal"
    )]
    NoMotion { largest_mps: f64, torque_nm: f64 },
    #[error("every moving sample at the test angle is left out: {reasons}")]
    NothingLeft { reasons: String },
}
