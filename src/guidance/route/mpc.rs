//! MPC: the wheel angles of the next 1.5 s that track best, with the steering's lag and limits in the model; the first one is commanded.
//!
//! Linear time-varying model about the path, T seconds a step, h = v·T:
//!
//! ```text
//! e⁺ = e + h ψ,   ψ⁺ = ψ + h (δ − δ_r)/(L cos²δ_r),   δ⁺ = δ + g (u − δ),   δ_r = atan(L κ_r) of the path at that step
//! min Σ q_e e² + q_ψ ψ² + r (u − δ_r)² + r_Δ (u − u₋)²   over |u| ≤ δ_max
//! ```
//!
//! The states are eliminated (condensed form). The rest is a strictly convex quadratic program with bounds, solved by the accelerated
//! projected gradient method with restart. Sources: Kühne, Lages & Gomes da Silva (2004), *Model predictive control of a mobile robot using
//! linearization* (the model); Beck & Teboulle (2009), *A Fast Iterative Shrinkage-Thresholding Algorithm*, SIAM J. Imaging Sci. 2(1), and
//! O'Donoghue & Candès (2015), *Adaptive Restart for Accelerated Gradient Schemes*, Found. Comput. Math. 15 (the method).

use crate::control::numeric::{atan, sin_cos, sqrt};
use crate::guidance::route::track::{Law, TrackState};
use serde::Serialize;

/// Steps of the horizon.
pub(crate) const HORIZON: usize = 15;

/// Its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct MpcSettings {
    /// Length of a step T [s]. Default 0.1.
    pub step_s: f64,
    /// Share g of the distance to its target that the wheel covers in a step. Default 0.56: lag and delay of 0.12 s together.
    pub steering_share: f64,
    /// Weight q_e [1/m²]. Default 6.
    pub offset_weight: f64,
    /// Weight q_ψ. Default 2.
    pub heading_weight: f64,
    /// Weight r. Default 0.2.
    pub angle_weight: f64,
    /// Weight r_Δ. Default 2: the wheel does not follow the noise of the pose.
    pub change_weight: f64,
    /// Lowest speed of the model [m/s]: below it the horizon's distance would vanish. Default 0.3.
    pub min_speed_mps: f64,
}

impl Default for MpcSettings {
    fn default() -> Self {
        Self {
            step_s: 0.1,
            steering_share: 0.56,
            offset_weight: 6.0,
            heading_weight: 2.0,
            angle_weight: 0.2,
            change_weight: 2.0,
            min_speed_mps: 0.3,
        }
    }
}

/// A quadratic program `min ½ uᵀH u + fᵀu` over |u| ≤ bound.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct QuadraticProgram {
    pub(crate) h: [[f64; HORIZON]; HORIZON],
    pub(crate) f: [f64; HORIZON],
    pub(crate) bound: f64,
}

/// Most iterations; from a warm start some 30 suffice for 1e-6 rad.
const ITERATIONS: usize = 200;
/// The iteration ends when no angle moves by more than this [rad].
const TOLERANCE_RAD: f64 = 1e-7;

impl QuadraticProgram {
    /// The minimiser, from a first guess.
    pub(crate) fn solve(&self, guess: [f64; HORIZON]) -> [f64; HORIZON] {
        // largest eigenvalue bounded by Gershgorin's circles
        let largest = self.h.iter().map(|row| row.iter().map(|v| v.abs()).sum::<f64>()).fold(f64::MIN_POSITIVE, f64::max);
        let (mut u, mut ahead, mut t) = (guess, guess, 1.0);
        for _ in 0..ITERATIONS {
            let (mut next, mut moved, mut against) = (u, 0.0_f64, 0.0);
            for i in 0..HORIZON {
                let gradient = self.f[i] + (0..HORIZON).map(|j| self.h[i][j] * ahead[j]).sum::<f64>();
                next[i] = (ahead[i] - gradient / largest).max(-self.bound).min(self.bound);
                moved = moved.max((next[i] - u[i]).abs());
                against += gradient * (next[i] - u[i]);
            }
            // the momentum points uphill: restart
            let grown = if against > 0.0 { 1.0 } else { 0.5 * (1.0 + sqrt(1.0 + 4.0 * t * t)) };
            let carry = if against > 0.0 { 0.0 } else { (t - 1.0) / grown };
            for i in 0..HORIZON {
                ahead[i] = next[i] + carry * (next[i] - u[i]);
            }
            (u, t) = (next, grown);
            if moved < TOLERANCE_RAD {
                break;
            }
        }
        u
    }
}

/// The law with its state: the last plan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mpc {
    settings: MpcSettings,
    plan: Option<[f64; HORIZON]>,
}

impl Mpc {
    pub(crate) fn new(settings: &MpcSettings) -> Self {
        Self { settings: *settings, plan: None }
    }
}

impl Law for Mpc {
    fn wheel_angle_rad(&mut self, track: &TrackState<'_>) -> f64 {
        let last = self.plan.map_or(track.wheel_angle_rad, |plan| plan[0]);
        let program = program(&self.settings, track, last);
        let plan = program.solve(self.plan.unwrap_or([last; HORIZON]));
        self.plan = Some(plan);
        plan[0]
    }

    fn forget(&mut self) {
        self.plan = None;
    }
}

/// The program of this period; `last` is the previous commanded angle [rad].
pub(crate) fn program(settings: &MpcSettings, track: &TrackState<'_>, last: f64) -> QuadraticProgram {
    let way_m = track.speed_mps.max(settings.min_speed_mps) * settings.step_s;
    let mut reference = [0.0; HORIZON];
    let mut yaw_gain = [0.0; HORIZON];
    for k in 0..HORIZON {
        let curvature = track.leg.at(track.matched.s_m + (k as f64 + 0.5) * way_m, track.index).curvature_per_m;
        reference[k] = atan(track.wheelbase_m * curvature);
        let cos = sin_cos(reference[k]).1;
        yaw_gain[k] = way_m / (track.wheelbase_m * cos * cos);
    }
    // (e, ψ) over the horizon for angles u from a state: the free response, and the response to one step alone
    let respond = |mut e: f64, mut psi: f64, mut delta: f64, free: bool, input: usize| {
        let mut out = [[0.0; 2]; HORIZON];
        for k in 0..HORIZON {
            e += way_m * psi;
            psi += yaw_gain[k] * (delta - if free { reference[k] } else { 0.0 });
            let u = if !free && k == input { 1.0 } else { 0.0 };
            delta += settings.steering_share * (u - delta);
            out[k] = [e, psi];
        }
        out
    };
    let free = respond(track.offset.lateral_m, track.offset.heading_rad, track.wheel_angle_rad, true, 0);
    let mut single = [[[0.0; 2]; HORIZON]; HORIZON];
    for (input, response) in single.iter_mut().enumerate() {
        *response = respond(0.0, 0.0, 0.0, false, input);
    }
    let mut program = QuadraticProgram { h: [[0.0; HORIZON]; HORIZON], f: [0.0; HORIZON], bound: track.max_wheel_rad };
    for i in 0..HORIZON {
        for k in i..HORIZON {
            let weights = [settings.offset_weight, settings.heading_weight];
            for (state, weight) in weights.into_iter().enumerate() {
                program.f[i] += weight * single[i][k][state] * free[k][state];
                for j in 0..=k {
                    program.h[i][j] += weight * single[i][k][state] * single[j][k][state];
                }
            }
        }
        program.h[i][i] += settings.angle_weight + settings.change_weight;
        program.f[i] -= settings.angle_weight * reference[i];
        if i + 1 < HORIZON {
            program.h[i][i] += settings.change_weight;
            program.h[i][i + 1] -= settings.change_weight;
            program.h[i + 1][i] -= settings.change_weight;
        }
    }
    program.f[0] -= settings.change_weight * last;
    program
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::control::Pose;
    use crate::guidance::path::PathPose;
    use crate::guidance::route::path_position::Leg;
    use crate::guidance::route::track::Limits;
    use crate::map::Gear;
    use clarabel::algebra::CscMatrix;
    use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};

    /// The same program by an interior-point solver.
    fn by_clarabel(program: &QuadraticProgram) -> Vec<f64> {
        let n = HORIZON;
        let upper: Vec<(usize, usize)> = (0..n).flat_map(|j| (0..=j).map(move |i| (i, j))).collect();
        let p = CscMatrix::new_from_triplets(
            n,
            n,
            upper.iter().map(|u| u.0).collect(),
            upper.iter().map(|u| u.1).collect(),
            upper.iter().map(|&(i, j)| program.h[i][j]).collect(),
        );
        let a = CscMatrix::new_from_triplets(
            2 * n,
            n,
            (0..2 * n).collect(),
            (0..2 * n).map(|k| k % n).collect(),
            (0..2 * n).map(|k| if k < n { 1.0 } else { -1.0 }).collect(),
        );
        let settings =
            DefaultSettings { verbose: false, tol_gap_abs: 1e-12, tol_gap_rel: 1e-12, tol_feas: 1e-12, ..DefaultSettings::default() };
        let cones = [SupportedConeT::NonnegativeConeT(2 * n)];
        let mut solver = DefaultSolver::new(&p, &program.f, &a, &vec![program.bound; 2 * n], &cones, settings).unwrap();
        solver.solve();
        solver.solution.x
    }

    #[test]
    fn the_plan_is_that_of_an_interior_point_solver() {
        let pose = |x_m: f64| PathPose {
            x_m,
            y_m: 0.0,
            heading_rad: 0.0,
            curvature_per_m: 0.0,
            wheel_angle_rad: 0.0,
            direction: Gear::Forward,
            s_m: x_m,
        };
        let poses = [pose(0.0), pose(10.0)];
        let leg = Leg::first(&poses).unwrap();
        // beside the line: bounds idle for the small offset, active for the large one
        for (y_m, bound) in [(0.05, 1.2), (-0.4, 0.3), (1.5, 0.2)] {
            let limits = Limits { max_wheel_rad: bound, ..Limits::new(0.9) };
            let track = TrackState::new(leg, Pose { x_m: 2.0, y_m, heading_rad: 0.1 }, 0, 0.8, 0.05, &limits);
            let program = program(&MpcSettings::default(), &track, 0.05);
            let (ours, theirs) = (program.solve([0.0; HORIZON]), by_clarabel(&program));
            for (a, b) in ours.iter().zip(&theirs) {
                assert!((a - b).abs() < 1e-5, "{y_m}: {ours:?}\n{theirs:?}");
            }
        }
    }
}
