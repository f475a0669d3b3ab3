//! The surface A(V, U) = Σ θ_k·B_k(V, U): hats on a lattice of speeds and torques, and two smooth columns for what hats follow badly.
//!
//! Speed nodes are uniform in w(V) = ln(1 + V/0.12 m/s): friction changes fastest near standstill. Torque nodes are uniform, with one at
//! U = 0, where driving turns into braking and a kink is allowed.

/// Speed at which the warp turns from linear to logarithmic [m/s].
const WARP_MPS: f64 = 0.12;
/// Speed over which the extra friction near standstill fades [m/s].
const STRIBECK_MPS: f64 = 0.08;
/// Number of the smooth columns beside the lattice: exp(−(V/0.08)²) and (V/V_max)².
pub(crate) const EXTRAS: usize = 2;

/// The nodes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lattice {
    /// Speed nodes [m/s], from 0.
    pub(crate) speed_mps: Vec<f64>,
    /// Torque nodes [N·m], one of them 0.
    pub(crate) torque_nm: Vec<f64>,
}

/// Where a point lies in the lattice: lower node and the fraction of the way to the next, for both axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) i: usize,
    pub(crate) p: f64,
    pub(crate) j: usize,
    pub(crate) q: f64,
}

impl Lattice {
    /// Nodes over speeds 0 to `fastest_mps` and torques `lowest_nm` ≤ 0 to `highest_nm` ≥ 0.
    pub(crate) fn new(fastest_mps: f64, lowest_nm: f64, highest_nm: f64, speed_nodes: usize, torque_nodes: usize) -> Self {
        let end = (1.0 + fastest_mps / WARP_MPS).ln();
        let last = (speed_nodes - 1) as f64;
        let speed_mps = (0..speed_nodes).map(|k| WARP_MPS * ((end * k as f64 / last).exp() - 1.0)).collect();
        let step = (highest_nm.max(0.0) - lowest_nm.min(0.0)) / (torque_nodes - 1) as f64;
        let below = (-lowest_nm.min(0.0) / step - 1e-9).ceil().max(0.0) as i64;
        let above = (highest_nm.max(0.0) / step - 1e-9).ceil().max(0.0) as i64;
        let torque_nm = (-below..=above).map(|k| k as f64 * step).collect();
        Self { speed_mps, torque_nm }
    }

    /// Number of lattice columns.
    pub(crate) fn nodes(&self) -> usize {
        self.speed_mps.len() * self.torque_nm.len()
    }

    /// Number of all columns: lattice and extras.
    pub(crate) fn columns(&self) -> usize {
        self.nodes() + EXTRAS
    }

    /// Column of speed node `i` and torque node `j`.
    pub(crate) fn column(&self, i: usize, j: usize) -> usize {
        i * self.torque_nm.len() + j
    }

    /// Largest speed node [m/s].
    pub(crate) fn fastest_mps(&self) -> f64 {
        self.speed_mps[self.speed_mps.len() - 1]
    }

    /// w(V), 0 to 1 over the lattice.
    pub(crate) fn warp(&self, speed_mps: f64) -> f64 {
        (1.0 + speed_mps.max(0.0) / WARP_MPS).ln() / (1.0 + self.fastest_mps() / WARP_MPS).ln()
    }

    /// Where (V, U) lies. Speed is clamped to its nodes; torque is extended linearly from its outer intervals.
    pub(crate) fn spot(&self, speed_mps: f64, torque_nm: f64) -> Spot {
        let last = self.speed_mps.len() - 2;
        let v = speed_mps.clamp(0.0, self.fastest_mps());
        // uniform in the warp: the interval is known up to rounding
        let guess = (self.warp(v) * (last + 1) as f64) as usize;
        let mut i = guess.min(last);
        while i > 0 && self.speed_mps[i] > v {
            i -= 1;
        }
        while i < last && self.speed_mps[i + 1] <= v {
            i += 1;
        }
        let p = (v - self.speed_mps[i]) / (self.speed_mps[i + 1] - self.speed_mps[i]);
        let nodes = &self.torque_nm;
        let step = (nodes[nodes.len() - 1] - nodes[0]) / (nodes.len() - 1) as f64;
        let j = (((torque_nm - nodes[0]) / step).floor().max(0.0) as usize).min(nodes.len() - 2);
        let q = (torque_nm - nodes[j]) / (nodes[j + 1] - nodes[j]);
        Spot { i, p, j, q }
    }

    /// The smooth columns at V.
    pub(crate) fn extras(&self, speed_mps: f64) -> [f64; EXTRAS] {
        let v = speed_mps.max(0.0);
        let (stribeck, share) = (v / STRIBECK_MPS, v / self.fastest_mps());
        [(-stribeck * stribeck).exp(), share * share]
    }
}

/// A surface: coefficients on a lattice.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LatticeSurface {
    pub(crate) lattice: Lattice,
    /// Lattice values, then the extras' coefficients [m/s²].
    pub(crate) theta: Vec<f64>,
}

impl LatticeSurface {
    /// A(V, U) [m/s²].
    pub(crate) fn accel_mps2(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        self.value_and_slope(speed_mps, torque_nm).0
    }

    /// A(V, U) [m/s²] and ∂A/∂U [m/s² per N·m].
    pub(crate) fn value_and_slope(&self, speed_mps: f64, torque_nm: f64) -> (f64, f64) {
        let Spot { i, p, j, q } = self.lattice.spot(speed_mps, torque_nm);
        let at = |i: usize, j: usize| self.theta[self.lattice.column(i, j)];
        let along = |j: usize| (1.0 - p) * at(i, j) + p * at(i + 1, j);
        let (low, high) = (along(j), along(j + 1));
        let extras = self.lattice.extras(speed_mps);
        let smooth: f64 = extras.iter().zip(&self.theta[self.lattice.nodes()..]).map(|(b, t)| b * t).sum();
        let width = self.lattice.torque_nm[j + 1] - self.lattice.torque_nm[j];
        ((1.0 - q) * low + q * high + smooth, (high - low) / width)
    }

    /// The torque at which A(V, U) crosses zero from below within the nodes, or `None` when it does not.
    pub(crate) fn zero_torque_nm(&self, speed_mps: f64) -> Option<f64> {
        let nodes = &self.lattice.torque_nm;
        let values: Vec<f64> = nodes.iter().map(|u| self.accel_mps2(speed_mps, *u)).collect();
        let k = (1..nodes.len()).rev().find(|&k| values[k - 1] <= 0.0 && values[k] > 0.0)?;
        Some(nodes[k - 1] + (nodes[k] - nodes[k - 1]) * -values[k - 1] / (values[k] - values[k - 1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_torque_is_a_node_and_a_plane_is_reproduced() {
        let lattice = Lattice::new(1.1, -24.0, 40.0, 15, 21);
        assert!(lattice.torque_nm.iter().any(|u| u.abs() < 1e-12));
        assert!(lattice.torque_nm[0] <= -24.0 && lattice.torque_nm[lattice.torque_nm.len() - 1] >= 40.0);
        let mut theta = vec![0.0; lattice.columns()];
        for (i, v) in lattice.speed_mps.iter().enumerate() {
            for (j, u) in lattice.torque_nm.iter().enumerate() {
                theta[lattice.column(i, j)] = 0.02 * u - 0.5 * v;
            }
        }
        let surface = LatticeSurface { lattice, theta };
        for (v, u) in [(0.0, 0.0), (0.033, 7.7), (0.9, -23.0), (1.1, 40.0)] {
            let (a, slope) = surface.value_and_slope(v, u);
            assert!((a - (0.02 * u - 0.5 * v)).abs() < 1e-12 && (slope - 0.02).abs() < 1e-12);
        }
        let zero = surface.zero_torque_nm(0.4).unwrap_or(f64::NAN);
        assert!((zero - 10.0).abs() < 1e-9);
    }
}
