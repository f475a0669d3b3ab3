//! Errors of the signals of a log.

/// Result of this module.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Error of the signals of a log.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("signal {signal} has {found} usable values; at least {needed} are needed: check its path with `pivot-cal inspect`")]
    TooFew { signal: &'static str, found: usize, needed: usize },
    #[error("signal {signal} is marked `relative_to = \"gear\"`, but the log has no gear signal: name one, or remove the mark")]
    NoGear { signal: &'static str },
    #[error(
        "signal {signal} is a magnitude (`unsigned = true`), but the log has neither gear nor yaw rate to determine its sign: name one of them"
    )]
    NoSign { signal: &'static str },
    #[error(
        "the signals do not overlap in time: {signal} spans {from_s:.1} to {to_s:.1} s, speed {speed_from_s:.1} to {speed_to_s:.1} s; check the `stamp` of each"
    )]
    NoOverlap { signal: &'static str, from_s: f64, to_s: f64, speed_from_s: f64, speed_to_s: f64 },
    #[error(
        "{signal} contradicts {others} in {against_s:.0} s of {whole_s:.0} s of motion: its sign is reversed. Set `scale = -1` for {signal} in the signal map, or swap `forward` and `reverse` of the gear"
    )]
    Against { signal: &'static str, others: &'static str, against_s: f64, whole_s: f64 },
    #[error(
        "the torque and the motion have opposite signs: a higher torque accelerates the wheel in the negative direction; this explains {percent:.0} % of its acceleration. Set `scale = -1` for torque (and torque_feedback) in the signal map, or for speed and yaw_rate"
    )]
    TorqueAgainst { percent: f64 },
    #[error(
        "{signal} never changes: it reads {value} {unit} in all {values} values over {seconds:.0} s, although the torque changes between {low_nm:.1} and {high_nm:.1} N·m{evidence}. Look at the path of `{signal}` (`pivot-cal inspect LOG` shows it), at the sensor and at its cable{}",
        without(signal)
    )]
    Stuck { signal: &'static str, unit: &'static str, value: f64, values: usize, seconds: f64, low_nm: f64, high_nm: f64, evidence: String },
    #[error(
        "torque has two publishers: {found} interrupts the command {interruptions} times, and it is not clear which of the two the wheel follows. Record one publisher only, or name a topic that has one"
    )]
    TwoPublishers { interruptions: usize, found: String },
}

/// How to go on without a signal that is not required.
fn without(signal: &str) -> &'static str {
    if signal == "yaw_rate" { "; or leave `yaw_rate` out with a signal map that does not name it" } else { "" }
}
