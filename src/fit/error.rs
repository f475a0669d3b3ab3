//! Why there is no fit.

/// Result of this room.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why there is no fit.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("no log to fit")]
    NoLogs,
    #[error(
        "the logs are of different vehicles: {first} has {field} {first_value}, {second} has {second_value}. Fit each vehicle separately, or give one {field} for all logs"
    )]
    DifferentVehicles { field: &'static str, first: String, first_value: f64, second: String, second_value: f64 },
    #[error(
        "too little data: {seconds:.1} s of usable motion, at least {needed_s:.0} s are needed. Drive more torque steps from rest, each held for 3 s"
    )]
    TooLittle { seconds: f64, needed_s: f64 },
    #[error(
        "all usable motion is at one torque ({torque_nm:.1} N·m): the effect of torque on acceleration cannot be estimated. Add runs at other torques, about {suggestion_nm:.0} N·m and {suggestion2_nm:.0} N·m"
    )]
    OneTorque { torque_nm: f64, suggestion_nm: f64, suggestion2_nm: f64 },
    #[error(
        "{file}: the speed signal is too slow: it changes {rate_hz:.1} times a second, {needed_hz:.0} are needed where no yaw rate is mapped. Log the wheel speed faster, or map a yaw rate"
    )]
    SlowSpeed { file: String, rate_hz: f64, needed_hz: f64 },
    #[error(
        "no map of the test angle of {test_angle_deg}° can be made: the angles with runs are {found}. Choose one of these as the test angle"
    )]
    NoTestAngle { test_angle_deg: f64, found: String },
    #[error("the surface cannot be estimated: the logs hold no information on it. Drive torque steps from rest at several torques")]
    Singular,
    #[error("Table 1 holds no driven run with motion and a torque range: nothing to plan from. Drive a first campaign and fit it")]
    NothingToPlan,
    #[error(
        "there is no cell to plan for: a speed above 0 and two torques, one of them positive, are needed; the torques within the vehicle's limit are {low_nm} to {high_nm} N·m. Give other speeds or torques"
    )]
    NoCells { low_nm: f64, high_nm: f64 },
    #[error("no run fits a plan of {budget_s:.0} s: give it more time")]
    NoPlan { budget_s: f64 },
    #[error(transparent)]
    Map(#[from] crate::map::Error),
}
