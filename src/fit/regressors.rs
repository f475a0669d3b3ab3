//! The regressors of one segment: integrals of the surface's columns along the way, never derivatives.
//!
//! Φ_k(t) = ∫ B_k(V̂(s), u(s)) ds from the segment's start, by the midpoint rule with steps of at most 5 ms. Beside them what the delays
//! and the encoder's calibration would change: ∫ A_U·∂u/∂T_d ds, ∫ A_U·∂u/∂T_c ds, V̂ and −dV̂/dt at the encoder's readings.

use super::actuator::LaggedCommand;
use super::lattice::{LatticeSurface, Spot};
use super::segment::Segment;

/// Columns after those of the surface: shared ones, then one dead time per log.
pub(crate) mod nuisance {
    /// T_c.
    pub(crate) const LAG: usize = 0;
    /// Relative change of the encoder's scale.
    pub(crate) const ENCODER_SCALE: usize = 1;
    /// Change of the encoder's delay [s].
    pub(crate) const ENCODER_DELAY: usize = 2;
    /// T_d of the first log.
    pub(crate) const DEAD_TIME: usize = 3;
}

/// Longest step of the integration [s].
const LONGEST_STEP_S: f64 = 5e-3;

/// A dense matrix over the columns that a segment touches.
#[derive(Debug, Clone)]
pub(crate) struct LocalMatrix {
    /// Global column of each local one; the last local column is the speed.
    pub(crate) columns: Vec<u32>,
    /// Row-major, one row per reading.
    pub(crate) data: Vec<f64>,
}

/// One step of the integration.
struct Quadrature {
    spot: Spot,
    weight: f64,
    by_lag: f64,
    by_dead_time: f64,
}

/// Speed along the segment between its readings, 0 at an anchored start.
fn speed_at(segment: &Segment, speed_mps: &[f64], row: usize, fraction: f64) -> f64 {
    let before = if row > 0 {
        speed_mps[row - 1]
    } else if segment.anchored {
        0.0
    } else {
        speed_mps[0]
    };
    (before + fraction * (speed_mps[row] - before)).max(0.0)
}

/// Steps of the integration between reading `row − 1` (or the start) and reading `row`: (time, speed, length).
fn steps<'a>(segment: &'a Segment, speed_mps: &'a [f64], row: usize) -> impl Iterator<Item = (f64, f64, f64)> + 'a {
    let from = if row > 0 { segment.readings[row - 1].t_s } else { segment.start_s };
    let length = (segment.readings[row].t_s - from).max(0.0);
    let count = (length / LONGEST_STEP_S).ceil().max(1.0) as usize;
    (0..count).map(move |k| {
        let fraction = (k as f64 + 0.5) / count as f64;
        (from + fraction * length, speed_at(segment, speed_mps, row, fraction), length / count as f64)
    })
}

/// The speed that the surface predicts at each reading, from 0 at the segment's start [m/s].
pub(crate) fn predicted(segment: &Segment, speed_mps: &[f64], torque: &dyn Fn(f64) -> f64, surface: &LatticeSurface) -> Vec<f64> {
    let mut sum = 0.0;
    (0..segment.readings.len())
        .map(|row| {
            for (t, v, length) in steps(segment, speed_mps, row) {
                sum += length * surface.accel_mps2(v, torque(t));
            }
            sum
        })
        .collect()
}

/// The matrix of one segment. `surface` gives the slopes for the nuisance columns; `with_nuisance` asks for them.
pub(crate) fn matrix(
    segment: &Segment,
    speed_mps: &[f64],
    lagged: &LaggedCommand,
    dead_time_s: f64,
    surface: &LatticeSurface,
    with_nuisance: bool,
) -> LocalMatrix {
    let lattice = &surface.lattice;
    let sign = segment.gear.sign();
    let base = lattice.columns();
    let logs_at = base + nuisance::DEAD_TIME;
    let rows = segment.readings.len();
    // what each step of the integration touches
    let mut touched = vec![u32::MAX; base];
    let mut columns: Vec<u32> = Vec::new();
    let mut quadrature: Vec<Vec<Quadrature>> = Vec::with_capacity(rows);
    for row in 0..rows {
        let list = steps(segment, speed_mps, row)
            .map(|(t, v, weight)| {
                let torque = lagged.at(t - dead_time_s);
                let spot = lattice.spot(v, sign * torque.torque_nm);
                for (column, _) in spot.columns(lattice) {
                    if touched[column] == u32::MAX {
                        touched[column] = columns.len() as u32;
                        columns.push(column as u32);
                    }
                }
                let slope = if with_nuisance { sign * surface.value_and_slope(v, sign * torque.torque_nm).1 } else { 0.0 };
                Quadrature { spot, weight, by_lag: weight * slope * torque.by_lag, by_dead_time: weight * slope * torque.by_dead_time }
            })
            .collect();
        quadrature.push(list);
    }
    let nuisance_at = columns.len();
    if with_nuisance {
        let shared = [nuisance::LAG, nuisance::ENCODER_SCALE, nuisance::ENCODER_DELAY].map(|c| (base + c) as u32);
        columns.extend(shared);
        columns.push((logs_at + segment.log) as u32);
    }
    columns.push(u32::MAX);
    let width = columns.len();
    let mut data = vec![0.0; rows * width];
    let mut sums = vec![0.0; width];
    for (row, line) in data.chunks_exact_mut(width).enumerate() {
        for q in &quadrature[row] {
            for (column, weight) in q.spot.columns(lattice) {
                sums[touched[column] as usize] += q.weight * weight;
            }
            if with_nuisance {
                sums[nuisance_at] += q.by_lag;
                sums[nuisance_at + 3] += q.by_dead_time;
            }
        }
        line.copy_from_slice(&sums);
        let reading = segment.readings[row];
        line[width - 1] = reading.speed_mps;
        if with_nuisance && reading.witness == 0 {
            let torque = sign * lagged.at(reading.t_s - dead_time_s).torque_nm;
            line[nuisance_at + 1] = speed_mps[row];
            line[nuisance_at + 2] = -surface.accel_mps2(speed_mps[row].max(0.0), torque);
        }
    }
    LocalMatrix { columns, data }
}
