//! The laws that are run: the map under test, and the laws that it is compared with.

use crate::control::{ConstantGain, HeadingLaw, HeadingLawSettings, SpeedLoopSettings, WaypointLawSettings};
use crate::map::CellStatus;
use crate::sim;
use crate::verify::bench::PivotBench;
use crate::verify::metric::{Metric, Values};
use crate::verify::run::run;
use crate::verify::scenario::Scenario;
use crate::verify::{Maps, Result};
use rayon::prelude::*;

/// The gain that a user without a map would choose: the least-squares τ = k·a through the origin over the measured cells of Table 1 that
/// accelerate.
pub(crate) fn constant_gain(maps: &Maps, limit_nm: f64) -> ConstantGain {
    let (mut torque_accel, mut accel_accel) = (0.0, 0.0);
    for map in &maps.table1.maps {
        for (i, &torque_nm) in map.torque_nm.iter().enumerate() {
            for (j, &accel) in map.accel_mps2[i].iter().enumerate() {
                if map.status[i][j] == CellStatus::Measured && accel > 0.0 {
                    torque_accel += torque_nm * accel;
                    accel_accel += accel * accel;
                }
            }
        }
    }
    let gain_nm_per_mps2 = if accel_accel > 0.0 { torque_accel / accel_accel } else { limit_nm };
    ConstantGain { gain_nm_per_mps2, limit_nm }
}

/// Heading gains Kp [m/s per rad], Ki, Kd, and speed-loop gains Kp [1/s], Ki [1/s²] of the search.
const SEARCH: [&[f64]; 5] = [&[0.6, 0.9, 1.3, 1.8, 2.5], &[0.0, 0.2], &[0.0, 0.3], &[2.0, 4.0, 8.0], &[0.5, 2.0, 6.0]];

/// Largest heading error and overshoot that tuned gains may have [°]: 1.5 each, a little more than the end threshold of the map's law.
const TUNED_ERROR_DEG: f64 = 1.5;

/// Seeds of sensor noise for each finalist, so that gains that succeed once by chance are not chosen.
const TUNING_SEEDS: u64 = 4;

/// Number of candidates that are also run with the other seeds.
const TUNING_FINALISTS: usize = 30;

/// Number of combinations of gains.
fn candidates() -> usize {
    SEARCH.iter().map(|gains| gains.len()).product()
}

/// Number of runs of the search.
pub(crate) fn tuning_runs() -> usize {
    candidates() + TUNING_FINALISTS.min(candidates()) * (TUNING_SEEDS as usize - 1)
}

/// The conventional law with the gains of shortest settling time: every combination of `SEARCH` drives `scenario` once on the nominal plant,
/// the best [`TUNING_FINALISTS`] with [`TUNING_SEEDS`] seeds. Of those that always end within [`TUNED_ERROR_DEG`], the one whose
/// slowest turn is fastest is used. If none does, the one with the smallest heading error is used.
pub(crate) fn tuned_heading_law(
    bench: &PivotBench<'_>,
    scenario: &Scenario,
    plant: &sim::WorldSettings,
    settings: &WaypointLawSettings,
    torque: ConstantGain,
    done: &(dyn Fn() + Sync),
) -> Result<HeadingLawSettings> {
    let count = candidates();
    let gains = |mut k: usize| {
        SEARCH.map(|values| {
            let value = values[k % values.len()];
            k /= values.len();
            value
        })
    };
    let candidate = |k: usize| {
        let [heading_proportional, heading_integral, heading_derivative, proportional_per_s, integral_per_s2] = gains(k);
        HeadingLawSettings {
            period_s: settings.period_s,
            heading_proportional,
            heading_integral,
            heading_derivative,
            max_speed_mps: bench.control.planning.profile.cruise_mps,
            speed_loop: SpeedLoopSettings { proportional_per_s, integral_per_s2, ..settings.speed_loop },
            standstill_mps: settings.standstill_mps,
            end_threshold_rad: settings.end_threshold_m / bench.control.planning.wheelbase_m,
            torque,
        }
    };
    let score = |values: &Values| {
        let error = values.get(Metric::HeadingErrorDeg).unwrap_or(f64::INFINITY);
        let overshoot = values.get(Metric::OvershootDeg).unwrap_or(f64::INFINITY);
        let ended = values.get(Metric::AsExpected) == Some(1.0);
        let good = ended && error <= TUNED_ERROR_DEG && overshoot <= TUNED_ERROR_DEG;
        // every good end takes at most some tens of seconds and ranks before every bad one
        if good { values.get(Metric::SettlingTimeS).unwrap_or(1e3) } else { 1e6 * (1.0 + error) }
    };
    let drive = |k: usize, seed: u64| {
        let values = run(bench, scenario, plant, HeadingLaw::new(candidate(k)), seed, ());
        done();
        Ok(score(&values?.values))
    };
    let first: Result<Vec<f64>> = (0..count).into_par_iter().map(|k| drive(k, 0)).collect();
    let first = first?;
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| first[a].total_cmp(&first[b]).then(a.cmp(&b)));
    order.truncate(TUNING_FINALISTS);
    let worst: Result<Vec<f64>> =
        order.par_iter().map(|&k| (1..TUNING_SEEDS).try_fold(first[k], |worst: f64, seed| Ok(worst.max(drive(k, seed)?)))).collect();
    let worst = worst?;
    let best = (0..order.len()).min_by(|&a, &b| worst[a].total_cmp(&worst[b])).map_or(0, |place| order[place]);
    Ok(candidate(best))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Vehicle;
    use crate::verify::reference_maps::known_maps;

    fn maps() -> Maps {
        let vehicle = Vehicle {
            wheelbase_m: 0.92,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        };
        let (table1, table2) = known_maps(&sim::WorldSettings::physical(vehicle, sim::PhysicalSettings::default())).unwrap();
        Maps::new(table1, table2).unwrap()
    }

    #[test]
    fn the_constant_gain_is_the_least_squares_line_through_the_accelerating_cells() {
        let mut maps = maps();
        for map in &mut maps.table1.maps {
            for (i, torque_nm) in map.torque_nm.iter().enumerate() {
                for j in 0..map.speed_mps.len() {
                    map.accel_mps2[i][j] = torque_nm / 20.0;
                    // neither braking cells nor cells that were not measured count
                    if j % 3 == 0 {
                        (map.accel_mps2[i][j], map.status[i][j]) = (5.0, CellStatus::Extrapolated);
                    }
                }
            }
        }
        assert!((constant_gain(&maps, 44.0).gain_nm_per_mps2 - 20.0).abs() < 1e-9);
        for map in &mut maps.table1.maps {
            map.accel_mps2.iter_mut().flatten().for_each(|a| *a = -1.0);
        }
        assert_eq!(constant_gain(&maps, 44.0).gain_nm_per_mps2, 44.0, "without a cell that accelerates the limit stands in");
    }

    #[test]
    fn the_search_takes_as_many_runs_as_it_says() {
        let (maps, runs) = (maps(), std::sync::atomic::AtomicUsize::new(0));
        let settings = crate::verify::VerifySettings::new().unwrap();
        let done = || {
            runs.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        };
        let stage = crate::verify::stage::PivotStage::new(&maps, &settings, &done).unwrap();
        let scenario = Scenario::all().into_iter().find(|s| s.name == "left-30").unwrap();
        tuned_heading_law(&stage.bench(), &scenario, &stage.plant, &stage.law, constant_gain(&maps, 44.0), stage.done).unwrap();
        assert_eq!(runs.into_inner(), tuning_runs());
    }
}
