//! Whether a computed table is sound: enough of it measured, torque varied, and logs that agree.

use crate::check::campaign_checks::{coverage_check, torques_name};
use crate::fit::FitSettings;
use crate::fit::drive_form::torque_limit::TorqueLimit;
use crate::fit::motion::integration::Course;
use crate::fit::noise::whitening::whiten;
use crate::fit::rounds::estimate::{Estimate, RoundCount};
use crate::fit::rounds::outliers::calm;
use crate::fit::table1::prediction_checks::reach_mps2;
use crate::fit::table1::tables::UsedSample;
use crate::fit::table1::torque_gain::torque_gain;
use crate::map::{AccelMap, CellStatus, Check, CheckOutcome, Gear};
use std::collections::BTreeMap;

/// Below this effective number of torques, the dependence of acceleration on torque is a guess: one torque and coasting make about two.
const FEWEST_TORQUES: f64 = 2.5;
/// Torques nearer than this share of the largest count as one.
const SAME_TORQUE: f64 = 0.04;
/// Largest difference of two logs' accelerations under the same torque on another day, with another battery or a warm gear; more is another
/// vehicle or load.
const SAME_VEHICLE: f64 = 0.10;
/// Largest constant difference of acceleration between two logs by a floor or a slope, relative to the acceleration by the largest torque.
const SAME_FLOOR: f64 = 0.03;
/// A difference must also exceed this many standard errors.
const SIGNIFICANT: f64 = 3.5;

/// The reasons against the table, for people; none when it is sound.
pub(crate) fn objections(estimate: &Estimate, maps: &[AccelMap], samples: &[UsedSample], settings: &FitSettings) -> Vec<String> {
    checks(estimate, maps, samples, settings).iter().filter(|c| c.objects()).map(Check::text).collect()
}

/// The checks that need the estimate: coverage, torques of each gear, agreement of the logs, growth of acceleration with torque, convergence.
pub(crate) fn checks(estimate: &Estimate, maps: &[AccelMap], samples: &[UsedSample], settings: &FitSettings) -> Vec<Check> {
    let mut all = vec![coverage_check(&maps.iter().collect::<Vec<_>>(), settings.least_coverage)];
    all.extend(estimate.data.gears.iter().map(|gear| varied_torques(*gear, samples)));
    all.extend(speed_at_rest(estimate));
    all.extend(agreement(estimate));
    // a power limit is estimated; where a torque limit lies between two torques, no run shows
    let limit = estimate.calibration.drive.limit;
    let most_nm = |speed_mps: f64| if matches!(limit, TorqueLimit::Power(_)) { limit.most_nm(speed_mps) } else { f64::INFINITY };
    all.extend(maps.iter().filter_map(|map| torque_gain(map, most_nm)));
    all.push(convergence(estimate.rounds, settings));
    all
}

/// The speed at rest of the log in which it is farthest from zero.
fn speed_at_rest(estimate: &Estimate) -> Option<Check> {
    let of_logs = estimate.data.logs.iter().filter_map(|log| log.survey.speed_at_rest());
    of_logs.max_by(|a, b| a.figure.total_cmp(&b.figure))
}

/// Share of the cells that are measured.
pub(crate) fn coverage(maps: &[AccelMap]) -> f64 {
    let cells = || maps.iter().flat_map(|m| m.status.iter().flatten());
    cells().filter(|s| **s == CellStatus::Measured).count() as f64 / cells().count().max(1) as f64
}

/// The effective number of torques is 1/Σp², with p the share of the used samples at each torque (Hill's number of order two).
fn varied_torques(gear: Gear, samples: &[UsedSample]) -> Check {
    let own: Vec<f64> = samples.iter().filter(|s| s.gear == gear).map(|s| s.torque_nm).collect();
    let largest = own.iter().fold(1e-9f64, |m, u| m.max(u.abs()));
    let mut counts: BTreeMap<i64, usize> = BTreeMap::new();
    for u in &own {
        *counts.entry((u / (SAME_TORQUE * largest)).round() as i64).or_insert(0) += 1;
    }
    let squares: f64 = counts.values().map(|n| (*n as f64 / own.len() as f64).powi(2)).sum();
    let effective = if own.is_empty() { 0.0 } else { 1.0 / squares };
    let check = |meaning| Check::passed(torques_name(gear), (effective, FEWEST_TORQUES, "torques"), meaning);
    let figures = format!("effective number of torques {effective:.1}, {FEWEST_TORQUES} are needed");
    if effective >= FEWEST_TORQUES {
        return check(format!("{gear} gear: {figures}"));
    }
    if own.is_empty() {
        let meaning = format!("{gear} gear: no sample is used, so that every torque is a guess ({figures})");
        return check(meaning).broken(CheckOutcome::Objection, "look at the verdicts on the samples: most of them say why");
    }
    let mut usual: Vec<(usize, i64)> = counts.iter().map(|(level, n)| (*n, *level)).collect();
    usual.sort_unstable_by(|a, b| b.cmp(a));
    let at: Vec<String> = usual.iter().take(2).map(|(_, level)| format!("{:.0}", *level as f64 * SAME_TORQUE * largest)).collect();
    let meaning = format!(
        "torque was hardly varied: nearly all motion in {gear} gear is at {} N·m, so that other torques are not measured ({figures})",
        at.join(" and ")
    );
    let advice = format!("add runs at about {:.0} and {:.0} N·m", 0.6 * largest, 1.5 * largest);
    check(meaning).broken(CheckOutcome::Objection, advice)
}

/// Whether surface and delays converged within the iterations.
fn convergence(rounds: RoundCount, settings: &FitSettings) -> Check {
    let figure = (rounds.count as f64, settings.iterations.iter().sum::<usize>() as f64, "iterations");
    if rounds.converged {
        return Check::passed("convergence", figure, format!("the fit converged after {} iterations", rounds.count));
    }
    let meaning = format!("the fit stopped after {} iterations before the surface converged", rounds.count);
    Check::passed("convergence", figure, meaning).broken(CheckOutcome::Warning, "look at the runs that disagree, or drive more runs")
}

/// How one log's accelerations differ from the common surface: relatively, and by a constant [m/s²], each with its standard error.
struct Departure {
    scale: f64,
    scale_std_err: f64,
    offset_mps2: f64,
    offset_std_err_mps2: f64,
}

/// The two logs that differ most, against what one vehicle can differ. `None` with one log, or logs that show nothing.
fn agreement(estimate: &Estimate) -> Option<Check> {
    if estimate.data.logs.len() < 2 {
        return None;
    }
    let departures: Vec<Option<Departure>> = (0..estimate.data.logs.len()).map(|log| departure(estimate, log)).collect();
    let reach_mps2 = reach_mps2(estimate, estimate.data.gears[0]);
    let name = |k: usize| &estimate.data.logs[k].survey.track.source.file;
    let known: Vec<(usize, &Departure)> = departures.iter().enumerate().filter_map(|(k, d)| Some((k, d.as_ref()?))).collect();
    let by = |of: &dyn Fn(&Departure) -> f64| {
        let low = known.iter().min_by(|a, b| of(a.1).total_cmp(&of(b.1)))?;
        let high = known.iter().max_by(|a, b| of(a.1).total_cmp(&of(b.1)))?;
        Some((low.0, high.0, low.1, high.1))
    };
    let (low, high, a, b) = by(&|d| d.scale)?;
    let (difference, std_err) = ((b.scale - a.scale) / (1.0 + a.scale), a.scale_std_err.hypot(b.scale_std_err));
    let same_torque = format!(
        "the same torque accelerates {} {:.0} ± {:.0} % more than {}, {:.0} % is allowed",
        name(high),
        100.0 * difference,
        (100.0 * std_err).max(1.0),
        name(low),
        100.0 * SAME_VEHICLE
    );
    let check = |meaning| Check::passed("logs-agree", (100.0 * difference, 100.0 * SAME_VEHICLE, "%"), meaning);
    if difference > SAME_VEHICLE && difference > SIGNIFICANT * std_err {
        let meaning = format!("the logs contradict each other: {same_torque}");
        return Some(check(meaning).broken(CheckOutcome::Objection, "another load, vehicle or torque scale? Fit them apart"));
    }
    let (low, high, a, b) = by(&|d| d.offset_mps2)?;
    let (difference, std_err) = (b.offset_mps2 - a.offset_mps2, a.offset_std_err_mps2.hypot(b.offset_std_err_mps2));
    let limit_mps2 = SAME_FLOOR * reach_mps2;
    if difference > limit_mps2 && difference > SIGNIFICANT * std_err {
        let meaning = format!(
            "the logs contradict each other: under the same torque {} accelerates by {difference:.3} ± {std_err:.3} m/s² more than {}, {limit_mps2:.3} is allowed",
            name(high),
            name(low)
        );
        let check = Check::passed("logs-agree", (difference, limit_mps2, "m/s²"), meaning);
        return Some(check.broken(CheckOutcome::Objection, "another floor, a slope, a dragging brake? Fit them apart"));
    }
    Some(check(same_torque))
}

/// Regression of a log's whitened residuals on the surface's prediction and on a constant acceleration. The noise is bounded as for the
/// cuts: it already contains the difference between the logs, which would be taken for chance.
fn departure(estimate: &Estimate, log: usize) -> Option<Departure> {
    let lagged = estimate.data.logs[log].torque(&estimate.calibration.drive, estimate.calibration.drift);
    let noise = calm(&estimate.noise, estimate.model.surface(estimate.data.gears[0]));
    // normal equations of (prediction, time, residual)
    let mut n = [[0.0; 3]; 3];
    for (segment, speed) in estimate.data.segments.iter().zip(&estimate.paths.speeds_mps).filter(|(s, _)| s.log == log) {
        let course = Course::new(segment, &lagged, estimate.calibration.dead_time_s[log]);
        let model = course.predicted(&speed.clone().into(), estimate.model.surface(segment.gear));
        let mut rows: Vec<f64> =
            segment.readings.iter().zip(&model).flat_map(|(r, m)| [*m, r.t_s - segment.start_s, r.speed_mps - m]).collect();
        whiten(&mut rows, 3, &segment.readings, segment.start_s, &noise, segment.start_std(&noise));
        for row in rows.chunks_exact(3) {
            for (a, line) in n.iter_mut().enumerate() {
                line.iter_mut().zip(row).for_each(|(sum, b)| *sum += row[a] * b);
            }
        }
    }
    let determinant = n[0][0] * n[1][1] - n[0][1] * n[1][0];
    (determinant > 1e-9 * n[0][0] * n[1][1]).then(|| Departure {
        scale: (n[0][2] * n[1][1] - n[1][2] * n[0][1]) / determinant,
        scale_std_err: (n[1][1] / determinant).sqrt(),
        offset_mps2: (n[1][2] * n[0][0] - n[0][2] * n[1][0]) / determinant,
        offset_std_err_mps2: (n[0][0] / determinant).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(torques: &[(f64, usize)]) -> Vec<UsedSample> {
        torques
            .iter()
            .flat_map(|(torque_nm, n)| std::iter::repeat_n(UsedSample { gear: Gear::Forward, speed_mps: 0.5, torque_nm: *torque_nm }, *n))
            .collect()
    }

    #[test]
    fn one_torque_and_coasting_are_too_few_and_three_even_ones_are_enough() {
        let one = varied_torques(Gear::Forward, &at(&[(20.0, 600), (0.0, 400)]));
        assert!(one.objects() && one.text().contains("20 and 0 N·m") && one.figure < one.limit, "{one:?}");
        assert!(!varied_torques(Gear::Forward, &at(&[(20.0, 600), (0.0, 400), (35.0, 500)])).objects());
        // a torque dithered by hand has no levels at all
        let dithered: Vec<(f64, usize)> = (0..200).map(|k| (0.1 * f64::from(k), 5)).collect();
        assert!(!varied_torques(Gear::Forward, &at(&dithered)).objects());
    }
}
