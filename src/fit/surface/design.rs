//! The surface's coefficients as an analysis of variance. First a physics form without a penalty: inertia, Coulomb, Stribeck and viscous
//! friction. With it, each penalised by itself: drive and brake efficiency, their change with speed, quadratic friction, and the other
//! shapes of Stribeck friction.
//! Then smooth deviations in blocks, each with its own penalty, main effects before interactions (Lee & Durbán, P-ANOVA), and
//! gear-antisymmetric copies if both gears were driven.
//!
//! Penalised blocks are scaled so that their penalty is the identity. Along an axis they are the modes z of DᵀD that bend, from the least
//! to the most, where D gives the second differences of the splines' coefficients over Greville's abscissae (Eilers & Marx, P-splines). The
//! bending of a mode is ρ = ‖D·z‖² as a share of an axis of length one, and the penalty is λ·ρ^1.5 times the square of its coefficient. As
//! ρ grows with the fourth power of a mode's number, the penalty grows with the sixth, as a penalty on third derivatives does: a smooth
//! function may bend, waves are damped, and only straight lines are free. Second derivatives (ρ¹) leave more of the noise in: a
//! twentieth to a tenth in vehicles that no physics form describes.
//!
//! Driving and braking may meet in a kink at U = 0: U⁺ is part of the physics form. A kink that changes with speed is a block of its own,
//! so that a function smooth across U = 0 is not a sum of bends and kinks that cancel. The interaction f(V)·g(U) is penalised by its
//! bending along either axis, λ·(ρ_V + ρ_U)^1.5 (Wood 2006, *Low-rank scale-invariant tensor product smooths*), in the modes z ⊗ y of both:
//! with a penalty on mixed differences it would diverge in corners.

use crate::fit::surface::lattice::{Lattice, LatticeSurface};
use crate::map::{Gear, PerGear};
use faer::Mat;
use std::ops::Range;

/// Speed over which the extra friction near standstill fades, before it is estimated [m/s].
pub(crate) const STRIBECK_MPS: f64 = 0.1;

/// Power of a mode's bending in its penalty.
const SMOOTHNESS: f64 = 1.5;

/// The name of the physics form. The name of its gear-antisymmetric copy ends with it.
const PHYSICS: &str = "physics form";
/// The name of Stribeck friction of other shapes, which belongs to the form.
const NEAR_STANDSTILL: &str = "near standstill";

/// The names of its terms that not every vehicle needs, each with a penalty of its own (automatic relevance determination; MacKay 1992): a
/// short campaign does not determine them all.
const EFFICIENCY: &str = "drive efficiency";
const INERTIA: &str = "inertia over speed";
const QUADRATIC: &str = "quadratic friction";

/// A group of coefficients with one penalty.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CoefficientBlock {
    /// Its name, for the report.
    pub(crate) name: &'static str,
    /// Its coefficients.
    pub(crate) range: Range<usize>,
    /// Whether it is penalised (and its penalty estimated).
    pub(crate) penalised: bool,
    /// Whether it belongs to the physics form, which may be used alone.
    pub(crate) physics: bool,
}

/// How coefficients become lattice values.
#[derive(Debug, Clone)]
pub(crate) struct Design {
    /// The blocks, in the order of the coefficients.
    pub(crate) blocks: Vec<CoefficientBlock>,
    /// Speed over which the extra friction near standstill fades [m/s].
    pub(crate) stribeck_mps: f64,
    /// For forward and reverse: lattice columns × coefficients.
    transforms: PerGear<Mat<f64>>,
}

/// Collects columns block by block.
struct DesignBuilder {
    rows: usize,
    columns: Vec<(Vec<f64>, bool)>,
    blocks: Vec<CoefficientBlock>,
}

impl DesignBuilder {
    fn block(&mut self, name: &'static str, penalised: bool, antisymmetric: bool, columns: Vec<Vec<f64>>) {
        if columns.is_empty() {
            return;
        }
        let start = self.columns.len();
        self.columns.extend(columns.into_iter().map(|c| (c, antisymmetric)));
        let physics = name.ends_with(PHYSICS) || [NEAR_STANDSTILL, EFFICIENCY, INERTIA, QUADRATIC].contains(&name);
        self.blocks.push(CoefficientBlock { name, range: start..self.columns.len(), penalised, physics });
    }
}

impl Design {
    /// The design over `lattice`, with extra friction near standstill that fades over `stribeck_mps`; `both_gears` adds the antisymmetric
    /// copies.
    pub(crate) fn new(lattice: &Lattice, both_gears: bool, stribeck_mps: f64) -> Self {
        let (speeds, torques) = (&lattice.speed_mps, &lattice.torque_nm);
        let reference_nm = torques.iter().fold(0.0f64, |m, u| m.max(u.abs()));
        let fastest = lattice.fastest_mps();
        let u: Vec<f64> = torques.iter().map(|t| t / reference_nm).collect();
        let drive: Vec<f64> = u.iter().map(|u| u.max(0.0)).collect();
        let v: Vec<f64> = lattice.along_speed(|s| s / fastest);
        let w: Vec<f64> = speeds.iter().map(|s| lattice.warp(*s)).collect();
        let one_v = vec![1.0; speeds.len()];
        let one_u = vec![1.0; torques.len()];
        let along_axis = |nodes: &[f64]| modes(nodes).iter().map(|mode| mode.weighed(mode.bending)).collect::<Vec<_>>();
        let (bends_w, bends_v, bends_u) = (along_axis(&w), along_axis(&v), along_axis(&u));

        let rows = lattice.columns();
        let tensor = |along_v: &[f64], along_u: &[f64]| {
            let mut column = vec![0.0; rows];
            for (i, a) in along_v.iter().enumerate() {
                for (j, b) in along_u.iter().enumerate() {
                    column[lattice.column(i, j)] = a * b;
                }
            }
            column
        };
        let physics = || {
            let along_speed = friction(lattice, stribeck_mps);
            let mut columns = vec![tensor(&one_v, &u)];
            columns.extend(along_speed.iter().map(|f| tensor(f, &one_u)));
            columns
        };
        let extras = || {
            let squared = lattice.along_speed(|s| (s / fastest).powi(2));
            vec![(EFFICIENCY, tensor(&one_v, &drive)), (INERTIA, tensor(&v, &u)), (QUADRATIC, tensor(&squared, &one_u))]
        };
        // from one shape of the extra friction to the other: with only one of them, errors of 0.04 N·m alternate over speed if the vehicle
        // has the other
        let near_standstill = || {
            let difference = |s: f64| {
                let squared = (s / stribeck_mps).powi(2);
                1.0 / (1.0 + squared) - (-squared).exp()
            };
            vec![tensor(&lattice.along_speed(difference), &one_u)]
        };
        let f = || bends_w.iter().map(|z| tensor(z, &one_u)).collect::<Vec<_>>();
        let g = || bends_u.iter().map(|z| tensor(&one_v, z)).collect::<Vec<_>>();
        let w_by_u = || vec![tensor(&w, &u), tensor(&w, &drive)];
        let w_by_g = || bends_u.iter().map(|z| tensor(&w, z)).collect::<Vec<_>>();
        let f_by = |along_u: &[f64]| bends_v.iter().map(|z| tensor(z, along_u)).collect::<Vec<_>>();
        let f_by_g = || {
            let (along_v, along_u) = (modes(&v), modes(&u));
            let pairs = along_v.iter().flat_map(|z| along_u.iter().map(move |y| (z, y)));
            pairs.map(|(z, y)| tensor(&z.weighed(z.bending + y.bending), &y.shape)).collect::<Vec<_>>()
        };

        let mut builder = DesignBuilder { rows, columns: Vec::new(), blocks: Vec::new() };
        builder.block(PHYSICS, false, false, physics());
        for (name, column) in extras() {
            builder.block(name, true, false, vec![column]);
        }
        builder.block(NEAR_STANDSTILL, true, false, near_standstill());
        builder.block("f(V)", true, false, f());
        builder.block("g(U)", true, false, g());
        builder.block("w(V)·U", true, false, w_by_u());
        builder.block("w(V)·g(U)", true, false, w_by_g());
        builder.block("f(V)·U", true, false, f_by(&u));
        builder.block("f(V)·U⁺", true, false, f_by(&drive));
        builder.block("f(V)·g(U)", true, false, f_by_g());
        if both_gears {
            builder.block("gear: physics form", true, true, physics().into_iter().chain(extras().into_iter().map(|e| e.1)).collect());
            builder.block("gear: f(V)", true, true, f());
            builder.block("gear: g(U)", true, true, g());
            builder.block("gear: w(V)·U", true, true, w_by_u());
            builder.block("gear: f(V)·U", true, true, f_by(&u));
            builder.block("gear: f(V)·U⁺", true, true, f_by(&drive));
        }
        let DesignBuilder { rows, columns, blocks } = builder;
        let transforms = PerGear::from_fn(|gear| {
            Mat::from_fn(rows, columns.len(), |r, c| {
                let (column, antisymmetric) = &columns[c];
                if *antisymmetric { 0.5 * gear.sign() * column[r] } else { column[r] }
            })
        });
        Self { blocks, stribeck_mps, transforms }
    }

    /// Number of coefficients.
    pub(crate) fn coefficients(&self) -> usize {
        self.transforms.forward.ncols()
    }

    /// The surfaces of both gears, forward and reverse, by the coefficients; those after the design's own are ignored.
    pub(crate) fn surfaces(&self, lattice: &Lattice, beta: &[f64]) -> PerGear<LatticeSurface> {
        let beta = &beta[..self.coefficients()];
        PerGear::from_fn(|gear| LatticeSurface { lattice: lattice.clone(), theta: self.lattice_values(gear, beta) })
    }

    /// Lattice columns × coefficients of a gear.
    pub(crate) fn transform(&self, gear: Gear) -> &Mat<f64> {
        &self.transforms[gear]
    }

    /// Coefficients on the lattice of a gear.
    pub(crate) fn lattice_values(&self, gear: Gear, beta: &[f64]) -> Vec<f64> {
        let t = self.transform(gear);
        (0..t.nrows()).map(|r| (0..t.ncols()).map(|c| t[(r, c)] * beta[c]).sum()).collect()
    }
}

/// Friction along speed in the physics form, over the lattice's coefficients: Coulomb and viscous friction, Stribeck's (extra
/// friction that fades over `stribeck_mps`), and its derivative by the logarithm of that speed, for a speed that is not exact. Models let
/// it fade as exp(−(V/v_s)²) or as 1/(1 + (V/v_s)²), whose tail is longer (Armstrong-Hélouvry, Dupont & Canudas de Wit 1994, *A survey of
/// models, analysis tools and compensation methods for the control of machines with friction*): this is the mean of both.
pub(crate) fn friction(lattice: &Lattice, stribeck_mps: f64) -> [Vec<f64>; 4] {
    let fastest = lattice.fastest_mps();
    let squared = |s: f64| (s / stribeck_mps).powi(2);
    [
        lattice.along_speed(|_| 1.0),
        lattice.along_speed(|s| s / fastest),
        lattice.along_speed(|s| 0.5 * ((-squared(s)).exp() + 1.0 / (1.0 + squared(s)))),
        lattice.along_speed(|s| squared(s) * ((-squared(s)).exp() + 1.0 / (1.0 + squared(s)).powi(2))),
    ]
}

/// A function on nodes that bends.
struct Mode {
    /// Its values, of norm one.
    shape: Vec<f64>,
    /// ‖D·z‖² as a share of an axis of length one, so that bending along one axis compares with bending along another.
    bending: f64,
}

impl Mode {
    /// The function whose penalty is the identity where `bending` counts for it.
    fn weighed(&self, bending: f64) -> Vec<f64> {
        let scale = bending.powf(-0.5 * SMOOTHNESS);
        self.shape.iter().map(|z| scale * z).collect()
    }
}

/// The modes on `nodes`, from the least to the most bent: eigenvectors of DᵀD.
fn modes(nodes: &[f64]) -> Vec<Mode> {
    let Some(d) = second_differences(nodes) else { return Vec::new() };
    let Ok(eigen) = (d.transpose() * &d).self_adjoint_eigen(faer::Side::Lower) else { return Vec::new() };
    // Σ(Δ²f)²/h³ approximates ∫f″²; the two functions that do not bend come first
    let per_length = ((nodes.len() - 1) as f64).powi(3);
    let shapes = eigen.U().col_iter().map(|shape| shape.iter().copied().collect::<Vec<f64>>());
    let bending = eigen.S().column_vector().iter().map(|value| per_length * value);
    shapes.zip(bending).skip(2).map(|(shape, bending)| Mode { shape, bending }).collect()
}

/// D, with nodes scaled to a mean spacing of one; `None` with fewer than three.
fn second_differences(nodes: &[f64]) -> Option<Mat<f64>> {
    let n = nodes.len();
    if n < 3 {
        return None;
    }
    let spacing = (nodes[n - 1] - nodes[0]) / (n - 1) as f64;
    Some(Mat::from_fn(n - 2, n, |r, c| {
        let k = r + 1;
        let (h0, h1) = ((nodes[k] - nodes[k - 1]) / spacing, (nodes[k + 1] - nodes[k]) / spacing);
        let scale = 2.0 / (h0 + h1) * (0.5 * (h0 + h1)).sqrt();
        if c + 1 == k {
            scale / h0
        } else if c == k {
            -scale * (1.0 / h0 + 1.0 / h1)
        } else if c == k + 1 {
            scale / h1
        } else {
            0.0
        }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_bend_more_and_more_and_hold_no_straight_line() {
        let nodes: [f64; 6] = [0.0, 0.1, 0.25, 0.4, 0.7, 1.0];
        let modes = modes(&nodes);
        assert_eq!(modes.len(), nodes.len() - 2);
        assert!(modes[0].bending > 0.0 && modes.windows(2).all(|m| m[1].bending > m[0].bending));
        let second = |z: &[f64]| -> f64 {
            let spacing = 0.2;
            let at = |c: usize| {
                let (h0, h1) = ((nodes[c] - nodes[c - 1]) / spacing, (nodes[c + 1] - nodes[c]) / spacing);
                2.0 / (h0 + h1) * ((z[c + 1] - z[c]) / h1 - (z[c] - z[c - 1]) / h0) * (0.5 * (h0 + h1)).sqrt()
            };
            (1..nodes.len() - 1).map(|c| at(c).powi(2)).sum::<f64>() * 125.0
        };
        for mode in &modes {
            let [level, slope]: [f64; 2] = [mode.shape.iter().sum(), mode.shape.iter().zip(nodes).map(|(z, x)| z * x).sum()];
            assert!(level.abs() < 1e-9 && slope.abs() < 1e-9);
            assert!((second(&mode.shape) / mode.bending - 1.0).abs() < 1e-6);
            // a unit coefficient bends by ρ^(1 − 1.5)
            let weighed = mode.weighed(mode.bending);
            assert!((second(&weighed) * mode.bending.sqrt() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn gears_share_their_common_part_and_differ_by_the_antisymmetric_one() {
        let lattice = Lattice::new(1.0, -20.0, 40.0, 6, 8);
        let design = Design::new(&lattice, true, STRIBECK_MPS);
        let beta = vec![1.0; design.coefficients()];
        let forward = design.lattice_values(Gear::Forward, &beta);
        let reverse = design.lattice_values(Gear::Reverse, &beta);
        let alone = Design::new(&lattice, false, STRIBECK_MPS);
        let common = alone.lattice_values(Gear::Forward, &vec![1.0; alone.coefficients()]);
        for ((f, r), c) in forward.iter().zip(&reverse).zip(&common) {
            assert!((0.5 * (f + r) - c).abs() < 1e-9);
        }
    }
}
