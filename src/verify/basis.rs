//! What a verdict is based on beside its runs: the wheel angle, what no data can show, and gears with too little data.

use crate::check::campaign_checks::too_little;
use crate::controller::words::Policy;
use crate::map::{Gear, SpeedSource, Table1File};
use crate::verify::scenario::Scenario;
use serde::{Deserialize, Serialize};

/// What a verdict is based on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Basis {
    /// Wheel angle of the pivots [°].
    pub(crate) test_angle_deg: f64,
    /// What no data of the campaign can show, with its value.
    pub(crate) assumed: Vec<String>,
    /// Gears that are not judged.
    pub(crate) too_little: Vec<UnjudgedGear>,
}

/// A gear that is not judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct UnjudgedGear {
    pub(crate) gear: Gear,
    /// The reason, with figure and limit.
    pub(crate) reason: String,
}

impl Basis {
    /// From the campaign of a Table 1.
    pub(crate) fn new(file: &Table1File) -> Self {
        let vehicle = &file.vehicle;
        let mut assumed = vec!["scale of the torque".to_owned()];
        if !file.witnesses.iter().any(|w| w.name == SpeedSource::YawRate) {
            assumed.push(format!("wheelbase {} m", vehicle.wheelbase_m));
            assumed.push(format!("wheel radius {} m", vehicle.wheel_radius_m));
        }
        let gears = Gear::ALL.into_iter().filter(|gear| file.map_at_test_angle(*gear).is_some());
        let unjudged = |gear| Some(UnjudgedGear { gear, reason: too_little(file, gear)? });
        Self { test_angle_deg: vehicle.test_angle_deg, assumed, too_little: gears.filter_map(unjudged).collect() }
    }

    /// Why a gear is not judged; `None` if it is.
    pub(crate) fn unjudged(&self, gear: Gear) -> Option<&str> {
        self.too_little.iter().find(|g| g.gear == gear).map(|g| g.reason.as_str())
    }

    /// Why a pivot cannot be tested; `None` if it can.
    pub(crate) fn untestable(&self, scenario: &Scenario, has_reverse: bool, policy: Policy) -> Option<String> {
        if !policy.has(scenario.policy) && scenario.turns_right() {
            return Some(format!("not tested: the controller's wheel policy is {}", policy.word()));
        }
        if !scenario.needs_reverse() {
            return None;
        }
        if !has_reverse {
            return Some("not tested: there is no reverse table".to_owned());
        }
        self.unjudged(Gear::Reverse).map(|reason| format!("not tested: {reason}"))
    }
}
