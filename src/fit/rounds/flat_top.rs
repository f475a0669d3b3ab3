//! The torque limit that a surface shows by a flat top: beyond some torque, more of it accelerates hardly more.
//!
//! A smooth surface follows the accelerations at the torques that were driven. Between the last torque that is delivered and the first
//! that is not, it rounds the corner off. With the growth below, the flat part gives the corner: u_max = u₀ + (A(u_top) − A(u₀))/g.

use crate::fit::rounds::state::State;
use crate::fit::surface::lattice::LatticeSurface;
use crate::signal::median;

/// Parts of the largest torque between which growth is compared.
const PARTS: [f64; 5] = [0.2, 0.4, 0.6, 0.8, 1.0];
/// Speeds at which accelerations are compared, as shares of the fastest.
const AT_SPEEDS: [f64; 4] = [0.1, 0.2, 0.35, 0.5];
/// The top is flat below this share of the usual growth, and a part of full growth ends below it from this share on.
const FLAT: f64 = 0.5;
const FULL: f64 = 0.85;
/// A limit within this share of the largest torque is none.
const NO_LIMIT: f64 = 0.97;

/// The limit [N·m]; `None` for a surface without a flat top.
pub(crate) fn limit_nm(state: &State) -> Option<f64> {
    let limits: Vec<f64> = state.gears.iter().filter_map(|gear| of_surface(&state.surfaces[*gear])).collect();
    (!limits.is_empty()).then(|| median(&limits))
}

fn of_surface(surface: &LatticeSurface) -> Option<f64> {
    let largest_nm = surface.lattice.torque_nm.last().copied()?;
    let mean_mps2 = |torque_nm: f64| {
        AT_SPEEDS.iter().map(|share| surface.accel_mps2(share * surface.lattice.fastest_mps(), torque_nm)).sum::<f64>()
            / AT_SPEEDS.len() as f64
    };
    of_curve(&PARTS.map(|part| part * largest_nm), mean_mps2)
}

/// The limit of a curve, acceleration over torque, by its growth between the given torques.
fn of_curve(torques_nm: &[f64], accel_mps2: impl Fn(f64) -> f64) -> Option<f64> {
    let growth: Vec<f64> = torques_nm.windows(2).map(|u| (accel_mps2(u[1]) - accel_mps2(u[0])) / (u[1] - u[0])).collect();
    let usual = growth.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if usual <= 0.0 || growth[growth.len() - 1] > FLAT * usual {
        return None;
    }
    // the last part of full growth ends below the corner
    let last = growth.iter().rposition(|g| *g > FULL * usual)?;
    let (below_nm, top_nm) = (torques_nm[last + 1], torques_nm[torques_nm.len() - 1]);
    let limit_nm = below_nm + (accel_mps2(top_nm) - accel_mps2(below_nm)) / usual;
    (limit_nm < NO_LIMIT * top_nm).then_some(limit_nm)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_corner_of_a_flat_top_is_found_and_a_bent_curve_has_none() {
        let torques = PARTS.map(|part| 45.0 * part);
        for limit in [26.0, 34.0, 37.0] {
            let found = of_curve(&torques, |u: f64| (u.min(limit) - 8.0) / 13.0).unwrap();
            assert!((found - limit).abs() < 0.5, "{found} for {limit}");
        }
        assert_eq!(of_curve(&torques, |u| u / 13.0), None);
        // a motor that loses a third of its torque at the top
        assert_eq!(of_curve(&torques, |u| (u - 0.25 * u * u / 45.0) / 13.0), None);
        assert_eq!(of_curve(&torques, |u| -u), None);
    }
}
