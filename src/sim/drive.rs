//! The drive: commanded torque → quantisation, saturation, slew limit, dead time, first- or second-order lag → effective torque.
//!
//! `u̇ = (τ(t − T_d) − u)/T_c`, with dead time `T_d` and time constant `T_c`. The command is constant over a step, so the solution is
//! exact: `u⁺ = τ + (u − τ)·exp(−t/T_c)`, applied before and after the instant inside the step at which the delayed command changes.

use crate::map::{DriveFamily, IdentifiedDrive, LimitKind};
use crate::sim::error::{Result, within};
use crate::sim::second_order::SecondOrderStep;
use serde::{Deserialize, Serialize};

/// Settings of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DriveSettings {
    /// Dead time between command and first effect [s], 0 to 2. Default 0.05: two cycles of a 50 Hz bus and the dead time of the converter.
    pub dead_time_s: f64,
    /// Time constant of the first-order lag [s], 0 to 2. Default 0.05.
    pub lag_s: f64,
    /// Largest torque [N·m] in either direction. Default 44.
    pub torque_limit_nm: f64,
    /// Step of the command's encoding [N·m]; 0, the default, for no quantisation.
    pub torque_quantum_nm: f64,
    /// Smaller commands give no torque [N·m]; 0, the default, for no dead band.
    pub torque_dead_band_nm: f64,
    /// Largest rate of the setpoint [N·m/s]. Default: unlimited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slew_limit_nm_s: Option<f64>,
    /// Largest rate at which the setpoint's magnitude falls [N·m/s]. Default: the same as the other way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slew_fall_limit_nm_s: Option<f64>,
    /// Natural frequency of a second-order drive [Hz], 0.1 to 100, instead of the first-order lag. Default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// Damping of a second-order drive, 0.01 to 10 (1: critical). Default 0.7.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Brake friction during an emergency stop, referred to the wheel [N·m]. Default 15.
    pub estop_brake_nm: f64,
}

impl Default for DriveSettings {
    fn default() -> Self {
        Self {
            dead_time_s: 0.05,
            lag_s: 0.05,
            torque_limit_nm: 44.0,
            torque_quantum_nm: 0.0,
            torque_dead_band_nm: 0.0,
            slew_limit_nm_s: None,
            slew_fall_limit_nm_s: None,
            frequency_hz: None,
            damping: None,
            estop_brake_nm: 15.0,
        }
    }
}

impl DriveSettings {
    /// The same with the drive that a fit found, if it is more than a first-order lag. If the feedback gave the torque, only the nearest
    /// first-order drive is known.
    pub(crate) fn as_found(self, found: Option<&IdentifiedDrive>) -> Self {
        let Some(found) = found else { return self };
        let limit_nm = found.limit.filter(|l| l.kind == LimitKind::Torque).map_or(f64::INFINITY, |l| l.value);
        let torque_limit_nm = self.torque_limit_nm.min(limit_nm);
        match (found.family, found.slopes_nm_s) {
            (DriveFamily::RateLimit, Some([grows, falls])) => Self {
                lag_s: found.lag_s.unwrap_or(self.lag_s),
                slew_limit_nm_s: Some(grows),
                slew_fall_limit_nm_s: Some(falls),
                torque_limit_nm,
                ..self
            },
            (DriveFamily::SecondOrder, _) => Self { frequency_hz: found.frequency_hz, damping: found.damping, torque_limit_nm, ..self },
            _ => Self { torque_limit_nm, ..self },
        }
    }

    /// The same with what a vehicle file gives and torque steps hardly show: step and dead band of the command, and rate limits where none was
    /// found.
    pub(crate) fn with_given(self, given: &Self) -> Self {
        Self {
            torque_quantum_nm: given.torque_quantum_nm,
            torque_dead_band_nm: given.torque_dead_band_nm,
            slew_limit_nm_s: self.slew_limit_nm_s.or(given.slew_limit_nm_s),
            slew_fall_limit_nm_s: self.slew_fall_limit_nm_s.or(given.slew_fall_limit_nm_s),
            ..self
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first field that is out of its range.
    pub fn check(&self) -> Result<()> {
        within("drive.dead_time_s", self.dead_time_s, 0.0..=2.0, "0 to 2")?;
        within("drive.lag_s", self.lag_s, 0.0..=2.0, "0 to 2")?;
        within("drive.torque_limit_nm", self.torque_limit_nm, 1e-3..=1e5, "0.001 to 1e5")?;
        within("drive.torque_quantum_nm", self.torque_quantum_nm, 0.0..=1e3, "0 to 1000")?;
        within("drive.torque_dead_band_nm", self.torque_dead_band_nm, 0.0..=1e4, "0 to 1e4")?;
        within("drive.slew_limit_nm_s", self.slew_limit_nm_s.unwrap_or(1.0), 1e-3..=1e7, "0.001 to 1e7")?;
        within("drive.slew_fall_limit_nm_s", self.slew_fall_limit_nm_s.unwrap_or(1.0), 1e-3..=1e7, "0.001 to 1e7")?;
        within("drive.frequency_hz", self.frequency_hz.unwrap_or(1.0), 0.1..=100.0, "0.1 to 100")?;
        within("drive.damping", self.damping.unwrap_or(0.7), 0.01..=10.0, "0.01 to 10")?;
        within("drive.estop_brake_nm", self.estop_brake_nm, 0.0..=1e5, "0 to 1e5")
    }
}

/// Effective torque [N·m] over one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct TorqueStep {
    /// At its start.
    pub start_nm: f64,
    /// Half way.
    pub mid_nm: f64,
    /// At its end.
    pub end_nm: f64,
}

/// The drive's state.
#[derive(Debug, Clone)]
pub(crate) struct Drive {
    settings: DriveSettings,
    slew_per_step_nm: f64,
    /// The same while the setpoint's magnitude falls.
    fall_per_step_nm: f64,
    second_order: Option<SecondOrderStep>,
    /// The last command and its value after rounding and limits: most steps repeat it.
    last_command_nm: f64,
    wanted_nm: f64,
    setpoint_nm: f64,
    /// Delayed commands, the oldest at `oldest`; one per whole step of the dead time.
    underway_nm: Vec<f64>,
    oldest: usize,
    /// Delayed command before the change inside the step.
    before_nm: f64,
    effective_nm: f64,
    decay: Decays,
    /// No torque has been commanded yet.
    untouched: bool,
}

/// Remaining share of a difference after parts of a step; the delayed command changes at the fraction f of the step.
#[derive(Debug, Clone, Copy)]
struct Decays {
    change_before_mid: bool,
    to_change: f64,
    to_mid: f64,
    mid_to_change: f64,
    change_to_mid: f64,
    to_end: f64,
    whole: f64,
}

impl Drive {
    /// A drive at rest, stepped every `step_s`.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub(crate) fn new(settings: &DriveSettings, step_s: f64) -> Result<Self> {
        settings.check()?;
        let steps = settings.dead_time_s / step_s;
        let whole = (steps + 1e-9).floor();
        let fraction = if steps - whole > 1e-9 { steps - whole } else { 0.0 };
        let remains = |part: f64| match (part > 0.0, settings.lag_s > 0.0) {
            (false, _) => 1.0,
            (true, true) => (-part * step_s / settings.lag_s).exp(),
            (true, false) => 0.0,
        };
        let decay = Decays {
            change_before_mid: fraction <= 0.5,
            to_change: remains(fraction),
            to_mid: remains(0.5),
            mid_to_change: remains(fraction - 0.5),
            change_to_mid: remains(0.5 - fraction),
            to_end: remains(1.0 - fraction),
            whole: remains(1.0),
        };
        Ok(Self {
            settings: *settings,
            slew_per_step_nm: settings.slew_limit_nm_s.map_or(f64::INFINITY, |limit| limit * step_s),
            fall_per_step_nm: settings.slew_fall_limit_nm_s.or(settings.slew_limit_nm_s).map_or(f64::INFINITY, |limit| limit * step_s),
            second_order: settings.frequency_hz.map(|hz| SecondOrderStep::new(hz, settings.damping.unwrap_or(0.7), step_s)),
            last_command_nm: 0.0,
            wanted_nm: 0.0,
            setpoint_nm: 0.0,
            underway_nm: vec![0.0; whole as usize],
            oldest: 0,
            before_nm: 0.0,
            effective_nm: 0.0,
            decay,
            untouched: true,
        })
    }

    /// Changes the saturation [N·m], as for a low battery.
    pub(crate) fn set_torque_limit_nm(&mut self, limit_nm: f64) {
        self.settings.torque_limit_nm = limit_nm.max(0.0);
        self.wanted_nm = self.limited(self.last_command_nm);
    }

    /// Effective torque now [N·m].
    #[inline]
    pub(crate) fn effective_nm(&self) -> f64 {
        self.effective_nm
    }

    /// Whether no torque has been commanded yet: a step without torque then changes nothing.
    #[inline]
    pub(crate) fn is_untouched(&self) -> bool {
        self.untouched
    }

    /// Sets `command_nm` as the command of all past time: no command is delayed, and the effective torque equals the command.
    pub(crate) fn settle(&mut self, command_nm: f64) {
        self.untouched = false;
        let settled_nm = self.limited(command_nm);
        (self.last_command_nm, self.wanted_nm) = (command_nm, settled_nm);
        self.underway_nm.fill(settled_nm);
        if let Some(second_order) = &mut self.second_order {
            second_order.settle();
        }
        (self.setpoint_nm, self.before_nm, self.effective_nm) = (settled_nm, settled_nm, settled_nm);
    }

    /// Advances one step under `command_nm` (a command that is not a number counts as zero).
    #[allow(clippy::inline_always)] // three numbers returned through memory would stall every step of the world
    #[inline(always)]
    pub(crate) fn step(&mut self, command_nm: f64) -> TorqueStep {
        if command_nm != self.last_command_nm {
            self.untouched = false;
            self.last_command_nm = command_nm;
            self.wanted_nm = self.limited(command_nm);
        }
        let way_nm = self.wanted_nm - self.setpoint_nm;
        let falls = way_nm * self.setpoint_nm < 0.0;
        let most_nm = if falls { self.fall_per_step_nm } else { self.slew_per_step_nm };
        self.setpoint_nm += way_nm.clamp(-most_nm, most_nm);
        let after = match self.underway_nm.get_mut(self.oldest) {
            None => self.setpoint_nm,
            Some(slot) => {
                let due = std::mem::replace(slot, self.setpoint_nm);
                self.oldest += 1;
                if self.oldest == self.underway_nm.len() {
                    self.oldest = 0;
                }
                due
            }
        };
        if let Some(second_order) = &mut self.second_order {
            let start_nm = self.effective_nm;
            let [mid_nm, end_nm] = second_order.step(start_nm, after);
            self.effective_nm = end_nm;
            return TorqueStep { start_nm, mid_nm, end_nm };
        }
        let (before, decay) = (self.before_nm, &self.decay);
        let toward = |goal: f64, from: f64, remains: f64| goal + (from - goal) * remains;
        if after == before {
            let start_nm = self.effective_nm;
            self.effective_nm = toward(after, start_nm, decay.whole);
            return TorqueStep { start_nm, mid_nm: toward(after, start_nm, decay.to_mid), end_nm: self.effective_nm };
        }
        let start_nm = if decay.to_mid == 0.0 && decay.to_change == 1.0 { after } else { self.effective_nm };
        let (mid_nm, at_change) = if decay.change_before_mid {
            let at_change = toward(before, start_nm, decay.to_change);
            (toward(after, at_change, decay.change_to_mid), at_change)
        } else {
            let mid = toward(before, start_nm, decay.to_mid);
            (mid, toward(before, mid, decay.mid_to_change))
        };
        let end_nm = toward(after, at_change, decay.to_end);
        self.before_nm = after;
        self.effective_nm = end_nm;
        TorqueStep { start_nm, mid_nm, end_nm }
    }

    /// The command after quantisation and saturation [N·m]; NaN counts as zero.
    #[inline]
    pub(crate) fn limited(&self, command_nm: f64) -> f64 {
        let limit = self.settings.torque_limit_nm;
        let quantum = self.settings.torque_quantum_nm;
        let coded = if quantum > 0.0 { (command_nm / quantum).round() * quantum } else { command_nm };
        if coded.is_nan() || coded.abs() < self.settings.torque_dead_band_nm { 0.0 } else { coded.clamp(-limit, limit) }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// `1 − exp(−(t − T_d)/T_c)`, the textbook step response.
    fn response(t_s: f64, dead_time_s: f64, lag_s: f64) -> f64 {
        if t_s <= dead_time_s { 0.0 } else { 1.0 - (-(t_s - dead_time_s) / lag_s).exp() }
    }

    #[test]
    fn a_drive_that_was_left_alone_answers_like_one_that_was_commanded_nothing() {
        let settings = DriveSettings { dead_time_s: 0.0473, ..DriveSettings::default() };
        let (mut left, mut stepped) = (Drive::new(&settings, 1e-3).unwrap(), Drive::new(&settings, 1e-3).unwrap());
        for _ in 0..37 {
            stepped.step(0.0);
        }
        assert!(stepped.is_untouched());
        for k in 0..200 {
            let command_nm = if k < 100 { 20.0 } else { -5.0 };
            assert_eq!(left.step(command_nm), stepped.step(command_nm));
        }
        assert!(!stepped.is_untouched());
    }

    #[test]
    fn the_step_response_is_the_analytic_one_even_between_steps() {
        for (dead_time_s, lag_s) in [(0.05, 0.05), (0.0473, 0.031), (0.0007, 0.2), (0.0, 0.05)] {
            let mut drive = Drive::new(&DriveSettings { dead_time_s, lag_s, ..DriveSettings::default() }, 1e-3).unwrap();
            for k in 0..500 {
                let step = drive.step(20.0);
                let t_s = f64::from(k) * 1e-3;
                // exact solution: only rounding remains
                for (found, t_s) in [(step.start_nm, t_s), (step.mid_nm, t_s + 5e-4), (step.end_nm, t_s + 1e-3)] {
                    let expected = 20.0 * response(t_s, dead_time_s, lag_s);
                    assert!((found - expected).abs() < 1e-10, "T_d {dead_time_s}, T_c {lag_s}, t {t_s}: {found} for {expected}");
                }
            }
        }
    }

    #[test]
    fn without_dead_time_and_lag_the_torque_is_the_command() {
        let mut drive = Drive::new(&DriveSettings { dead_time_s: 0.0, lag_s: 0.0, ..DriveSettings::default() }, 1e-3).unwrap();
        assert_eq!(drive.step(12.0), TorqueStep { start_nm: 12.0, mid_nm: 12.0, end_nm: 12.0 });
    }

    #[test]
    fn the_command_is_rounded_limited_and_slewed() {
        let settings = DriveSettings {
            dead_time_s: 0.0,
            lag_s: 0.0,
            torque_limit_nm: 40.0,
            torque_quantum_nm: 0.5,
            slew_limit_nm_s: Some(1000.0),
            ..DriveSettings::default()
        };
        let mut drive = Drive::new(&settings, 1e-3).unwrap();
        assert_eq!(drive.limited(12.3), 12.5);
        assert_eq!(drive.limited(-99.0), -40.0);
        assert_eq!(drive.limited(f64::NAN), 0.0);
        assert_eq!(drive.limited(f64::INFINITY), 40.0);
        assert_eq!(drive.step(40.0).end_nm, 1.0);
    }
}
