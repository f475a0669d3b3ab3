//! How a run of a campaign is driven: spin-up, level, and what ends a level. Recording and planning drive by the same rules.
//!
//! In: the time and the wheel's speed, as the driver sees them at each decision. Out: a [`RunCommand`]. All numbers are in the gear's frame.

use serde::{Deserialize, Serialize};

/// Time between two decisions [s]: a typical control cycle.
pub(crate) const CYCLE_S: f64 = 0.02;
/// The wheel is seen to rest below this speed [m/s], three quanta of a typical encoder with its noise ...
pub(crate) const AT_REST_MPS: f64 = 0.035;
/// ... for this time [s].
pub(crate) const SETTLED_S: f64 = 0.3;

/// Reason for the end of a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// It was held for the planned time.
    TimeUp,
    /// The speed limit was reached.
    SpeedLimit,
    /// A braking level reached its end speed.
    Slowed,
    /// The wheel did not move.
    Stalled,
    /// The emergency stop was pressed.
    EmergencyStop,
    /// The spin-up did not reach its speed.
    NoSpinUp,
}

/// What a run is driven by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RunOrder {
    /// Speed at which the level begins [m/s]; 0 from rest, without a spin-up.
    pub(crate) start_speed_mps: f64,
    /// Longest spin-up [s].
    pub(crate) spin_up_limit_s: f64,
    /// A level after a spin-up ends below this speed [m/s].
    pub(crate) end_speed_mps: f64,
    /// A level ends at this speed [m/s].
    pub(crate) speed_limit_mps: f64,
    /// A level at which the wheel rests ends after this time [s].
    pub(crate) stall_s: f64,
    /// Longest time at the level [s].
    pub(crate) hold_s: f64,
}

/// Command of one decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RunCommand {
    /// The torque of the spin-up.
    SpinUp,
    /// The torque of the level.
    Level,
    /// No torque: the run has ended.
    Ended(End),
}

/// The driver of one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RunDriver {
    from_s: f64,
    level_from_s: Option<f64>,
}

impl RunDriver {
    /// At the start of a run.
    pub(crate) fn new(now_s: f64) -> Self {
        Self { from_s: now_s, level_from_s: None }
    }

    /// When the level began [s]; `None` during the spin-up.
    pub(crate) fn level_from_s(&self) -> Option<f64> {
        self.level_from_s
    }

    /// The next command. `moved_s`: when the wheel was last seen to move [s].
    pub(crate) fn decide(&mut self, order: &RunOrder, now_s: f64, speed_mps: f64, moved_s: f64) -> RunCommand {
        let spun_up = order.start_speed_mps > 0.0;
        let from_s = match self.level_from_s {
            Some(from_s) => from_s,
            None if !spun_up || speed_mps >= order.start_speed_mps => now_s,
            None if now_s - self.from_s > order.spin_up_limit_s => return RunCommand::Ended(End::NoSpinUp),
            None => return RunCommand::SpinUp,
        };
        self.level_from_s = Some(from_s);
        if spun_up && speed_mps < order.end_speed_mps {
            RunCommand::Ended(End::Slowed)
        } else if speed_mps >= order.speed_limit_mps {
            RunCommand::Ended(End::SpeedLimit)
        } else if now_s - from_s.max(moved_s) > order.stall_s {
            RunCommand::Ended(End::Stalled)
        } else if now_s - from_s >= order.hold_s {
            RunCommand::Ended(End::TimeUp)
        } else {
            RunCommand::Level
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORDER: RunOrder =
        RunOrder { start_speed_mps: 0.5, spin_up_limit_s: 2.0, end_speed_mps: 0.1, speed_limit_mps: 0.9, stall_s: 1.0, hold_s: 2.5 };
    const FROM_REST: RunOrder = RunOrder { start_speed_mps: 0.0, ..ORDER };

    /// The commands at seconds 0, 0.5, 1 …, for the speeds seen there [m/s].
    fn commands(order: &RunOrder, speeds_mps: &[f64]) -> Vec<RunCommand> {
        let (mut driver, mut moved_s) = (RunDriver::new(0.0), 0.0);
        let at = |k: usize| 0.5 * k as f64;
        let decide = |(k, speed_mps): (usize, &f64)| {
            moved_s = if speed_mps.abs() > AT_REST_MPS { at(k) } else { moved_s };
            driver.decide(order, at(k), *speed_mps, moved_s)
        };
        speeds_mps.iter().enumerate().map(decide).collect()
    }

    #[test]
    fn a_spin_up_ends_at_its_speed_or_at_its_limit() {
        use RunCommand::{Ended, Level, SpinUp};
        assert_eq!(commands(&ORDER, &[0.0, 0.3, 0.5, 0.4]), [SpinUp, SpinUp, Level, Level]);
        assert_eq!(commands(&ORDER, &[0.0, 0.2, 0.2, 0.2, 0.2, 0.2]).pop(), Some(Ended(End::NoSpinUp)));
        assert_eq!(commands(&FROM_REST, &[0.0]), [Level]);
    }

    #[test]
    fn a_level_ends_by_speed_by_time_or_at_rest() {
        let end = |order: &RunOrder, speeds_mps: &[f64]| commands(order, speeds_mps).pop();
        let ended = |end| Some(RunCommand::Ended(end));
        assert_eq!(end(&ORDER, &[0.6, 0.3, 0.05]), ended(End::Slowed));
        assert_eq!(end(&FROM_REST, &[0.0, 0.05]), Some(RunCommand::Level), "a run from rest begins slowly");
        assert_eq!(end(&FROM_REST, &[0.0, 0.5, 0.9]), ended(End::SpeedLimit));
        assert_eq!(end(&FROM_REST, &[0.0, 0.3, 0.3, 0.3, 0.3, 0.3]), ended(End::TimeUp));
        assert_eq!(end(&FROM_REST, &[0.0, 0.01, 0.02]), Some(RunCommand::Level));
        assert_eq!(end(&FROM_REST, &[0.0, 0.01, 0.02, 0.0]), ended(End::Stalled));
    }
}
