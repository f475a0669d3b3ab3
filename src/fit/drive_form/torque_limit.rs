//! Torque that a drive does not deliver because of a limit: the largest torque, or the largest power.
//!
//! The limit acts on the effective torque u in the gear's frame, at the wheel's speed v: u ≤ u_max in either direction, or u·v ≤ P while
//! driving. A limit is a corner of the effective torque and not a bend of the surface, so the surface does not contain it.

use crate::fit::drive_form::parameters::LIMIT;
use crate::fit::drive_form::torque::Torque;

/// A limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum TorqueLimit {
    /// None is known.
    None,
    /// Largest torque [N·m] in either direction.
    Torque(f64),
    /// Largest driving torque times speed [N·m·m/s]: the wheel's power times its radius.
    Power(f64),
}

impl TorqueLimit {
    /// The largest driving torque at a speed [N·m].
    pub(crate) fn most_nm(self, speed_mps: f64) -> f64 {
        match self {
            Self::None => f64::INFINITY,
            Self::Torque(most_nm) => most_nm,
            Self::Power(power) => power / speed_mps.max(1e-6),
        }
    }

    /// The delivered part of a requested torque, in the gear's frame [N·m].
    pub(crate) fn delivered_nm(self, speed_mps: f64, torque_nm: f64) -> f64 {
        let most_nm = self.most_nm(speed_mps);
        let least_nm = if matches!(self, Self::Torque(_)) { -most_nm } else { f64::NEG_INFINITY };
        torque_nm.clamp(least_nm, most_nm)
    }

    /// The same with derivatives: at the limit, delays and drive do not matter, and the torque is in proportion to the limit.
    pub(crate) fn delivered(self, speed_mps: f64, torque: Torque) -> Torque {
        if self == Self::None {
            return torque;
        }
        let delivered_nm = self.delivered_nm(speed_mps, torque.torque_nm);
        if delivered_nm == torque.torque_nm {
            return torque;
        }
        let mut limited = Torque::constant(delivered_nm);
        limited.by_drive[LIMIT] = delivered_nm;
        limited
    }

    /// The limit times a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        match self {
            Self::None => Self::None,
            Self::Torque(most_nm) => Self::Torque(most_nm * factor),
            Self::Power(power) => Self::Power(power * factor),
        }
    }

    /// Its logarithm; 0 without a limit.
    pub(crate) fn logarithm(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Torque(value) | Self::Power(value) => value.ln(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_limit_cuts_driving_torque_at_speed_and_a_torque_limit_both_ways() {
        let power = TorqueLimit::Power(15.0);
        assert_eq!(power.delivered_nm(0.5, 40.0), 30.0);
        assert_eq!(power.delivered_nm(0.2, 40.0), 40.0);
        assert_eq!(power.delivered_nm(0.9, -40.0), -40.0);
        assert_eq!(TorqueLimit::Torque(30.0).delivered_nm(0.9, -40.0), -30.0);
        let moving = Torque { by_dead_time: 5.0, ..Torque::constant(40.0) };
        let limited = power.delivered(0.5, moving);
        assert!(limited.torque_nm == 30.0 && limited.by_dead_time == 0.0 && limited.by_drive[LIMIT] == 30.0);
        assert_eq!(power.delivered(0.2, moving), moving);
        assert_eq!(power.scaled(1.1).delivered_nm(0.5, 40.0), 33.0);
    }
}
