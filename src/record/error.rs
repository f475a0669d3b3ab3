//! Errors of recording a campaign.

/// Result of this module.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Error of recording a campaign.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error(transparent)]
    Sim(#[from] crate::sim::Error),
    #[error("runs entry {group}: {field} is {value}; allowed: {allowed}")]
    OutOfRange { group: usize, field: &'static str, value: f64, allowed: &'static str },
    #[error("start_time is {found:?}; it must be a time such as \"2026-01-15T08:00:00Z\" after 1970: {message}")]
    StartTime { found: String, message: String },
    #[error("the campaign has no runs: add at least one [[runs]] entry with torque_nm")]
    NoRuns,
    #[error(
        "runs entry {group}: torque_nm from {start_nm} to {stop_nm} every {step_nm} gives no level; step must be above 0 and stop not below start"
    )]
    NoTorques { group: usize, start_nm: f64, step_nm: f64, stop_nm: f64 },
    #[error("runs entry {group}: wheel_angle_deg holds no angle")]
    NoAngles { group: usize },
    #[error("runs entry {group}: wheel_angle_deg is {wheel_angle_deg}; the vehicle steers up to {limit_deg}° in both directions")]
    BeyondSteering { group: usize, wheel_angle_deg: f64, limit_deg: f64 },
    #[error("slope_deg is {slope_deg}; allowed: above -45 and below 45")]
    Slope { slope_deg: f64 },
    #[error("the campaign is longer than {limit_s} s; split it into several campaigns")]
    TooLong { limit_s: f64 },
    #[error("topic {topic} was opened as {opened} and is written as {written}")]
    TopicType { topic: String, opened: &'static str, written: &'static str },
    #[error("the log cannot be written: {0}")]
    Mcap(#[from] mcap::McapError),
}
