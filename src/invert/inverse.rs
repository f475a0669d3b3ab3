//! The exact inverse of a piecewise linear, rising curve, at any speed.

use crate::invert::{Error, Result};
use crate::map::{AccelTable, Gear};

/// The fine surface, ready for inversion: at a speed, acceleration is piecewise linear in torque.
#[derive(Debug, Clone)]
pub(crate) struct Inverse {
    table: AccelTable,
}

impl Inverse {
    /// Checks that every column rises.
    pub(crate) fn new(table: AccelTable, gear: Gear) -> Result<Self> {
        let torques = table.torque_nm().breaks();
        for (j, speed_mps) in table.speed_mps().breaks().iter().enumerate() {
            for i in 1..torques.len() {
                let (low, high) = (table.at(j, i - 1), table.at(j, i));
                if high <= low {
                    return Err(Error::NotMonotone {
                        gear,
                        speed_mps: *speed_mps,
                        low_nm: torques[i - 1],
                        low_mps2: low,
                        high_nm: torques[i],
                        high_mps2: high,
                    });
                }
            }
        }
        Ok(Self { table })
    }

    /// Acceleration at each torque node, at `speed_mps` (clamped to the table).
    fn curve(&self, speed_mps: f64) -> Vec<f64> {
        let torques = self.table.torque_nm().breaks();
        torques.iter().map(|u| self.table.accel_from_torque_clamped(speed_mps, *u).unwrap_or(0.0)).collect()
    }

    /// A(v, τ), extended linearly beyond the torque nodes [m/s²].
    pub(crate) fn accel_mps2(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        interpolate(self.table.torque_nm().breaks(), &self.curve(speed_mps), torque_nm)
    }

    /// The torques [N·m] that give each of `accel_mps2` at a speed, extended linearly beyond the torque nodes.
    pub(crate) fn torques_nm(&self, speed_mps: f64, accel_mps2: &[f64]) -> Vec<f64> {
        let curve = self.curve(speed_mps);
        accel_mps2.iter().map(|a| interpolate(&curve, self.table.torque_nm().breaks(), *a)).collect()
    }

    /// The torque that gives one acceleration at a speed [N·m].
    pub(crate) fn torque_nm(&self, speed_mps: f64, accel_mps2: f64) -> f64 {
        interpolate(&self.curve(speed_mps), self.table.torque_nm().breaks(), accel_mps2)
    }

    /// ∂A/∂τ at a speed and torque [m/s² per N·m].
    pub(crate) fn slope(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        let torques = self.table.torque_nm().breaks();
        let curve = self.curve(speed_mps);
        let k = torques.partition_point(|u| *u <= torque_nm).clamp(1, torques.len() - 1);
        (curve[k] - curve[k - 1]) / (torques[k] - torques[k - 1])
    }

    /// Largest speed of the surface [m/s].
    pub(crate) fn fastest_mps(&self) -> f64 {
        self.table.speed_mps().last()
    }
}

/// Piecewise linear y(x) through rising nodes, extended linearly beyond the ends.
fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let k = x.partition_point(|v| *v <= at).clamp(1, x.len() - 1);
    y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Axis;

    fn surface() -> AccelTable {
        let speed = Axis::new("speed_mps", vec![0.0, 0.5, 1.0]).unwrap();
        let torque = Axis::new("torque_nm", vec![-20.0, 0.0, 40.0]).unwrap();
        AccelTable::new(speed, torque, vec![-1.0, -1.2, -1.5, -0.3, -0.5, -0.9, 1.0, 0.7, 0.1]).unwrap()
    }

    #[test]
    fn forward_then_inverse_is_the_identity_even_beyond_the_nodes() {
        let inverse = Inverse::new(surface(), Gear::Forward).unwrap();
        for v in [0.0, 0.2, 0.77, 1.0] {
            for u in [-30.0, -20.0, -3.0, 0.0, 12.0, 40.0, 44.0] {
                assert!((inverse.torque_nm(v, inverse.accel_mps2(v, u)) - u).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_table_that_does_not_rise_is_refused_with_its_place() {
        let speed = Axis::new("speed_mps", vec![0.0, 1.0]).unwrap();
        let torque = Axis::new("torque_nm", vec![0.0, 10.0]).unwrap();
        let flat = AccelTable::new(speed, torque, vec![0.0, 0.5, 1.0, 0.5]).unwrap();
        assert!(matches!(Inverse::new(flat, Gear::Forward), Err(Error::NotMonotone { speed_mps, .. }) if speed_mps == 1.0));
    }
}
