//! Statuses in the files, as words: of a delay, of the fit's input, of a sample, of the row at speed 0.

use crate::map::files::named::FixedText;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Status of a delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DelayStatus {
    /// Estimated from the logs.
    Estimated,
    /// Estimated, with a standard error above 10 ms.
    WeaklyDetermined,
    /// Given by the user, not estimated.
    Given,
    /// Nothing in the log separates it from the dead time.
    NotSeparable,
    /// Looked for, but too small to be real.
    NoneFound,
}

impl FixedText for DelayStatus {
    const FIELD: &'static str = "status";
    const NAMES: &'static [(Self, &'static str)] = &[
        (Self::Estimated, "estimated"),
        (Self::WeaklyDetermined, "weakly determined"),
        (Self::Given, "given"),
        (Self::NotSeparable, "not separable"),
        (Self::NoneFound, "none found"),
    ];
}

impl fmt::Display for DelayStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The torque that the fit used as the drive's input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InputSource {
    /// The command, through dead time and lag.
    TorqueCommand,
    /// The drive's own feedback.
    TorqueFeedback,
}

impl FixedText for InputSource {
    const FIELD: &'static str = "input";
    const NAMES: &'static [(Self, &'static str)] = &[(Self::TorqueCommand, "torque command"), (Self::TorqueFeedback, "torque feedback")];
}

/// The input of the fit, with the reason unless the command is the obvious choice. In JSON one text: `torque command`, or `torque feedback
/// (the reason)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ActuatorInput {
    /// The input torque.
    pub source: InputSource,
    /// The reason.
    pub reason: Option<String>,
}

impl ActuatorInput {
    /// The torque command, for which no reason is needed.
    pub const COMMAND: Self = Self { source: InputSource::TorqueCommand, reason: None };

    /// Whether it is the torque command without a reason.
    pub fn is_plain_command(&self) -> bool {
        *self == Self::COMMAND
    }

    /// Reads the text.
    ///
    /// # Errors
    /// A text that begins with neither input, or whose reason is not in parentheses.
    pub fn from_text(text: &str) -> Result<Self, String> {
        match text.split_once(" (").and_then(|(source, rest)| Some((source, rest.strip_suffix(')')?))) {
            Some((source, reason)) => Ok(Self { source: InputSource::from_name(source)?, reason: Some(reason.to_owned()) }),
            None => Ok(Self { source: InputSource::from_name(text)?, reason: None }),
        }
    }
}

impl fmt::Display for ActuatorInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.source.name())?;
        self.reason.as_ref().map_or(Ok(()), |reason| write!(f, " ({reason})"))
    }
}

impl Serialize for ActuatorInput {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for ActuatorInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::from_text(&String::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}

/// A source of the front wheel's speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SpeedSource {
    /// The encoder of the driven wheel.
    Encoder,
    /// The yaw rate, turned into the wheel's speed by wheelbase and wheel angle.
    YawRate,
}

impl FixedText for SpeedSource {
    const FIELD: &'static str = "name";
    const NAMES: &'static [(Self, &'static str)] = &[(Self::Encoder, "encoder"), (Self::YawRate, "yaw rate")];
}

impl fmt::Display for SpeedSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Values of the row at speed 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ZeroRow {
    /// For every acceleration, the torque for a wheel that has just begun to move: interpolation between this row and the next gives the
    /// torque for a moving vehicle. The default.
    #[default]
    Moving,
    /// The same for a > 0, and 0 for a ≤ 0.
    Hold,
}

impl FixedText for ZeroRow {
    const FIELD: &'static str = "zero_row";
    const NAMES: &'static [(Self, &'static str)] = &[(Self::Moving, "moving"), (Self::Hold, "hold")];
}

/// The one verdict that every speed sample of a log gets: used, or the reason why not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum SampleVerdict {
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
    /// The wheel slips: encoder and yaw rate disagree.
    Slip,
    /// Something pushes or holds the vehicle: it does not move as its torque requires.
    Push,
    /// The drive did not deliver the torque that was asked for: a governor, a power limit, a drive that derates.
    TorqueLimited,
    /// Coming to rest: motion cannot be distinguished from rest.
    Stopping,
    /// A usable stretch too short for an acceleration.
    TooShort,
}

impl SampleVerdict {
    /// Every verdict, in the order of the ledger.
    pub const ALL: [Self; 16] = [
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
        Self::TorqueLimited,
        Self::Stopping,
        Self::TooShort,
    ];
}

impl FixedText for SampleVerdict {
    const FIELD: &'static str = "verdict";
    const NAMES: &'static [(Self, &'static str)] = &[
        (Self::Used, "used"),
        (Self::Transient, "transient after a step"),
        (Self::AtRest, "at rest below breakaway"),
        (Self::NoTorque, "at rest without torque"),
        (Self::WheelNotAtAngle, "wheel not at angle"),
        (Self::SteeringMoving, "steering moving"),
        (Self::EmergencyStop, "emergency stop"),
        (Self::Aborted, "run aborted by emergency stop"),
        (Self::WrongGear, "wrong gear"),
        (Self::Gap, "gap"),
        (Self::Outlier, "outlier"),
        (Self::Slip, "slip"),
        (Self::Push, "push"),
        (Self::TorqueLimited, "torque limited"),
        (Self::Stopping, "coming to rest"),
        (Self::TooShort, "stretch too short"),
    ];
}

impl fmt::Display for SampleVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_verdict_has_a_text_of_its_own_that_reads_back() {
        assert_eq!(SampleVerdict::NAMES.len(), SampleVerdict::ALL.len());
        for verdict in SampleVerdict::ALL {
            assert_eq!(SampleVerdict::from_name(&verdict.to_string()), Ok(verdict));
        }
    }

    #[test]
    fn an_unknown_text_is_refused_with_its_field_and_the_allowed_ones() {
        assert_eq!(
            DelayStatus::from_name("at bound").unwrap_err(),
            "status is \"at bound\"; allowed: estimated, weakly determined, given, not separable, none found"
        );
        let error = serde_json::from_str::<ActuatorInput>("\"torque\"").unwrap_err().to_string();
        assert_eq!(error, "input is \"torque\"; allowed: torque command, torque feedback");
    }

    #[test]
    fn an_input_keeps_its_reason_through_the_text() {
        for text in ["torque command", "torque feedback", "torque command (the feedback reads 10 % high (of 3 logs))"] {
            let input = ActuatorInput::from_text(text).unwrap();
            assert_eq!(input.to_string(), text);
            assert_eq!(input.is_plain_command(), text == "torque command");
        }
        assert!(ActuatorInput::from_text("torque command (unclosed").is_err());
    }
}
