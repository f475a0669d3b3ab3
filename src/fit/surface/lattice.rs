//! The surface A(V, U) = Σ θ_k·B_k(V, U): products of cubic B-splines in speed and torque.
//!
//! Speed knots are uniform in w(V) = ln(1 + V/0.12 m/s): friction changes fastest near standstill. Torque knots are uniform, with one at
//! U = 0, where driving turns into braking and a kink is allowed.

use crate::fit::surface::spline::{Spline, Weights};

/// Speed at which the warp turns from linear to logarithmic [m/s].
const WARP_MPS: f64 = 0.12;

/// The knots and their coefficients.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lattice {
    fastest_mps: f64,
    /// 1 / w(V_max).
    warp_scale: f64,
    speed: Spline,
    torque: Spline,
    /// Speed to which each coefficient along speed belongs (Greville's abscissa) [m/s], from 0.
    pub(crate) speed_mps: Vec<f64>,
    /// Torque to which each coefficient along torque belongs [N·m], one of them 0.
    pub(crate) torque_nm: Vec<f64>,
}

/// The sixteen coefficients at a point: four along speed times four along torque.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) along_speed: Weights,
    pub(crate) along_torque: Weights,
}

impl Lattice {
    /// Coefficients over speeds 0 to `fastest_mps` and torques `lowest_nm` ≤ 0 to `highest_nm` ≥ 0: `speeds` of them along speed, about
    /// `torques` along torque.
    pub(crate) fn new(fastest_mps: f64, lowest_nm: f64, highest_nm: f64, speeds: usize, torques: usize) -> Self {
        let fastest_mps = fastest_mps.max(1e-3);
        let warp_scale = 1.0 / (fastest_mps / WARP_MPS).ln_1p();
        let intervals = speeds.saturating_sub(3).max(1);
        let speed = Spline::new(0.0, 1.0 / intervals as f64, intervals, None);
        // a kink costs two coefficients, the clamped ends three
        let (low, high) = (lowest_nm.min(0.0), highest_nm.max(0.0));
        let step = (high - low) / torques.saturating_sub(5).max(2) as f64;
        let below = (-low / step - 1e-9).ceil().max(0.0) as usize;
        let above = (high / step - 1e-9).ceil().max(0.0) as usize;
        let torque = Spline::new(-step * below as f64, step, below + above, Some(below));
        let speed_mps = speed.greville().iter().map(|w| WARP_MPS * (w / warp_scale).exp_m1()).collect();
        // exactly zero at the kink
        let torque_nm = torque.greville().iter().map(|u| if u.abs() < 1e-9 * step { 0.0 } else { *u }).collect();
        Self { fastest_mps, warp_scale, speed, torque, speed_mps, torque_nm }
    }

    /// Number of coefficients.
    pub(crate) fn columns(&self) -> usize {
        self.speed_mps.len() * self.torque_nm.len()
    }

    /// Column of coefficient `i` along speed and `j` along torque.
    pub(crate) fn column(&self, i: usize, j: usize) -> usize {
        i * self.torque_nm.len() + j
    }

    /// Upper end of the speeds [m/s].
    pub(crate) fn fastest_mps(&self) -> f64 {
        self.fastest_mps
    }

    /// w(V), 0 to 1 over the lattice.
    pub(crate) fn warp(&self, speed_mps: f64) -> f64 {
        (1.0 + speed_mps.max(0.0) * (1.0 / WARP_MPS)).ln() * self.warp_scale
    }

    /// Coefficients along speed of a function of the speed.
    pub(crate) fn along_speed(&self, f: impl Fn(f64) -> f64) -> Vec<f64> {
        self.speed.through(|w| f(WARP_MPS * (w / self.warp_scale).exp_m1()))
    }

    /// Knots along torque [N·m].
    pub(crate) fn torque_knots_nm(&self) -> Vec<f64> {
        self.torque.knots()
    }

    /// The coefficients at (V, U). Speed is held at its ends; torque is extended linearly.
    pub(crate) fn spot(&self, speed_mps: f64, torque_nm: f64) -> Spot {
        Spot { along_speed: self.speed.held(self.warp(speed_mps)), along_torque: self.torque.extended(torque_nm) }
    }
}

impl Spot {
    /// Columns with their weights.
    pub(crate) fn columns<'a>(&'a self, lattice: &'a Lattice) -> impl Iterator<Item = (usize, f64)> + 'a {
        let (a, b) = (&self.along_speed, &self.along_torque);
        (0..4).flat_map(move |i| (0..4).map(move |j| (lattice.column(a.first + i, b.first + j), a.value[i] * b.value[j])))
    }
}

/// A surface: coefficients on a lattice.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LatticeSurface {
    pub(crate) lattice: Lattice,
    /// Coefficients [m/s²].
    pub(crate) theta: Vec<f64>,
}

impl LatticeSurface {
    /// Between the accelerations of a wheel that begins to move under the lowest and the highest torque [m/s²].
    pub(crate) fn range_mps2(&self) -> f64 {
        let torques = &self.lattice.torque_nm;
        (self.accel_mps2(0.0, torques[torques.len() - 1]) - self.accel_mps2(0.0, torques[0])).abs()
    }

    /// A(V, U) [m/s²].
    pub(crate) fn accel_mps2(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        self.at(&self.lattice.spot(speed_mps, torque_nm))
    }

    /// A at a spot of its lattice [m/s²].
    pub(crate) fn at(&self, spot: &Spot) -> f64 {
        dot(self.across(&spot.along_speed, spot.along_torque.first), spot.along_torque.value)
    }

    /// A(V, U) [m/s²] and ∂A/∂U [m/s² per N·m].
    pub(crate) fn value_and_slope(&self, speed_mps: f64, torque_nm: f64) -> (f64, f64) {
        let (along_torque, by_torque) = self.lattice.torque.extended_with_slope(torque_nm);
        let across = self.across(&self.lattice.speed.held(self.lattice.warp(speed_mps)), along_torque.first);
        (dot(across, along_torque.value), dot(across, by_torque))
    }

    /// The four coefficients along torque from `first` on, at a speed.
    fn across(&self, along_speed: &Weights, first: usize) -> [f64; 4] {
        let mut sums = [0.0; 4];
        for (i, weight) in along_speed.value.into_iter().enumerate() {
            let from = self.lattice.column(along_speed.first + i, first);
            sums.iter_mut().zip(&self.theta[from..from + 4]).for_each(|(sum, theta)| *sum += weight * theta);
        }
        sums
    }

    /// The torque at which A(V, U) last crosses zero from below within the knots, or `None` when it does not.
    pub(crate) fn zero_torque_nm(&self, speed_mps: f64) -> Option<f64> {
        let knots = self.lattice.torque_knots_nm();
        let at = |u: f64| self.accel_mps2(speed_mps, u);
        let k = (1..knots.len()).rev().find(|&k| at(knots[k - 1]) <= 0.0 && at(knots[k]) > 0.0)?;
        let (mut low, mut high) = (knots[k - 1], knots[k]);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if at(middle) <= 0.0 { low = middle } else { high = middle }
        }
        Some(0.5 * (low + high))
    }
}

fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_torque_is_a_knot_and_a_plane_is_reproduced() {
        let lattice = Lattice::new(1.1, -24.0, 40.0, 15, 21);
        assert!(lattice.torque_nm.contains(&0.0));
        let knots = lattice.torque_knots_nm();
        assert!(knots[0] <= -24.0 && knots[knots.len() - 1] >= 40.0);
        let along_speed = lattice.along_speed(|v| v);
        let mut theta = vec![0.0; lattice.columns()];
        for (i, v) in along_speed.iter().enumerate() {
            for (j, u) in lattice.torque_nm.iter().enumerate() {
                theta[lattice.column(i, j)] = 0.02 * u - 0.5 * v;
            }
        }
        let surface = LatticeSurface { lattice, theta };
        for (v, u) in [(0.0, 0.0), (0.033, 7.7), (0.9, -23.0), (1.1, 40.0), (0.5, 60.0)] {
            let (a, slope) = surface.value_and_slope(v, u);
            assert!((a - (0.02 * u - 0.5 * v)).abs() < 1e-4 && (slope - 0.02).abs() < 1e-9, "{v} {u} {a}");
        }
        let zero = surface.zero_torque_nm(0.4).unwrap_or(f64::NAN);
        assert!((zero - 10.0).abs() < 5e-3);
    }
}
