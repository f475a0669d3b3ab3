//! A table for the simulator's look-ups with derivatives: thousands in sequence, each near the one before.

use crate::map::AccelTable;

/// A table for fast repeated look-ups.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    speed_mps: Vec<f64>,
    torque_nm: Vec<f64>,
    per_speed: Vec<f64>,
    per_torque: Vec<f64>,
    accel_mps2: Vec<f64>,
}

/// Position of the last look-up; the next one is near it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cell {
    pub(crate) speed: usize,
    pub(crate) torque: usize,
}

impl Surface {
    pub(crate) fn new(table: &AccelTable) -> Self {
        let widths = |breaks: &[f64]| breaks.windows(2).map(|w| 1.0 / (w[1] - w[0])).collect();
        let (speed, torque) = (table.speed_mps().breaks(), table.torque_nm().breaks());
        Self {
            speed_mps: speed.to_vec(),
            torque_nm: torque.to_vec(),
            per_speed: widths(speed),
            per_torque: widths(torque),
            accel_mps2: table.values().to_vec(),
        }
    }

    /// Bilinear interpolation; clamped in speed, extrapolated linearly in torque.
    #[inline]
    pub(crate) fn accel(&self, cell: &mut Cell, s: f64, u: f64) -> f64 {
        self.plane(cell, s, u).accel
    }

    /// The same with its derivatives by speed and by torque; beyond the speeds the former is zero.
    #[allow(clippy::inline_always)] // one look-up a step, whose result would go through memory
    #[inline(always)]
    pub(crate) fn plane(&self, cell: &mut Cell, s: f64, u: f64) -> Plane {
        let last = self.speed_mps.len() - 1;
        let inside = s <= self.speed_mps[last];
        let s = s.clamp(self.speed_mps[0], self.speed_mps[last]);
        let j = walk(&self.speed_mps, cell.speed, s);
        let i = walk(&self.torque_nm, cell.torque, u);
        *cell = Cell { speed: j, torque: i };
        let q = (s - self.speed_mps[j]) * self.per_speed[j];
        let p = (u - self.torque_nm[i]) * self.per_torque[i];
        let near = i * (last + 1) + j;
        let row = &self.accel_mps2[near..near + 2];
        let next = &self.accel_mps2[near + last + 1..near + last + 3];
        let (low_rise, high_rise) = (row[1] - row[0], next[1] - next[0]);
        let low = row[0] + q * low_rise;
        let step = next[0] + q * high_rise - low;
        let by_speed = if inside { (low_rise + p * (high_rise - low_rise)) * self.per_speed[j] } else { 0.0 };
        Plane { accel: low + p * step, by_speed, by_torque: step * self.per_torque[i] }
    }
}

/// Acceleration and its derivatives.
pub(crate) struct Plane {
    pub(crate) accel: f64,
    pub(crate) by_speed: f64,
    pub(crate) by_torque: f64,
}

/// Index of the interval that holds `x`, or of the nearest one; the search starts at `from`.
#[inline]
fn walk(breaks: &[f64], from: usize, x: f64) -> usize {
    let last = breaks.len() - 2;
    let mut k = from.min(last);
    while k < last && x >= breaks[k + 1] {
        k += 1;
    }
    while k > 0 && x < breaks[k] {
        k -= 1;
    }
    k
}
