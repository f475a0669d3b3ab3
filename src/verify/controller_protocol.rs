//! The lines between a verdict and a controller that is a process: JSON, SI units, angles of the wheel in degrees.
//!
//! `docs/controller.md` describes every field.

use crate::control::{Failure, Inputs, Phase, PivotRequest, PivotSettings, SteeringFault};
use crate::map::Gear;
use crate::text::name_from_outside;
use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// Version of the lines.
const PROTOCOL: u32 = 1;
/// Largest wheel angle of an answer [°].
const LARGEST_WHEEL_ANGLE_DEG: f64 = 180.0;

/// The first line: what does not change in a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct StartLine {
    protocol: u32,
    period_s: f64,
    wheelbase_m: f64,
    wheel_radius_m: f64,
    torque_limit_nm: f64,
    start_speed_mps: f64,
    cruise_speed_mps: f64,
    accel_mps2: f64,
    decel_mps2: f64,
}

impl StartLine {
    /// From the plan that the verdict expects, and data of the vehicle.
    pub(crate) fn new(control: &PivotSettings, period_s: f64, wheel_radius_m: f64, torque_limit_nm: f64) -> Self {
        let (planning, profile) = (&control.planning, &control.planning.profile);
        Self {
            protocol: PROTOCOL,
            period_s,
            wheelbase_m: planning.wheelbase_m,
            wheel_radius_m,
            torque_limit_nm,
            start_speed_mps: profile.start_mps,
            cruise_speed_mps: profile.cruise_mps,
            accel_mps2: profile.accel_mps2,
            decel_mps2: profile.decel_mps2,
        }
    }

    /// The line.
    pub(crate) fn line(&self) -> String {
        serde_json::json!({ "start": self }).to_string()
    }
}

/// A gear of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum GearWord {
    Forward,
    Reverse,
    Neutral,
}

impl From<Option<Gear>> for GearWord {
    fn from(gear: Option<Gear>) -> Self {
        match gear {
            Some(Gear::Forward) => Self::Forward,
            Some(Gear::Reverse) => Self::Reverse,
            None => Self::Neutral,
        }
    }
}

impl GearWord {
    fn gear(self) -> Option<Gear> {
        match self {
            Self::Forward => Some(Gear::Forward),
            Self::Reverse => Some(Gear::Reverse),
            Self::Neutral => None,
        }
    }
}

/// The requested turn in a line of readings.
#[derive(Debug, Serialize)]
struct TurnField {
    number: usize,
    turn_deg: f64,
    wheel_angle_deg: f64,
    return_wheel_angle_deg: f64,
    gear: GearWord,
}

/// The readings of a period.
#[derive(Debug, Serialize)]
struct Readings {
    time_s: f64,
    speed_mps: Option<f64>,
    wheel_angle_deg: f64,
    gear: GearWord,
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
    emergency_stop: bool,
    turn: Option<TurnField>,
}

/// The line of a period that begins at `t_s` [s]; `turn` is the number of the requested turn, from 1, its size [rad] and its plan.
pub(crate) fn readings_line(t_s: f64, inputs: &Inputs, turn: Option<(usize, f64, &PivotRequest)>) -> String {
    let readings = Readings {
        time_s: t_s,
        speed_mps: inputs.speed_mps,
        wheel_angle_deg: inputs.wheel_angle_rad / RAD_PER_DEG,
        gear: inputs.gear.into(),
        x_m: inputs.pose.x_m,
        y_m: inputs.pose.y_m,
        heading_rad: inputs.pose.heading_rad,
        emergency_stop: inputs.estop,
        turn: turn.map(|(number, turn_rad, request)| TurnField {
            number,
            turn_deg: turn_rad / RAD_PER_DEG,
            wheel_angle_deg: request.wheel_angle_rad / RAD_PER_DEG,
            return_wheel_angle_deg: request.return_angle_rad / RAD_PER_DEG,
            gear: Some(request.gear).into(),
        }),
    };
    // numbers and words only: no value of it fails to serialise
    serde_json::to_string(&readings).unwrap_or_default()
}

/// A phase of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum PhaseWord {
    Idle,
    WaitingForAngle,
    SettingGear,
    Driving,
    WaitingForStandstill,
    RestoringAngle,
    Succeeded,
    Failed,
}

/// A reason of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum FailureWord {
    ObstacleStop,
    SteeringImplausible,
    SteeringStuck,
    SteeringTooSlow,
    SteeringLost,
    GearNotSet,
    SpeedLost,
    StoodStill,
    TimeOut,
    OutsideTable,
}

impl FailureWord {
    fn failure(self) -> Failure {
        match self {
            Self::ObstacleStop => Failure::ObstacleStop,
            Self::SteeringImplausible => Failure::Steering(SteeringFault::Implausible),
            Self::SteeringStuck => Failure::Steering(SteeringFault::Stuck),
            Self::SteeringTooSlow => Failure::Steering(SteeringFault::TooSlow),
            Self::SteeringLost => Failure::Steering(SteeringFault::Lost),
            Self::GearNotSet => Failure::GearNotSet,
            Self::SpeedLost => Failure::SpeedLost,
            Self::StoodStill => Failure::StoodStill,
            Self::TimeOut => Failure::TimeOut,
            Self::OutsideTable => Failure::OutsideTable,
        }
    }
}

/// An answer as it is written; further fields are ignored.
#[derive(Debug, Deserialize)]
struct AnswerFields {
    torque_nm: f64,
    wheel_angle_deg: f64,
    gear: GearWord,
    phase: PhaseWord,
    #[serde(default)]
    failure: Option<FailureWord>,
    #[serde(default)]
    target_speed_mps: Option<f64>,
    #[serde(default)]
    accel_mps2: Option<f64>,
}

/// The commands of a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ControllerAnswer {
    /// Torque [N·m], positive drives forward.
    pub(crate) torque_nm: f64,
    /// Target of the wheel angle [rad].
    pub(crate) wheel_angle_rad: f64,
    /// Gear; `None` is neutral.
    pub(crate) gear: Option<Gear>,
    /// Phase; a failure with its reason.
    pub(crate) phase: Phase,
    /// Desired speed [m/s] and acceleration [m/s²] in the gear's direction, if both were given.
    pub(crate) desired: Option<(f64, f64)>,
}

impl ControllerAnswer {
    /// Reads an answer. `is_requested`: a turn is in force, so that the controller cannot be idle.
    ///
    /// # Errors
    /// What is wrong with it, with the line.
    pub(crate) fn read(line: &str, is_requested: bool) -> std::result::Result<Self, String> {
        let wrong = |what: &str| format!("{what}; the answer was `{}`", name_from_outside(line));
        let fields: AnswerFields = serde_json::from_str(line).map_err(|error| {
            let message = error.to_string();
            let has_word = ["NaN", "nan", "Infinity", "inf"].iter().any(|word| line.contains(word));
            if message.contains("number out of range") || (error.is_syntax() && has_word) {
                wrong("a number is not finite")
            } else {
                wrong(&format!("it is no answer: {}", name_from_outside(&message)))
            }
        })?;
        if fields.wheel_angle_deg.abs() > LARGEST_WHEEL_ANGLE_DEG {
            return Err(wrong(&format!("wheel_angle_deg is {}; allowed: -180 to 180", fields.wheel_angle_deg)));
        }
        let phase = match (fields.phase, fields.failure) {
            (PhaseWord::Failed, Some(failure)) => Phase::Failed(failure.failure()),
            (PhaseWord::Failed, None) => return Err(wrong("the phase is \"failed\" without a failure, its reason")),
            (PhaseWord::Idle, _) if is_requested => {
                return Err(wrong("the phase is \"idle\" although a turn is requested; allowed: any other phase"));
            }
            (PhaseWord::Idle, _) => Phase::Idle,
            (PhaseWord::WaitingForAngle, _) => Phase::WaitingForAngle,
            (PhaseWord::SettingGear, _) => Phase::SettingGear,
            (PhaseWord::Driving, _) => Phase::Driving,
            (PhaseWord::WaitingForStandstill, _) => Phase::WaitingForStandstill,
            (PhaseWord::RestoringAngle, _) => Phase::RestoringAngle,
            (PhaseWord::Succeeded, _) => Phase::Succeeded,
        };
        Ok(Self {
            torque_nm: fields.torque_nm,
            wheel_angle_rad: fields.wheel_angle_deg * RAD_PER_DEG,
            gear: fields.gear.gear(),
            phase,
            desired: fields.target_speed_mps.zip(fields.accel_mps2),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::control::{PlanningSettings, Pose};
    use std::f64::consts::FRAC_PI_2;

    const GOOD: &str = r#"{"torque_nm": -3.5, "wheel_angle_deg": 90, "gear": "reverse", "phase": "driving", "mine": [1]}"#;

    #[test]
    fn an_answer_is_read_and_its_further_fields_are_not() {
        let answer = ControllerAnswer::read(GOOD, true).unwrap();
        assert_eq!((answer.torque_nm, answer.gear, answer.phase, answer.desired), (-3.5, Some(Gear::Reverse), Phase::Driving, None));
        assert!((answer.wheel_angle_rad - FRAC_PI_2).abs() < 1e-12);
        let failed =
            GOOD.replace("\"driving\"", "\"failed\", \"failure\": \"steering_stuck\", \"target_speed_mps\": 0.4, \"accel_mps2\": 0.1");
        let failed = ControllerAnswer::read(&failed, true).unwrap();
        assert_eq!((failed.phase, failed.desired), (Phase::Failed(Failure::Steering(SteeringFault::Stuck)), Some((0.4, 0.1))));
    }

    #[test]
    fn every_nonsense_has_its_message_with_the_line() {
        for (line, fault) in [
            ("hello", "it is no answer"),
            (&GOOD.replace("-3.5", "NaN"), "a number is not finite"),
            (&GOOD.replace("-3.5", "1e999"), "a number is not finite"),
            (&GOOD.replace("-3.5", "\"much\""), "expected f64"),
            (&GOOD.replace("90", "1e9"), "allowed: -180 to 180"),
            (&GOOD.replace("driving", "drivin"), "unknown variant `drivin`, expected one of `idle`"),
            (&GOOD.replace("driving", "failed"), "without a failure"),
            (&GOOD.replace("driving", "idle"), "although a turn is requested"),
            ("{\"torque_nm\": 1}", "missing field `wheel_angle_deg`"),
            ("\u{1b}[2J", "\\u{1b}[2J"),
        ] {
            let error = ControllerAnswer::read(line, true).unwrap_err();
            assert!(error.contains(fault) && error.contains("; the answer was "), "{error}");
            assert!(!error.contains('\u{1b}'), "{error}");
        }
    }

    #[test]
    fn the_readings_are_one_line_with_the_requested_turn() {
        let inputs = Inputs { speed_mps: None, wheel_angle_rad: FRAC_PI_2, pose: Pose::default(), gear: None, estop: true };
        let request = PlanningSettings::new(0.92, FRAC_PI_2).plan(-FRAC_PI_2, Pose::default()).unwrap();
        let line = readings_line(0.1, &inputs, Some((2, -FRAC_PI_2, &request)));
        let value: serde_json::Value = serde_json::from_str(&line).unwrap();
        assert!(!line.contains('\n') && value["speed_mps"].is_null() && value["emergency_stop"] == true && value["gear"] == "neutral");
        assert_eq!((&value["turn"]["number"], &value["turn"]["gear"]), (&2.into(), &"reverse".into()));
        assert!((value["turn"]["turn_deg"].as_f64().unwrap() + 90.0).abs() < 1e-9);
    }
}
