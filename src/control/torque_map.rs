//! The controller's torque source: the map, one table per gear, read with two-dimensional linear interpolation.

use crate::{Gear, TableView};

/// Torque for a speed and a desired acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lookup {
    /// Torque [N·m], gear frame.
    pub torque_nm: f64,
    /// Whether speed or acceleration lay outside the axes, so that the edge value was used.
    pub outside: bool,
}

/// Gives the torque for an acceleration, in the gear's frame.
pub trait TorqueFromAccel {
    /// Torque at a speed [m/s] and a desired acceleration [m/s²]; `None` if the map gives no torque: NaN, no table for the gear,
    /// or outside a table whose policy is to refuse.
    fn torque(&self, gear: Gear, speed_mps: f64, accel_mps2: f64) -> Option<Lookup>;
}

impl<M: TorqueFromAccel + ?Sized> TorqueFromAccel for &M {
    fn torque(&self, gear: Gear, speed_mps: f64, accel_mps2: f64) -> Option<Lookup> {
        (**self).torque(gear, speed_mps, accel_mps2)
    }
}

/// Policy outside the table's axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum OutsidePolicy {
    /// Use the edge value and set a flag. Default: the torque is limited and has the right sign, and a stop during the turn is worse.
    #[default]
    Clamp,
    /// Give no torque: the pivot fails.
    Refuse,
}

/// The tables of a map, borrowed.
#[derive(Debug, Clone, Copy)]
pub struct Tables<'a> {
    /// Table 2 of forward gear.
    pub forward: TableView<'a>,
    /// Table 2 of reverse gear, if it was tested.
    pub reverse: Option<TableView<'a>>,
    /// Policy outside the axes.
    pub policy: OutsidePolicy,
}

impl TorqueFromAccel for Tables<'_> {
    fn torque(&self, gear: Gear, speed_mps: f64, accel_mps2: f64) -> Option<Lookup> {
        let table = match gear {
            Gear::Forward => self.forward,
            Gear::Reverse => self.reverse?,
        };
        if let Some(torque_nm) = table.torque(speed_mps, accel_mps2) {
            return Some(Lookup { torque_nm, outside: false });
        }
        match self.policy {
            OutsidePolicy::Clamp => table.torque_clamped(speed_mps, accel_mps2).map(|torque_nm| Lookup { torque_nm, outside: true }),
            OutsidePolicy::Refuse => None,
        }
    }
}

/// Torque proportional to the acceleration: the usual choice without a map.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ConstantGain {
    /// Torque per acceleration [N·m per m/s²].
    pub gain_nm_per_mps2: f64,
    /// Limit of the torque in either direction [N·m].
    pub limit_nm: f64,
}

impl TorqueFromAccel for ConstantGain {
    fn torque(&self, _gear: Gear, speed_mps: f64, accel_mps2: f64) -> Option<Lookup> {
        if speed_mps.is_nan() || !accel_mps2.is_finite() || self.limit_nm.is_nan() {
            return None;
        }
        let wanted = self.gain_nm_per_mps2 * accel_mps2;
        Some(Lookup { torque_nm: wanted.max(-self.limit_nm).min(self.limit_nm), outside: false })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    const TABLE: TableView<'static> = TableView {
        speed_mps: &[0.0, 0.1, 0.4],
        accel_mps2: &[-1.0, 0.0, 0.5],
        torque_nm: &[-20.0, 10.0, 20.0, -18.0, 8.0, 19.0, -15.0, 12.0, 24.0],
    };

    #[test]
    fn outside_the_axes_the_policy_applies() {
        let clamp = Tables { forward: TABLE, reverse: None, policy: OutsidePolicy::Clamp };
        assert_eq!(clamp.torque(Gear::Forward, 0.5, 0.0), Some(Lookup { torque_nm: 12.0, outside: true }));
        assert_eq!(clamp.torque(Gear::Forward, 0.4, 0.0), Some(Lookup { torque_nm: 12.0, outside: false }));
        assert_eq!(Tables { policy: OutsidePolicy::Refuse, ..clamp }.torque(Gear::Forward, 0.5, 0.0), None);
    }

    #[test]
    fn reverse_gear_without_its_table_has_no_answer() {
        let map = Tables { forward: TABLE, reverse: None, policy: OutsidePolicy::Clamp };
        assert_eq!(map.torque(Gear::Reverse, 0.1, 0.0), None);
    }

    /// Every class of number: normal, subnormal, zero, infinite, not a number, and the axes' own breaks with their neighbours.
    fn awkward() -> impl Strategy<Value = f64> {
        let edge = |b: f64| prop::sample::select(vec![b, b.next_up(), b.next_down()]);
        prop_oneof![
            any::<f64>(),
            -2.0..2.0f64,
            Just(f64::NAN),
            Just(f64::INFINITY),
            Just(f64::NEG_INFINITY),
            edge(0.0),
            edge(0.1),
            edge(0.4),
            edge(-1.0),
            edge(0.5)
        ]
    }

    proptest! {
        #[test]
        fn no_look_up_panics_and_none_leaves_the_range_of_the_table(speed in awkward(), accel in awkward()) {
            for policy in [OutsidePolicy::Clamp, OutsidePolicy::Refuse] {
                let map = Tables { forward: TABLE, reverse: Some(TABLE), policy };
                for gear in Gear::ALL {
                    let inside = (0.0..=0.4).contains(&speed) && (-1.0..=0.5).contains(&accel);
                    match map.torque(gear, speed, accel) {
                        Some(found) => {
                            // rounding of the two weighted means
                            prop_assert!((-20.0 - 1e-12..=24.0 + 1e-12).contains(&found.torque_nm));
                            prop_assert_eq!(found.outside, !inside);
                            prop_assert!(inside || policy == OutsidePolicy::Clamp);
                        }
                        None => prop_assert!(speed.is_nan() || accel.is_nan() || (!inside && policy == OutsidePolicy::Refuse)),
                    }
                }
            }
        }
    }
}
