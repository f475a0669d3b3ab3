//! Whether equal steps of torque give equal steps of acceleration.
//!
//! Between two torques that were driven, a map follows a line. A drive that gives nothing up to some torque (a dead band), or no more from
//! one on (a limit, saturation), has a corner between them that no run shows. The corner leaves a trace: acceleration grows more slowly
//! there than between the other torques. A wheel on a floor gives the same everywhere, but for the efficiency of its gear.

use crate::map::{AccelMap, CellStatus, Check, CheckOutcome};

/// Part of the usual growth that is missing, for a warning and for an objection. The efficiency of a gear, which brakes better than it
/// drives, takes up to 0.2.
const MISSING: [f64; 2] = [0.25, 0.4];
/// A difference counts from this many of its standard errors on.
const SIGNIFICANT: f64 = 4.0;
/// Least distance of two torques, as a share of the largest.
const LEAST_DISTANCE: f64 = 0.06;
/// Slower than this, friction depends on the torque [m/s].
const SLOWEST_MPS: f64 = 0.1;
/// Fewest speeds at which two torques are compared.
const FEWEST_SPEEDS: usize = 3;
/// Fewest intervals that show what is usual.
const FEWEST_INTERVALS: usize = 4;

/// The growth of acceleration between two torques.
struct Growth {
    low_nm: f64,
    high_nm: f64,
    /// Acceleration per torque [m/s² per N·m], and its standard error.
    slope: f64,
    std_err: f64,
}

/// The check of one gear, for torques that the drive delivers: at most `most_nm` at a speed. `None` where too few torques were driven at the
/// same speeds.
pub(crate) fn torque_gain(map: &AccelMap, most_nm: impl Fn(f64) -> f64) -> Option<Check> {
    let growths = growths(map, most_nm);
    if growths.len() < FEWEST_INTERVALS {
        return None;
    }
    let usual = weighted_median(&growths);
    let missing = |g: &Growth| 1.0 - g.slope / usual;
    let counts = |g: &&Growth| (usual - g.slope) > SIGNIFICANT * g.std_err;
    let clear = growths.iter().filter(counts).max_by(|a, b| missing(a).total_cmp(&missing(b)));
    let share = clear.map_or(0.0, missing);
    let (outcome, limit) = CheckOutcome::graded(share, MISSING);
    let meaning = match clear {
        Some(g) => format!(
            "in {} gear, acceleration grows by {:.0} % less between {:.1} and {:.1} N·m than between other torques, {:.0} % less is allowed",
            map.gear,
            100.0 * share,
            g.low_nm,
            g.high_nm,
            100.0 * limit
        ),
        None => format!("in {} gear, acceleration grows alike between all torques", map.gear),
    };
    let check = Check::passed(format!("torque-gain-{}", map.gear), (100.0 * share, 100.0 * limit, "%"), meaning);
    Some(check.judged(
        outcome,
        "the drive has a dead band, a limit or saturation there: drive torques between these two, or plan outside of them",
    ))
}

/// The growth between neighbouring torques at the speeds where both were measured.
fn growths(map: &AccelMap, most_nm: impl Fn(f64) -> f64) -> Vec<Growth> {
    let torques = &map.torque_nm;
    let largest_nm = torques.iter().fold(0.0f64, |m, u| m.max(u.abs()));
    let is_measured = |i: usize, j: usize| {
        let speed_mps = map.speed_mps[j];
        map.status[i][j] == CellStatus::Measured && speed_mps >= SLOWEST_MPS && torques[i] <= most_nm(speed_mps)
    };
    let mut all = Vec::new();
    for low in 0..torques.len() {
        let Some(high) = (low + 1..torques.len()).find(|i| torques[*i] - torques[low] >= LEAST_DISTANCE * largest_nm) else { break };
        let both: Vec<usize> = (0..map.speed_mps.len()).filter(|j| is_measured(low, *j) && is_measured(high, *j)).collect();
        if both.len() < FEWEST_SPEEDS {
            continue;
        }
        let distance_nm = torques[high] - torques[low];
        let mean = |of: &dyn Fn(usize) -> f64| both.iter().map(|j| of(*j)).sum::<f64>() / both.len() as f64 / distance_nm;
        all.push(Growth {
            // no minus zero
            low_nm: torques[low] + 0.0,
            high_nm: torques[high] + 0.0,
            slope: mean(&|j| map.accel_mps2[high][j] - map.accel_mps2[low][j]),
            // the errors at different speeds go together
            std_err: mean(&|j| map.std_err_mps2[high][j].hypot(map.std_err_mps2[low][j])),
        });
    }
    all
}

/// The slope that half of the range of torques has at least.
fn weighted_median(growths: &[Growth]) -> f64 {
    let mut sorted: Vec<(f64, f64)> = growths.iter().map(|g| (g.slope, g.high_nm - g.low_nm)).collect();
    sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = sorted.iter().map(|g| g.1).sum();
    let mut so_far = 0.0;
    let reaches = |(_, width): &&(f64, f64)| {
        so_far += width;
        so_far >= 0.5 * whole
    };
    sorted.iter().find(reaches).map_or(0.0, |g| g.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Table1File;

    /// The demo's map with torques of our own through a drive, 1/13 m/s² per N·m.
    fn driven(torques: &[f64], delivered: impl Fn(f64) -> f64) -> AccelMap {
        let mut map = Table1File::from_json(include_str!("../../../maps/table1.json")).unwrap().maps.remove(0);
        let (rows, columns) = (torques.len(), map.speed_mps.len());
        map.torque_nm = torques.to_vec();
        map.accel_mps2 = torques.iter().map(|u| map.speed_mps.iter().map(|v| (delivered(*u) - 4.0 - 5.0 * v) / 13.0).collect()).collect();
        map.std_err_mps2 = vec![vec![0.004; columns]; rows];
        map.status = vec![vec![CellStatus::Measured; columns]; rows];
        map
    }

    #[test]
    fn corners_of_the_drive_are_named_and_an_efficiency_is_none() {
        let torques = [-20.0, -12.0, 0.0, 12.0, 20.0, 28.0, 36.0, 44.0];
        let outcome = |delivered: &dyn Fn(f64) -> f64| torque_gain(&driven(&torques, delivered), |_| f64::INFINITY).unwrap();
        assert_eq!(outcome(&|u| u).outcome, CheckOutcome::Passed);
        assert_eq!(outcome(&|u| if u > 0.0 { 0.86 * u } else { 1.03 * u }).outcome, CheckOutcome::Passed);
        let dead_band = outcome(&|u| (u.abs() - 6.0).max(0.0).copysign(u));
        assert!(dead_band.objects() && dead_band.meaning.contains("50 % less between 0.0 and 12.0 N·m"), "{}", dead_band.meaning);
        let limited = outcome(&|u| u.min(36.0));
        assert!(limited.objects() && limited.meaning.contains("100 % less between 36.0 and 44.0 N·m"), "{}", limited.meaning);
        assert_eq!(outcome(&|u| if u > 36.0 { 36.0 + 0.65 * (u - 36.0) } else { u }).outcome, CheckOutcome::Warning);
    }

    #[test]
    fn few_torques_or_large_errors_show_nothing() {
        assert!(torque_gain(&driven(&[0.0, 12.0, 24.0, 36.0], |u| u.min(24.0)), |_| f64::INFINITY).is_none());
        let mut unsure = driven(&[-20.0, -12.0, 0.0, 12.0, 20.0, 28.0, 36.0, 44.0], |u| u.min(36.0));
        unsure.std_err_mps2.iter_mut().flatten().for_each(|e| *e = 0.3);
        assert_eq!(torque_gain(&unsure, |_| f64::INFINITY).unwrap().outcome, CheckOutcome::Passed);
        // a limit that the fit has found is no corner that it has missed
        let found = torque_gain(&driven(&[-20.0, -12.0, 0.0, 12.0, 20.0, 28.0, 36.0, 44.0], |u| u.min(34.0)), |_| 34.0);
        assert_eq!(found.unwrap().outcome, CheckOutcome::Passed);
    }
}
