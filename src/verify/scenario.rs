//! The scenarios: their turns, disturbances and expected ends.

use crate::control::{Failure, Phase, SteeringFault, WheelPolicy};
use serde::{Deserialize, Serialize};

/// Class of a scenario; the gate's limits depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// A turn on a good floor.
    Turn,
    /// A turn under conditions that the map does not contain.
    Hard,
    /// Something fails, and the vehicle must stop safely.
    Failure,
    /// A polyline with turns on the spot.
    Polyline,
    /// A path with the lateral error compensated.
    Compensation,
    /// Backing into a slot.
    Parking,
    /// A U-turn.
    UTurn,
}

impl Class {
    /// Whether it is a pivot, for which the map is made; the others are manoeuvres.
    pub fn is_pivot(self) -> bool {
        matches!(self, Self::Turn | Self::Hard | Self::Failure)
    }
}

/// A disturbance of the vehicle; values that depend on the vehicle are relative to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Disturbance {
    /// An obstacle: emergency stop.
    Obstacle,
    /// The steering no longer moves.
    SteeringStuck,
    /// The steering moves at this share of its rate.
    SteeringSlow {
        /// 0 to 1.
        rate_factor: f64,
    },
    /// The steering-angle reading is invalid.
    SteeringImplausible,
    /// The speed sensor gives no reading.
    SpeedLost,
    /// A slope along x, uphill.
    Slope {
        /// Rise over run.
        grade: f64,
    },
    /// Grip for this share of the planned acceleration; beyond it the wheel slips.
    WetFloor {
        /// 0 to 1.
        share: f64,
    },
    /// Torque limit that allows this share of the planned acceleration.
    LowBattery {
        /// 0 to 1.
        share: f64,
    },
}

/// When a disturbance begins.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Onset {
    /// In this phase …
    pub phase: Phase,
    /// … after this time in it [s].
    pub after_s: f64,
}

/// The expected end of a scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Expected {
    /// Every turn succeeds.
    Success,
    /// The turn fails for this reason.
    Failure(Failure),
}

/// One scenario.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scenario {
    /// Its name on the command line.
    pub name: String,
    /// Description.
    pub what: String,
    /// Class.
    pub class: Class,
    /// The turns, one after the other [°], left positive.
    pub turns_deg: Vec<f64>,
    /// Wheel policy.
    pub policy: WheelPolicy,
    /// Wheel angle at the start [°].
    pub start_wheel_deg: f64,
    /// Second preset of the wheel, for turns to the right with mirrored wheel [°], negative; `None` is the controller's.
    pub right_wheel_deg: Option<f64>,
    /// Third preset: wheel angle after a turn [°]; `None` is the controller's.
    pub return_wheel_deg: Option<f64>,
    /// Its disturbance and the onset; without an onset from the start.
    pub(crate) disturbance: Option<(Disturbance, Option<Onset>)>,
    /// Its expected end.
    pub(crate) expected: Expected,
}

impl Scenario {
    fn turn(name: &str, what: &str, turns_deg: &[f64], policy: WheelPolicy) -> Self {
        Self {
            name: name.to_owned(),
            what: what.to_owned(),
            class: Class::Turn,
            turns_deg: turns_deg.to_vec(),
            policy,
            start_wheel_deg: 0.0,
            right_wheel_deg: None,
            return_wheel_deg: None,
            disturbance: None,
            expected: Expected::Success,
        }
    }

    /// Whether one of its turns is to the right; only those depend on the wheel policy.
    pub(crate) fn turns_right(&self) -> bool {
        self.turns_deg.iter().any(|&t| t < 0.0)
    }

    /// Whether one of its turns needs reverse gear.
    pub fn needs_reverse(&self) -> bool {
        self.policy == WheelPolicy::HoldLeft && self.turns_right()
    }

    /// Whether one of its turns drives forward with the wheel on the side opposite to the test's.
    pub fn assumes_symmetry(&self) -> bool {
        self.policy == WheelPolicy::Mirror && self.turns_right()
    }

    /// A turn of a size [°] in each direction: to the left, to the right in reverse gear, and to the right with the wheel to the right.
    pub fn turns(size_deg: f64) -> [Self; 3] {
        let (hold, mirror) = (WheelPolicy::HoldLeft, WheelPolicy::Mirror);
        [
            Self::turn(&format!("left-{size_deg}"), &format!("{size_deg}° to the left"), &[size_deg], hold),
            Self::turn(&format!("right-{size_deg}"), &format!("{size_deg}° to the right in reverse gear"), &[-size_deg], hold),
            Self::turn(
                &format!("right-{size_deg}-mirror"),
                &format!("{size_deg}° to the right with the wheel to the right"),
                &[-size_deg],
                mirror,
            ),
        ]
    }

    /// The turn of any size that has this name, as `left-5`.
    pub(crate) fn of_turn(name: &str) -> Option<Self> {
        let size_deg: f64 = name.split('-').nth(1)?.parse().ok()?;
        Self::turns(size_deg).into_iter().find(|turn| turn.name == name)
    }

    /// Every scenario, in display order.
    pub fn all() -> Vec<Self> {
        let (hold, mirror) = (WheelPolicy::HoldLeft, WheelPolicy::Mirror);
        let mut all = Vec::new();
        let sizes = [30.0, 90.0, 180.0].map(Self::turns);
        for direction in 0..3 {
            all.extend(sizes.iter().map(|turns| turns[direction].clone()));
        }
        all.push(Self::turn("chained", "left 90°, right 90°, left 180° in a row", &[90.0, -90.0, 180.0], hold));
        all.push(Self::turn("chained-mirror", "left 90°, right 90°, left 180° in a row, mirrored", &[90.0, -90.0, 180.0], mirror));
        all.push(Self {
            right_wheel_deg: Some(-80.0),
            return_wheel_deg: Some(25.0),
            ..Self::turn(
                "chained-presets",
                "left 90°, right 90°, left 180°, mirrored, with presets of the wheel of −80° for the right and 25° after each turn",
                &[90.0, -90.0, 180.0],
                mirror,
            )
        });
        let left = |name: &str, what: &str| Self::turn(name, what, &[90.0], hold);
        all.push(Self { start_wheel_deg: -35.0, ..left("wheel-off-angle", "left 90°, the wheel at −35° at the start") });
        let hard =
            |name: &str, what: &str, disturbance| Self { class: Class::Hard, disturbance: Some((disturbance, None)), ..left(name, what) };
        all.push(hard(
            "wet-floor",
            "left 90° on a floor that grips for three quarters of the planned acceleration",
            Disturbance::WetFloor { share: 0.75 },
        ));
        all.push(hard("slope", "left 90° on a slope of 2 %", Disturbance::Slope { grade: 0.02 }));
        all.push(hard("low-battery", "left 90° with torque for half of the planned acceleration", Disturbance::LowBattery { share: 0.5 }));
        let failing = |name: &str, what: &str, disturbance, phase, after_s, failure| Self {
            class: Class::Failure,
            disturbance: Some((disturbance, Some(Onset { phase, after_s }))),
            expected: Expected::Failure(failure),
            ..left(name, what)
        };
        for (name, what, phase, after_s) in [
            ("stop-steering", "obstacle while the wheel turns to its angle", Phase::WaitingForAngle, 0.5),
            ("stop-gear", "obstacle while the gear is set", Phase::SettingGear, 0.0),
            ("stop-driving", "obstacle while driving", Phase::Driving, 1.5),
            ("stop-standstill", "obstacle while the wheel comes to rest", Phase::WaitingForStandstill, 0.0),
            ("stop-restoring", "obstacle while the wheel returns", Phase::RestoringAngle, 0.5),
        ] {
            all.push(failing(name, what, Disturbance::Obstacle, phase, after_s, Failure::ObstacleStop));
        }
        let (out, back) = (Phase::WaitingForAngle, Phase::RestoringAngle);
        let eps = Failure::Steering;
        for (name, what, disturbance, phase, failure) in [
            ("eps-stuck", "steering stuck on its way out", Disturbance::SteeringStuck, out, eps(SteeringFault::Stuck)),
            ("eps-stuck-back", "steering stuck on its way back", Disturbance::SteeringStuck, back, eps(SteeringFault::Stuck)),
            ("eps-slow-back", "steering creeps back", Disturbance::SteeringSlow { rate_factor: 0.05 }, back, eps(SteeringFault::TooSlow)),
            (
                "eps-implausible",
                "steering angle out of range on its way back",
                Disturbance::SteeringImplausible,
                back,
                eps(SteeringFault::Implausible),
            ),
            ("speed-lost", "speed sensor lost while driving", Disturbance::SpeedLost, Phase::Driving, Failure::SpeedLost),
        ] {
            all.push(failing(name, what, disturbance, phase, 0.5, failure));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_scenario_has_its_own_name() {
        let all = Scenario::all();
        assert_eq!(all.iter().map(|s| s.name.as_str()).collect::<BTreeSet<_>>().len(), all.len());
    }

    #[test]
    fn a_turn_of_any_size_is_known_by_its_name() {
        for name in ["left-5", "right-7.5", "right-12-mirror", "left-90"] {
            assert_eq!(Scenario::of_turn(name).unwrap().name, name);
        }
        for name in ["left-", "left-x", "left-90@80°", "slope", "up-5"] {
            assert!(Scenario::of_turn(name).is_none(), "{name}");
        }
    }
}
