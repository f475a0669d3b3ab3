//! Nodes of a bilinear table with the smallest squared torque error, at and between them (Garcia & Gupta 2009, lattice regression).
//!
//! Minimises Σ (T(v, a) − τ(v, a))² over a dense cloud of reachable (v, a), plus 1e-3 × the same toward the exact nodes, subject to
//! T rising in a and |T| ≤ τ_max. τ_max is the limit of the nodes: one beyond the reach may have more torque than is delivered, so that the table
//! is right up to the edge.

use crate::invert::delivered_torque::DeliveredTorque;
use crate::invert::inverse::Inverse;
use crate::map::lookup::bracket;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use std::collections::BTreeMap;

/// Points of the cloud per interval of the speed axis, and per interval of the acceleration axis.
const PER_INTERVAL: usize = 6;
/// Weight of the pull toward the exact nodes, relative to a point of the cloud.
const RIDGE: f64 = 1e-3;
/// Least rise of torque from one acceleration break to the next, relative to the mean one.
const LEAST_RISE: f64 = 1e-3;

/// The nodes, row-major by speed; `None` when the programme does not finish.
///
/// `range_nm` bounds the torque of the cloud (the tested range), `limit` that of cloud and table.
pub(crate) fn nodes(inverse: &Inverse, speeds: &[f64], accels: &[f64], range_nm: [f64; 2], limit: &DeliveredTorque) -> Option<Vec<f64>> {
    let columns = accels.len();
    let n = speeds.len() * columns;
    let exact: Vec<f64> = speeds.iter().flat_map(|v| inverse.torques_nm(*v, accels)).collect();
    let mut quadratic: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    let mut linear = vec![0.0; n];
    let mut square_add = |column: usize, row: usize, value: f64| {
        *quadratic.entry((column.max(row), column.min(row))).or_insert(0.0) += value;
    };
    for i in 0..speeds.len() - 1 {
        for s in 0..PER_INTERVAL {
            let v = speeds[i] + (s as f64 + 0.5) / PER_INTERVAL as f64 * (speeds[i + 1] - speeds[i]);
            let (low, high) = (inverse.accel_mps2(v, range_nm[0]), inverse.accel_mps2(v, limit.clamp(v, range_nm[1])));
            for j in 0..columns - 1 {
                let wanted: Vec<f64> = (0..PER_INTERVAL)
                    .map(|t| accels[j] + (t as f64 + 0.5) / PER_INTERVAL as f64 * (accels[j + 1] - accels[j]))
                    .filter(|a| *a >= low && *a <= high)
                    .collect();
                for (a, torque) in wanted.iter().zip(inverse.torques_nm(v, &wanted)) {
                    let ((i, p), (j, q)) = (bracket(speeds, v)?, bracket(accels, *a)?);
                    let corners = [
                        (i * columns + j, (1.0 - p) * (1.0 - q)),
                        (i * columns + j + 1, (1.0 - p) * q),
                        ((i + 1) * columns + j, p * (1.0 - q)),
                        ((i + 1) * columns + j + 1, p * q),
                    ];
                    for (x, (k, wk)) in corners.iter().enumerate() {
                        linear[*k] -= wk * torque;
                        for (l, wl) in &corners[x..] {
                            square_add(*k, *l, wk * wl);
                        }
                    }
                }
            }
        }
    }
    for k in 0..n {
        square_add(k, k, RIDGE);
        linear[k] -= RIDGE * limit.clamp(speeds[k / columns], exact[k]);
    }
    // upper triangle by columns: the map is ordered by (column, row)
    let (mut pointers, mut indices, mut values) = (vec![0; n + 1], Vec::new(), Vec::new());
    for ((column, row), value) in &quadratic {
        pointers[column + 1] += 1;
        indices.push(*row);
        values.push(*value);
    }
    for k in 0..n {
        pointers[k + 1] += pointers[k];
    }
    let p = CscMatrix::new(n, n, pointers, indices, values);
    let rise = LEAST_RISE * (exact[columns - 1] - exact[0]).abs() / (columns - 1) as f64;
    let (a, b) = constraints(speeds.len(), columns, rise, limit.node_limit_nm);
    let settings = DefaultSettingsBuilder::default().verbose(false).max_iter(200).build().ok()?;
    let cones = [SupportedConeT::NonnegativeConeT(b.len())];
    let mut solver = DefaultSolver::new(&p, &linear, &a, &b, &cones, settings).ok()?;
    solver.solve();
    if !matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
        return None;
    }
    let mut nodes: Vec<f64> = solver.solution.x.iter().map(|t| t.clamp(-limit.node_limit_nm, limit.node_limit_nm)).collect();
    // the solver keeps its constraints only to a tolerance: falling values are made level
    for row in nodes.chunks_exact_mut(columns) {
        for j in 1..columns {
            row[j] = row[j].max(row[j - 1]);
        }
    }
    Some(nodes)
}

/// T_j − T_{j+1} + s = −rise within each speed, then ±T + s = limit; s ≥ 0. Where the limits bind, neighbours may be equal. So the rise is
/// required by rows, and is softened to zero by the number of breaks that fit below the limit.
fn constraints(rows: usize, columns: usize, rise: f64, limit_nm: f64) -> (CscMatrix<f64>, Vec<f64>) {
    let n = rows * columns;
    let differences = rows * (columns - 1);
    let rise = rise.min(limit_nm / columns as f64 * 1e-3);
    let (mut pointers, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for k in 0..n {
        let (i, j) = (k / columns, k % columns);
        if j > 0 {
            indices.push(i * (columns - 1) + j - 1);
            values.push(-1.0);
        }
        if j + 1 < columns {
            indices.push(i * (columns - 1) + j);
            values.push(1.0);
        }
        indices.push(differences + k);
        values.push(1.0);
        indices.push(differences + n + k);
        values.push(-1.0);
        pointers.push(indices.len());
    }
    let mut b = vec![-rise; differences];
    b.extend(std::iter::repeat_n(limit_nm, 2 * n));
    (CscMatrix::new(differences + 2 * n, n, pointers, indices, values), b)
}
