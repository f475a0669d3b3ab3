//! Makes the surface rise with torque everywhere, with the least change that the data allow.
//!
//! Minimises (β − β̂)ᵀ·H·(β − β̂), H = XᵀX + Λ, subject to θ_{i,j+1} − θ_{i,j} ≥ ε·(U_{j+1} − U_j) over the coefficients along torque (U_j
//! their Greville abscissae), with ε = 0.02 × the median slope: splines with rising coefficients rise (de Boor, chapter XI). Only
//! differences that are violated enter the quadratic programme (a working set); the answer is verified.

use crate::fit::solve::penalised_least_squares::{Solution, System};
use crate::fit::surface::design::Design;
use crate::fit::surface::lattice::Lattice;
use crate::map::{Gear, PerGear};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use faer::Mat;

/// Least slope, relative to the median one.
const LEAST_SLOPE: f64 = 0.02;
/// Rounds of the working set.
const ROUNDS: usize = 12;

/// The outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MonotoneOutcome {
    /// The surface rises everywhere by itself.
    AlreadyMonotone,
    /// It was moved; this number of differences bind.
    Moved(usize),
    /// The programme did not finish; running maxima made the lattice monotone instead.
    Forced,
}

/// A difference along torque on the lattice, of one gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Difference {
    gear: Gear,
    i: usize,
    j: usize,
}

/// Makes the surfaces of `gears` monotone by changing `beta` in place.
pub(crate) fn enforce(
    design: &Design,
    lattice: &Lattice,
    system: &System,
    solution: &Solution,
    gears: &[Gear],
    beta: &mut [f64],
) -> MonotoneOutcome {
    let q = design.coefficients();
    let all: Vec<Difference> = gears
        .iter()
        .flat_map(|&gear| {
            (0..lattice.speed_mps.len()).flat_map(move |i| (0..lattice.torque_nm.len() - 1).map(move |j| Difference { gear, i, j }))
        })
        .collect();
    let row = |d: &Difference| -> Vec<f64> {
        let t = design.transform(d.gear);
        let (low, high) = (lattice.column(d.i, d.j), lattice.column(d.i, d.j + 1));
        let width = lattice.torque_nm[d.j + 1] - lattice.torque_nm[d.j];
        (0..q).map(|c| (t[(high, c)] - t[(low, c)]) / width).collect()
    };
    let slopes = |beta: &[f64]| -> Vec<f64> {
        let values = PerGear::from_fn(|g| if gears.contains(&g) { design.lattice_values(g, &beta[..q]) } else { Vec::new() });
        all.iter()
            .map(|d| {
                let v = &values[d.gear];
                (v[lattice.column(d.i, d.j + 1)] - v[lattice.column(d.i, d.j)]) / (lattice.torque_nm[d.j + 1] - lattice.torque_nm[d.j])
            })
            .collect()
    };
    let first = slopes(beta);
    let least = LEAST_SLOPE * crate::signal::median(&first).max(1e-9);
    let violated = |slopes: &[f64], by: f64| -> Vec<usize> { (0..slopes.len()).filter(|k| slopes[*k] < by).collect() };
    let mut working = violated(&first, least);
    if working.is_empty() {
        return MonotoneOutcome::AlreadyMonotone;
    }
    // H over the design's coefficients, scaled to a unit mean diagonal
    let mut h = Mat::from_fn(q, q, |a, b| system.matrix[(a, b)]);
    for (block, penalty) in design.blocks.iter().zip(&solution.penalties) {
        for k in block.range.clone() {
            h[(k, k)] += if block.penalised { penalty.min(1e12) } else { 0.0 };
        }
    }
    // the variables are scaled by the diagonal so that the programme is well conditioned
    let scale: Vec<f64> = (0..q).map(|k| 1.0 / h[(k, k)].max(1e-12).sqrt()).collect();
    let start: Vec<f64> = beta[..q].to_vec();
    for _ in 0..ROUNDS {
        let rows: Vec<Vec<f64>> = working.iter().map(|k| row(&all[*k])).collect();
        let Some(step) = programme(&h, &scale, &rows, &start, least * 1.05) else { break };
        let tried: Vec<f64> = start.iter().zip(&step).map(|(b, s)| b + s).collect();
        let now = slopes(&tried);
        let missing: Vec<usize> = violated(&now, least).into_iter().filter(|k| !working.contains(k)).collect();
        if missing.is_empty() {
            if violated(&now, 0.5 * least).is_empty() {
                beta[..q].copy_from_slice(&tried);
                return MonotoneOutcome::Moved(working.len());
            }
            break;
        }
        working.extend(missing);
    }
    MonotoneOutcome::Forced
}

/// min ½ sᵀHs subject to R(β̂ + s) ≥ least, in scaled variables.
fn programme(h: &Mat<f64>, scale: &[f64], rows: &[Vec<f64>], start: &[f64], least: f64) -> Option<Vec<f64>> {
    let q = scale.len();
    let (mut pointers, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for c in 0..q {
        for r in 0..=c {
            let value = h[(r, c)] * scale[r] * scale[c] + if r == c { 1e-9 } else { 0.0 };
            if value.abs() > 1e-14 {
                indices.push(r);
                values.push(value);
            }
        }
        pointers.push(indices.len());
    }
    let p = CscMatrix::new(q, q, pointers, indices, values);
    // A x + s = b with s ≥ 0: −R·D·x + s = R·β̂ − least, each row scaled to unit length
    let lengths: Vec<f64> = rows.iter().map(|r| r.iter().zip(scale).map(|(r, s)| (r * s).powi(2)).sum::<f64>().sqrt().max(1e-12)).collect();
    let (mut pointers, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for c in 0..q {
        for (r, row) in rows.iter().enumerate() {
            if row[c] != 0.0 {
                indices.push(r);
                values.push(-row[c] * scale[c] / lengths[r]);
            }
        }
        pointers.push(indices.len());
    }
    let a = CscMatrix::new(rows.len(), q, pointers, indices, values);
    let b: Vec<f64> = rows.iter().zip(&lengths).map(|(r, l)| (r.iter().zip(start).map(|(r, b)| r * b).sum::<f64>() - least) / l).collect();
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_feas(1e-10)
        .tol_gap_abs(1e-10)
        .tol_gap_rel(1e-10)
        .max_iter(100)
        .build()
        .ok()?;
    let linear = vec![0.0; q];
    let cones = [SupportedConeT::NonnegativeConeT(rows.len())];
    let mut solver = DefaultSolver::new(&p, &linear, &a, &b, &cones, settings).ok()?;
    solver.solve();
    matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved)
        .then(|| solver.solution.x.iter().zip(scale).map(|(x, s)| x * s).collect())
}

/// Running maxima along torque: the last resort, monotone by construction.
pub(crate) fn force(lattice: &Lattice, theta: &mut [f64]) {
    let slopes: Vec<f64> = (0..lattice.speed_mps.len())
        .flat_map(|i| (0..lattice.torque_nm.len() - 1).map(move |j| (i, j)))
        .map(|(i, j)| (theta[lattice.column(i, j + 1)] - theta[lattice.column(i, j)]) / (lattice.torque_nm[j + 1] - lattice.torque_nm[j]))
        .collect();
    let least = LEAST_SLOPE * crate::signal::median(&slopes).max(1e-9);
    for i in 0..lattice.speed_mps.len() {
        for j in 0..lattice.torque_nm.len() - 1 {
            let floor = theta[lattice.column(i, j)] + least * (lattice.torque_nm[j + 1] - lattice.torque_nm[j]);
            let above = &mut theta[lattice.column(i, j + 1)];
            *above = above.max(floor);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_step_is_the_least_that_keeps_the_bound() {
        let rises = [vec![-1.0, 1.0]];
        // both move as far, and by less where the data hold faster
        let even = programme(&Mat::identity(2, 2), &[1.0, 1.0], &rises, &[1.0, 0.0], 0.5).unwrap();
        assert!((even[0] + 0.75).abs() < 1e-6 && (even[1] - 0.75).abs() < 1e-6, "{even:?}");
        let stiff = Mat::from_fn(2, 2, |a, b| {
            if a != b {
                0.0
            } else if a == 0 {
                8.0
            } else {
                1.0
            }
        });
        let uneven = programme(&stiff, &[8f64.powf(-0.5), 1.0], &rises, &[1.0, 0.0], 0.5).unwrap();
        assert!((uneven[0] + 1.5 / 9.0).abs() < 1e-6 && (uneven[1] - 12.0 / 9.0).abs() < 1e-6, "{uneven:?}");
    }

    #[test]
    fn a_bound_that_holds_asks_for_no_step() {
        let step = programme(&Mat::identity(2, 2), &[1.0, 1.0], &[vec![-1.0, 1.0]], &[0.0, 2.0], 0.5).unwrap();
        assert!(step.iter().all(|s| s.abs() < 1e-6), "{step:?}");
    }
}
