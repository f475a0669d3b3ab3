//! Reasons why logs give no compensation table.

/// Result of this module.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Reason why logs give no compensation table.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub(crate) enum Error {
    #[error("{log}: the heading is missing: name `yaw`, or `yaw_z` and `yaw_w` of its quaternion, in the signal map")]
    NoHeading { log: String },
    #[error("{log}: none of the {found} reference path(s) has two points or more")]
    NoPath { log: String, found: usize },
    #[error("{log}: pose and reference overlap in {found} place(s); {needed} are needed: do they use the same clock and the same frame?")]
    NoOverlap { log: String, found: usize, needed: usize },
    #[error(
        "{log}: the compensation changes from {low_deg:.3}° to {high_deg:.3}°; a run of the calibration has one angle from start to end"
    )]
    Changing { log: String, low_deg: f64, high_deg: f64 },
    #[error("none of the {found} log(s) is without compensation (angle 0); drive the task once without compensation, and add its log")]
    NoBase { found: usize },
    #[error("{first} and {second} are both without compensation; name one base")]
    TwoBases { first: String, second: String },
    #[error("{log}: {found_m:.1} m of the task remain; at least {needed_m:.1} m are needed")]
    TooShort { log: String, found_m: f64, needed_m: f64 },
    #[error("{log} drives {found_m:.1} m, the base {base}, {base_m:.1} m; logs of the same task differ by at most {allowed_pct} %")]
    OtherTask { log: String, found_m: f64, base: String, base_m: f64, allowed_pct: f64 },
    #[error(
        "{left} of {all} entries are left; at least one angle besides the base is needed: drive smaller angles, or raise the threshold of {threshold_m} m"
    )]
    NothingLeft { left: usize, all: usize, threshold_m: f64 },
    #[error("the errors of the angles do not differ: the compensation does not reach the steering, or the angles are too small")]
    NoEffect,
    #[error("{found} angles; at most {most} fit into the table of the run-time law")]
    TooMany { found: usize, most: usize },
    #[error("{field} is {value}; allowed: {allowed}")]
    Setting { field: &'static str, value: f64, allowed: &'static str },
    #[error(transparent)]
    Map(#[from] crate::map::Error),
}
