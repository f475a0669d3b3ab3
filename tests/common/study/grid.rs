//! A map a(v, u) on a grid, and its exact inverse along torque.

use pivot_cal::control::lookup::bracket;

/// A map: rows speeds, columns torques.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    speed_mps: Vec<f64>,
    torque_nm: Vec<f64>,
    accel_mps2: Vec<Vec<f64>>,
}

impl Grid {
    /// Made to rise with torque by running maxima, so that it has an inverse.
    pub(crate) fn new(speed_mps: Vec<f64>, torque_nm: Vec<f64>, mut accel_mps2: Vec<Vec<f64>>) -> Self {
        for row in &mut accel_mps2 {
            for j in 1..row.len() {
                row[j] = row[j].max(row[j - 1] + 1e-6);
            }
        }
        Self { speed_mps, torque_nm, accel_mps2 }
    }

    /// The torque for an acceleration; beyond the ends the outer torque.
    pub(crate) fn torque_nm(&self, speed_mps: f64, accel_mps2: f64) -> f64 {
        let last = self.speed_mps.len() - 1;
        let v = speed_mps.clamp(self.speed_mps[0], self.speed_mps[last]);
        let (i, p) = bracket(&self.speed_mps, v).unwrap_or((last - 1, 1.0));
        let row: Vec<f64> = self.accel_mps2[i].iter().zip(&self.accel_mps2[i + 1]).map(|(a, b)| (1.0 - p) * a + p * b).collect();
        let a = accel_mps2.clamp(row[0], row[row.len() - 1]);
        let (j, q) = bracket(&row, a).unwrap_or((row.len() - 2, 1.0));
        self.torque_nm[j] + q * (self.torque_nm[j + 1] - self.torque_nm[j])
    }
}
