//! What becomes of a sample.

use std::fmt;

/// The one verdict that every speed sample of a log gets: used, or the reason why not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Verdict {
    /// The fit uses it.
    Used,
    /// The first moments after a torque step, which no static map explains.
    Transient,
    /// At rest although torque is commanded: a bound on the breakaway torque.
    AtRest,
    /// At rest without torque.
    NoTorque,
    /// The wheel is not at the test angle.
    WheelNotAtAngle,
    /// The steering is moving.
    SteeringMoving,
    /// Emergency stop, until the vehicle rests again.
    EmergencyStop,
    /// The run that an emergency stop cut off.
    Aborted,
    /// Neutral, or rolling against the gear.
    WrongGear,
    /// Messages are missing around it.
    Gap,
    /// A spike that its neighbours do not share.
    Outlier,
    /// The wheel slips: encoder and yaw rate part ways.
    Slip,
    /// Something pushes or holds the vehicle: it does not move as its torque says.
    Push,
    /// Coming to rest: too slow to tell motion from rest.
    Stopping,
    /// A usable stretch too short to tell an acceleration.
    TooShort,
}

impl Verdict {
    /// Every verdict, in the order of the ledger.
    pub const ALL: [Self; 15] = [
        Self::Used,
        Self::Transient,
        Self::AtRest,
        Self::NoTorque,
        Self::WheelNotAtAngle,
        Self::SteeringMoving,
        Self::EmergencyStop,
        Self::Aborted,
        Self::WrongGear,
        Self::Gap,
        Self::Outlier,
        Self::Slip,
        Self::Push,
        Self::Stopping,
        Self::TooShort,
    ];
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Used => "used",
            Self::Transient => "transient after a step",
            Self::AtRest => "at rest below breakaway",
            Self::NoTorque => "at rest without torque",
            Self::WheelNotAtAngle => "wheel not at angle",
            Self::SteeringMoving => "steering moving",
            Self::EmergencyStop => "emergency stop",
            Self::Aborted => "run aborted by emergency stop",
            Self::WrongGear => "wrong gear",
            Self::Gap => "gap",
            Self::Outlier => "outlier",
            Self::Slip => "slip",
            Self::Push => "push",
            Self::Stopping => "coming to rest",
            Self::TooShort => "stretch too short",
        })
    }
}
