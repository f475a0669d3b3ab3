//! The torque limit that a surface shows by a flat top: beyond some torque, more of it accelerates hardly more.
//!
//! A smooth surface follows the accelerations at the torques that were driven. Between the last torque that is delivered and the first
//! that is not, it rounds the corner off. With the growth below, the flat part gives the corner: u_max = u₀ + (A(u_top) − A(u₀))/g.

use crate::fit::motion::log_data::LogData;
use crate::fit::rounds::state::State;
use crate::map::Gear;
use crate::signal::median;

/// Torques nearer than this share of the largest count as one.
const SAME_TORQUE: f64 = 0.06;
/// Growth is compared from this share of the largest torque on.
const LEAST: f64 = 0.15;
/// Speeds at which accelerations are compared, as shares of the fastest.
const AT_SPEEDS: [f64; 4] = [0.1, 0.2, 0.35, 0.5];
/// The top is flat below this share of the largest growth, and growth is full from this share on.
const FLAT: f64 = 0.5;
const FULL: f64 = 0.8;
/// A limit within this share of the largest torque is none.
const NO_LIMIT: f64 = 0.97;

/// The limit [N·m]; `None` for a surface without a flat top.
pub(crate) fn limit_nm(state: &State) -> Option<f64> {
    let of_gear = |gear: &Gear| {
        let surface = &state.surfaces[*gear];
        let at_speeds = AT_SPEEDS.map(|share| share * surface.lattice.fastest_mps());
        let mean_mps2 = |torque_nm: f64| at_speeds.iter().map(|v| surface.accel_mps2(*v, torque_nm)).sum::<f64>() / at_speeds.len() as f64;
        of_curve(&levels_nm(&state.logs, *gear), mean_mps2)
    };
    let limits: Vec<f64> = state.gears.iter().filter_map(of_gear).collect();
    (!limits.is_empty()).then(|| median(&limits))
}

/// The driving torques at which a gear's runs were held, rising [N·m]: there, a smooth surface is right.
fn levels_nm(logs: &[LogData], gear: Gear) -> Vec<f64> {
    let mut levels: Vec<f64> = logs.iter().flat_map(|log| log.survey.held_torques_nm(gear)).collect();
    levels.sort_unstable_by(f64::total_cmp);
    let largest_nm = levels.last().copied().unwrap_or(0.0);
    levels.retain(|u| *u > LEAST * largest_nm);
    levels.dedup_by(|b, a| *b - *a < SAME_TORQUE * largest_nm);
    levels
}

/// The limit of a curve, acceleration over torque, by its growth between the given torques.
fn of_curve(torques_nm: &[f64], accel_mps2: impl Fn(f64) -> f64) -> Option<f64> {
    let growth: Vec<f64> = torques_nm.windows(2).map(|u| (accel_mps2(u[1]) - accel_mps2(u[0])) / (u[1] - u[0])).collect();
    let largest = growth.iter().copied().fold(0.0, f64::max);
    if *growth.last()? > FLAT * largest || largest <= 0.0 {
        return None;
    }
    // the last interval of full growth ends below the corner, which a smooth surface rounds off up to there: those before it give the growth
    let last = growth.iter().rposition(|g| *g > FULL * largest)?.max(1);
    let (first_nm, below_nm, top_nm) = (torques_nm[0], torques_nm[last], torques_nm[torques_nm.len() - 1]);
    let usual = (accel_mps2(below_nm) - accel_mps2(first_nm)) / (below_nm - first_nm);
    let limit_nm = below_nm + (accel_mps2(top_nm) - accel_mps2(below_nm)).max(0.0) / usual;
    (limit_nm < NO_LIMIT * top_nm).then_some(limit_nm)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_corner_of_a_flat_top_is_found_and_a_bent_curve_has_none() {
        let torques = [12.0, 18.0, 24.0, 32.0, 37.4, 45.9];
        for limit in [26.0, 34.0, 36.0] {
            let found = of_curve(&torques, |u: f64| (u.min(limit) - 8.0) / 13.0).unwrap();
            assert!((found - limit).abs() < 1e-9, "{found} for {limit}");
        }
        assert_eq!(of_curve(&torques, |u| u / 13.0), None);
        // a motor that loses a third of its torque at the top
        assert_eq!(of_curve(&torques, |u| (u - 0.25 * u * u / 45.0) / 13.0), None);
        assert_eq!(of_curve(&torques, |u| -u), None);
        assert_eq!(of_curve(&torques[..1], |u| u), None);
    }
}
