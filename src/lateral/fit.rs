//! Makes the compensation table from runs: differences to the base, standard errors, dropped entries, the monotone curve.

use crate::lateral::bins::{Bin, CompensationRun};
use crate::lateral::isotonic::isotonic;
use crate::lateral::newey_west::{Mean, newey_west};
use crate::lateral::settings::{LateralFitSettings, Weighting};
use crate::lateral::{Error, Result};
use crate::log::Recording;
use crate::map::{
    CsvRef, FORMAT_VERSION, LATERAL_TABLE_FORMAT, LateralCurve, LateralEntry, LateralMean, LateralTableFile, LogRef, sha256_hex,
};
use serde::Serialize;

/// Report of the fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct LateralReport {
    /// Number of pieces of the path per entry, in the order of the entries.
    pub pieces: Vec<usize>,
    /// Slope of the curve between its ends [rad/m].
    pub slope_rad_per_m: f64,
    /// Largest correction to make the entries monotone, in standard errors.
    pub largest_correction: f64,
}

/// Largest number of angles with the base: the size of the run-time law's table.
const MOST: usize = 32;
/// An angle up to this counts as zero [rad].
const NO_ANGLE_RAD: f64 = 1e-6;
/// Smallest standard error used for weights in the fit [m]: entries without noise would otherwise have infinite weight.
const LEAST_STD_ERR_M: f64 = 1e-6;

/// Makes the table.
///
/// # Errors
/// There is no base or more than one, logs are of another task or too short, the compensation changes within a log, or no entry is left.
pub(crate) fn fit(recordings: &[Recording], settings: &LateralFitSettings) -> Result<(LateralTableFile, LateralReport)> {
    for (field, value, low, high) in [
        ("threshold_m", settings.threshold_m, 1e-4, 10.0),
        ("piece_m", settings.piece_m, 0.1, 10.0),
        ("settle_m", settings.settle_m, 0.0, 100.0),
    ] {
        if !(low..=high).contains(&value) {
            let allowed = if field == "threshold_m" { "0.0001 to 10" } else { "0.1 to 10 (a piece), 0 to 100 (settling)" };
            return Err(Error::Setting { field, value, allowed });
        }
    }
    let mut runs = recordings.iter().map(|r| Ok((CompensationRun::new(r, settings)?, &r.source))).collect::<Result<Vec<_>>>()?;
    // the order of the logs must not change the result
    runs.sort_by(|a, b| a.0.angle_rad.total_cmp(&b.0.angle_rad).then_with(|| a.1.sha256.cmp(&b.1.sha256)));
    let mut bases = runs.iter().filter(|(run, _)| run.angle_rad.abs() <= NO_ANGLE_RAD);
    let Some((base, base_source)) = bases.next() else { return Err(Error::NoBase { found: runs.len() }) };
    if let Some((second, _)) = bases.next() {
        return Err(Error::TwoBases { first: base.log.clone(), second: second.log.clone() });
    }
    if runs.len() > MOST {
        return Err(Error::TooMany { found: runs.len(), most: MOST });
    }
    let base_mean = alone(base, settings)?;
    let zero =
        LateralEntry { angle_rad: 0.0, error_m: 0.0, std_err_m: 0.0, way_m: base_mean.way_m, log: base.log.clone(), reason: String::new() };
    let (mut entries, mut dropped) = (vec![zero], Vec::new());
    for (run, _) in runs.iter().filter(|(run, _)| run.angle_rad.abs() > NO_ANGLE_RAD) {
        let mut entry = against(run, base, settings)?;
        if entry.error_m.abs() >= settings.threshold_m {
            entry.reason = format!("at or beyond the threshold of {} m", settings.threshold_m);
            dropped.push(entry);
        } else {
            entries.push(entry);
        }
    }
    if entries.len() < 2 {
        return Err(Error::NothingLeft { left: entries.len() - 1, all: runs.len() - 1, threshold_m: settings.threshold_m });
    }
    let (curve, largest_correction) = curve(&entries)?;
    entries.sort_by(|a, b| a.error_m.total_cmp(&b.error_m).then(a.angle_rad.total_cmp(&b.angle_rad)));
    let last = curve.error_m.len() - 1;
    let report = LateralReport {
        pieces: entries.iter().map(|e| (e.way_m / settings.piece_m).round() as usize).collect(),
        slope_rad_per_m: (curve.angle_rad[last] - curve.angle_rad[0]) / (curve.error_m[last] - curve.error_m[0]),
        largest_correction,
    };
    let others = runs.iter().filter(|(run, _)| run.angle_rad.abs() > NO_ANGLE_RAD).map(|(_, source)| (*source).clone());
    let logs: Vec<LogRef> = std::iter::once((*base_source).clone()).chain(others).collect();
    let mut file = LateralTableFile {
        format: LATERAL_TABLE_FORMAT.to_owned(),
        format_version: FORMAT_VERSION,
        tool_version: env!("CARGO_PKG_VERSION").to_owned(),
        vehicle: recordings[0].vehicle,
        logs,
        csv: CsvRef { file: "lateral_table.csv".to_owned(), sha256: String::new() },
        settings: serde_json::to_value(settings).unwrap_or_default(),
        base: base_mean,
        entries,
        dropped,
        curve,
    };
    file.csv.sha256 = sha256_hex(file.to_csv().as_bytes());
    Ok((file, report))
}

/// Weight of a piece.
fn weight(settings: &LateralFitSettings, bin: &Bin) -> f64 {
    if settings.weighting == Weighting::Distance { 1.0 } else { bin.count }
}

fn way(pieces: usize, log: &str, settings: &LateralFitSettings) -> Result<f64> {
    let found_m = pieces as f64 * settings.piece_m;
    if found_m < settings.least_m {
        return Err(Error::TooShort { log: log.to_owned(), found_m, needed_m: settings.least_m });
    }
    Ok(found_m)
}

/// Mean of one run.
fn alone(run: &CompensationRun, settings: &LateralFitSettings) -> Result<LateralMean> {
    let values: Vec<f64> = run.bins.values().map(Bin::mean_m).collect();
    let weights: Vec<f64> = run.bins.values().map(|b| weight(settings, b)).collect();
    let Mean { mean, std_err } = newey_west(&values, &weights);
    Ok(LateralMean { mean_error_m: mean, std_err_m: std_err, way_m: way(values.len(), &run.log, settings)? })
}

/// Entry of a run: the mean of the differences to the base, piece by piece, so that the effect of the path itself cancels.
fn against(run: &CompensationRun, base: &CompensationRun, settings: &LateralFitSettings) -> Result<LateralEntry> {
    if (run.way_m - base.way_m).abs() > settings.same_task * base.way_m {
        return Err(Error::OtherTask {
            log: run.log.clone(),
            found_m: run.way_m,
            base: base.log.clone(),
            base_m: base.way_m,
            allowed_pct: 100.0 * settings.same_task,
        });
    }
    let pairs = || run.bins.iter().filter_map(|(k, with)| Some((with, base.bins.get(k)?)));
    let values: Vec<f64> = pairs().map(|(with, without)| with.mean_m() - without.mean_m()).collect();
    let weights: Vec<f64> = pairs().map(|(with, without)| 0.5 * (weight(settings, with) + weight(settings, without))).collect();
    let Mean { mean, std_err } = newey_west(&values, &weights);
    Ok(LateralEntry {
        angle_rad: run.angle_rad,
        error_m: mean,
        std_err_m: std_err,
        way_m: way(values.len(), &run.log, settings)?,
        log: run.log.clone(),
        reason: String::new(),
    })
}

/// The curve, and the largest correction in standard errors. The errors are made monotone over the angle, in their overall direction, and
/// angles of equal errors are joined.
fn curve(entries: &[LateralEntry]) -> Result<(LateralCurve, f64)> {
    let mut sorted: Vec<&LateralEntry> = entries.iter().collect();
    sorted.sort_by(|a, b| a.angle_rad.total_cmp(&b.angle_rad));
    let std_err = |e: &LateralEntry| e.std_err_m.clamp(LEAST_STD_ERR_M, 1e3);
    // the base has the weight of the best entry: its zero is exact by definition, but must not outweigh all others
    let best = sorted.iter().filter(|e| e.angle_rad != 0.0).map(|e| std_err(e)).fold(f64::INFINITY, f64::min);
    let weights: Vec<f64> = sorted.iter().map(|e| std_err(e).max(best).powi(-2)).collect();
    let covariance: f64 = sorted.iter().zip(&weights).map(|(e, w)| w * e.angle_rad * e.error_m).sum();
    if covariance == 0.0 {
        return Err(Error::NoEffect);
    }
    let sign = covariance.signum();
    let errors: Vec<f64> = sorted.iter().map(|e| sign * e.error_m).collect();
    let fitted = isotonic(&errors, &weights);
    let corrections = fitted.iter().zip(&errors).zip(&sorted).map(|((f, e), entry)| (f - e).abs() / std_err(entry).max(best));
    let largest = corrections.fold(0.0, f64::max);
    // runs of equal errors become one point at their mean angle
    let mut points: Vec<(f64, f64, f64)> = Vec::new();
    for ((error, entry), weight) in fitted.iter().zip(&sorted).zip(&weights) {
        match points.last_mut() {
            Some((last, angle, sum)) if *last == *error => {
                *angle = (*angle * *sum + entry.angle_rad * weight) / (*sum + weight);
                *sum += weight;
            }
            _ => points.push((*error, entry.angle_rad, *weight)),
        }
    }
    if points.len() < 2 {
        return Err(Error::NoEffect);
    }
    if sign < 0.0 {
        points.reverse();
    }
    let curve = LateralCurve { error_m: points.iter().map(|p| sign * p.0).collect(), angle_rad: points.iter().map(|p| p.1).collect() };
    curve.check()?;
    Ok((curve, largest))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::log::{Loss, Signal, SignalName, Signals};
    use crate::map::Vehicle;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;
    use std::collections::BTreeMap;

    fn entry(angle_rad: f64, error_m: f64, std_err_m: f64) -> LateralEntry {
        LateralEntry { angle_rad, error_m, std_err_m, way_m: 40.0, log: String::new(), reason: String::new() }
    }

    #[test]
    fn the_curve_is_monotone_where_the_entries_are_not() {
        let entries = [
            entry(0.0, 0.0, 0.0),
            entry(0.01, -0.02, 1e-3),
            entry(0.02, -0.05, 1e-3),
            entry(0.03, -0.049, 1e-3),
            entry(-0.01, 0.021, 1e-3),
        ];
        let (curve, largest) = curve(&entries).unwrap();
        assert_eq!(curve.error_m.len(), 4);
        assert!((curve.error_m[0] + 0.0495).abs() < 1e-12 && (curve.angle_rad[0] - 0.025).abs() < 1e-12);
        assert!((largest - 0.5).abs() < 1e-9);
        assert_eq!(curve.error_m[3], 0.021);
    }

    /// A vehicle beside a straight of `way_m` at 0.8 m/s and 50 Hz: offset plus correlated noise, plus `angle`.
    fn recording(file: &str, angle_rad: f64, offset_m: f64, way_m: f64, seed: u64) -> Recording {
        let mut random = Pcg64::new(u128::from(seed), 5);
        let mut noise = 0.0;
        let mut lateral: BTreeMap<SignalName, Signal> = BTreeMap::new();
        let mut push = |name, time_ns, value| {
            let signal = lateral.entry(name).or_default();
            signal.time_ns.push(time_ns);
            signal.value.push(value);
        };
        for k in 0..(way_m / 0.016) as i64 {
            let (t, s) = (k * 20_000_000, 0.016 * k as f64);
            let fresh: f64 = StandardNormal.sample(&mut random);
            noise = 0.99 * noise + 0.0005 * fresh;
            // along a line at 30°, the matched point to the left of the vehicle by the error
            let (sin, cos) = 0.5_f64.sin_cos();
            let error = offset_m + noise;
            for (name, value) in [
                (SignalName::PoseX, s * cos + error * sin),
                (SignalName::PoseY, s * sin - error * cos),
                (SignalName::Yaw, 0.5),
                (SignalName::ReferenceX, s * cos),
                (SignalName::ReferenceY, s * sin),
                (SignalName::Compensation, angle_rad),
            ] {
                push(name, t, value);
            }
        }
        Recording {
            source: LogRef { sha256: file.to_owned(), file: file.to_owned(), bytes: 0, loss: None },
            path: file.into(),
            vehicle: Vehicle {
                wheelbase_m: 0.9,
                wheel_radius_m: 0.12,
                test_angle_deg: 90.0,
                torque_limit_nm: None,
                torque_full_scale_nm: None,
            },
            signals: Signals { lateral, ..Signals::default() },
            origins: Vec::new(),
            loss: Loss::default(),
            notes: Vec::new(),
            clock_notes: Vec::new(),
        }
    }

    #[test]
    fn an_entry_is_the_difference_to_the_base_and_its_standard_error_covers_it() {
        let (base_m, added_m, trials) = (0.03, -0.02, 100);
        let (mut covered, mut largest) = (0, 0.0_f64);
        for seed in 0..trials {
            let logs = [recording("base", 0.0, base_m, 60.0, 2 * seed), recording("one", 0.02, base_m + added_m, 60.0, 2 * seed + 1)];
            let (file, _) = fit(&logs, &LateralFitSettings::default()).unwrap();
            let entry = file.entries.iter().find(|e| e.angle_rad != 0.0).unwrap();
            covered += i32::from((entry.error_m - added_m).abs() <= 2.0 * entry.std_err_m);
            largest = largest.max((entry.error_m - added_m).abs());
            assert!((file.base.mean_error_m - base_m).abs() < 5.0 * file.base.std_err_m);
        }
        // 95.4 % for two standard errors; a correlation length of 1.6 m in 56 m leaves some 35 independent values, so some trials may miss
        assert!(covered >= 88, "{covered} of {trials}, largest {largest}");
    }

    #[test]
    fn logs_of_another_task_too_short_or_with_a_changing_angle_are_refused() {
        let base = || recording("base", 0.0, 0.03, 60.0, 1);
        let settings = LateralFitSettings::default();
        let refused = |logs: &[Recording]| fit(logs, &settings).unwrap_err();
        assert!(matches!(refused(&[base(), recording("a", 0.02, 0.0, 80.0, 2)]), Error::OtherTask { .. }));
        assert!(matches!(refused(&[recording("b", 0.0, 0.0, 9.0, 2), recording("a", 0.02, 0.0, 9.0, 3)]), Error::TooShort { .. }));
        let mut changing = recording("a", 0.02, 0.0, 60.0, 2);
        changing.signals.lateral.get_mut(&SignalName::Compensation).unwrap().value[100] = 0.03;
        assert!(matches!(refused(&[base(), changing]), Error::Changing { .. }));
        let mut blind = recording("a", 0.02, 0.0, 60.0, 2);
        blind.signals.lateral.remove(&SignalName::Yaw);
        assert!(matches!(refused(&[base(), blind]), Error::NoHeading { .. }));
        let mut elsewhen = recording("a", 0.02, 0.0, 60.0, 2);
        elsewhen.signals.lateral.get_mut(&SignalName::PoseX).unwrap().time_ns.iter_mut().for_each(|t| *t += 1 << 50);
        assert!(matches!(refused(&[base(), elsewhen]), Error::NoOverlap { .. }));
        assert!(matches!(fit(&[base()], &LateralFitSettings { threshold_m: f64::NAN, ..settings }), Err(Error::Setting { .. })));
    }

    #[test]
    fn angles_without_effect_give_no_table() {
        assert!(matches!(curve(&[entry(0.0, 0.0, 0.0), entry(0.01, 0.0, 1e-3)]), Err(Error::NoEffect)));
    }
}
