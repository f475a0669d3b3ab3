//! The regressors of one segment: integrals of the surface's columns along the way, never derivatives.
//!
//! Φ_k(t) = ∫ B_k(V̂(s), u(s)) ds from the segment's start ([`Course`]). Beside them what the delays and the encoder's calibration would
//! change: ∫ A_U·∂u/∂T_d ds, ∫ A_U·∂u/∂T_c ds, V̂ and −dV̂/dt at the encoder's readings.

use super::course::Course;
use super::kalman::{Filter, Noise};
use super::lattice::{LatticeSurface, Spot};

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

/// What is free beside the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Free {
    /// The surface alone.
    Surface,
    /// Dead times and lag too.
    Delays,
    /// The encoder's scale and delay as well; readings must not be merged then: what two witnesses of one moment tell differently is what
    /// calibrates one by the other.
    DelaysAndEncoder,
}

impl Free {
    /// Nuisance columns beside the surface's for so many logs.
    pub(crate) fn nuisances(self, logs: usize) -> usize {
        if self == Self::Surface { 0 } else { nuisance::DEAD_TIME + logs }
    }
}

/// A dense matrix over the columns that a segment touches.
#[derive(Debug, Clone)]
pub(crate) struct LocalMatrix {
    /// Global column of each local one; the last local column is the speed.
    pub(crate) columns: Vec<u32>,
    /// Row-major, one row per reading.
    pub(crate) data: Vec<f64>,
}

/// The whitened matrix of one segment. The surface gives the slopes of the nuisance columns, where something else is free.
pub(crate) fn whitened(course: &Course, speed_mps: &[f64], surface: &LatticeSurface, noise: &Noise, free: Free) -> LocalMatrix {
    let with_nuisance = free != Free::Surface;
    let segment = course.segment;
    let lattice = &surface.lattice;
    let base = lattice.columns();
    // what each step of the integration touches
    let mut touched = vec![u32::MAX; base];
    let mut columns: Vec<u32> = Vec::new();
    let mut spots: Vec<Spot> = Vec::with_capacity(2 * course.rows());
    for row in 0..course.rows() {
        for (v, step) in course.along(speed_mps, row) {
            let spot = lattice.spot(v, step.torque.torque_nm);
            for i in 0..4 {
                let from = lattice.column(spot.along_speed.first + i, spot.along_torque.first);
                for (column, place) in (from..).zip(&mut touched[from..from + 4]) {
                    if *place == u32::MAX {
                        *place = columns.len() as u32;
                        columns.push(column as u32);
                    }
                }
            }
            spots.push(spot);
        }
    }
    let nuisance_at = columns.len();
    if with_nuisance {
        let shared = [nuisance::LAG, nuisance::ENCODER_SCALE, nuisance::ENCODER_DELAY].map(|c| (base + c) as u32);
        columns.extend(shared);
        columns.push((base + nuisance::DEAD_TIME + segment.log) as u32);
    }
    columns.push(u32::MAX);
    let width = columns.len();
    let mut data = vec![0.0; course.rows() * width];
    let mut sums = vec![0.0; width];
    let mut spots = spots.iter();
    for (row, line) in data.chunks_exact_mut(width).enumerate() {
        for ((v, step), spot) in course.along(speed_mps, row).zip(&mut spots) {
            for i in 0..4 {
                let from = lattice.column(spot.along_speed.first + i, spot.along_torque.first);
                let by_speed = step.length_s * spot.along_speed.value[i];
                for (place, by_torque) in touched[from..from + 4].iter().zip(spot.along_torque.value) {
                    sums[*place as usize] += by_speed * by_torque;
                }
            }
            // a torque that stands has no delay
            if with_nuisance && (step.torque.by_lag != 0.0 || step.torque.by_dead_time != 0.0) {
                let slope = step.length_s * surface.value_and_slope(v, step.torque.torque_nm).1;
                sums[nuisance_at] += slope * step.torque.by_lag;
                sums[nuisance_at + 3] += slope * step.torque.by_dead_time;
            }
        }
        line.copy_from_slice(&sums);
        let reading = segment.readings[row];
        line[width - 1] = reading.speed_mps;
        if free == Free::DelaysAndEncoder && reading.witness == 0 {
            let v = speed_mps[row].max(0.0);
            let torque_nm = course.steps(row).last().map_or(0.0, |s| s.torque.torque_nm);
            line[nuisance_at + 1] = v;
            line[nuisance_at + 2] = -surface.accel_mps2(v, torque_nm);
        }
    }
    Filter::over(&segment.readings, segment.start_s, noise, segment.start_std_mps).whiten(&mut data, width);
    LocalMatrix { columns, data }
}
