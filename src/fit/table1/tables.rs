//! The surface on the user's grid, with the status of every cell.

use crate::campaign::SampleVerdict;
use crate::fit::drive_form::campaign_drift::Progress;
use crate::fit::drive_form::torque_limit::TorqueLimit;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::table1::standard_errors::Uncertainty;
use crate::fit::{CampaignTime, FitSettings, Result};
use crate::map::{AccelMap, AccelTable, Axis, BreakawayTorque, CellStatus, CsvRef, FineSurface, Gear, csv_name, sha256_hex};
use std::collections::BTreeMap;

/// Fewest samples of a cell for it to count as measured: 0.06 s at 50 Hz.
const MEASURED_SAMPLES: u64 = 3;
/// Spacing of the default speed breaks [m/s].
const SPEED_STEP_MPS: f64 = 0.05;
/// Spacing of the fine grid's speeds [m/s].
const FINE_STEP_MPS: f64 = 0.0125;
/// Lines of the fine grid per interval of the surface's torque knots.
const FINE_TORQUES: usize = 4;
/// Standard error at which confidence is one half [m/s²].
const HALF_CONFIDENCE_MPS2: f64 = 0.1;

/// A used sample: speed and effective torque, gear frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UsedSample {
    pub(crate) gear: Gear,
    pub(crate) speed_mps: f64,
    pub(crate) torque_nm: f64,
}

/// The used encoder samples.
pub(crate) fn used_samples(estimate: &Estimate) -> Vec<UsedSample> {
    let lagged = estimate.torques();
    let mut samples = Vec::new();
    for (segment, smoothed) in estimate.data.segments.iter().zip(&estimate.paths.speeds_mps) {
        let mut cursor = lagged[segment.log].cursor();
        for (reading, v) in segment.readings.iter().zip(smoothed).filter(|(r, _)| r.source == 0) {
            let torque = cursor.at(reading.t_s - estimate.calibration.dead_time_s[segment.log]).torque_nm;
            let torque_nm = lagged[segment.log].limit().delivered_nm(*v, segment.gear.sign() * torque);
            samples.push(UsedSample { gear: segment.gear, speed_mps: *v, torque_nm });
        }
    }
    samples
}

/// The default speed breaks: every 0.05 m/s up to the first one at or past the fastest sample.
fn speed_breaks(samples: &[UsedSample]) -> Vec<f64> {
    let fastest = samples.iter().fold(0.0f64, |m, s| m.max(s.speed_mps));
    let last = (fastest / SPEED_STEP_MPS - 0.2).ceil().max(2.0) as usize;
    (0..=last).map(|k| (k as f64 * SPEED_STEP_MPS * 1e9).round() / 1e9).collect()
}

/// The tested levels: held torques of a gear that have used samples, merged where they differ by less than a hundredth of the largest.
fn torque_levels(estimate: &Estimate, gear: Gear, samples: &[UsedSample]) -> Vec<f64> {
    let mut levels: Vec<f64> = Vec::new();
    for log in &estimate.data.logs {
        levels.extend(log.survey.held_torques_nm(gear));
        levels.extend(log.survey.start_trials.iter().filter(|t| t.gear == gear).map(|t| t.torque_nm));
    }
    levels.sort_unstable_by(f64::total_cmp);
    let largest = levels.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let mut merged: Vec<(f64, usize)> = Vec::new();
    for level in levels {
        match merged.last_mut() {
            Some((mean, count)) if level - *mean < 0.01 * largest + 1e-9 => {
                *mean = (*mean * *count as f64 + level) / (*count as f64 + 1.0);
                *count += 1;
            }
            _ => merged.push((level, 1)),
        }
    }
    // to the decimal that a person would have typed
    let step = 10f64.powf((largest.max(1e-9)).log10().floor() - 3.0);
    let mut breaks: Vec<f64> = merged.iter().map(|(m, _)| ((m / step).round() * step * 1e9).round() / 1e9).collect();
    breaks.dedup();
    if breaks.len() >= 3 && breaks.len() <= 81 {
        return breaks;
    }
    // no fixed levels: an even grid over the covered range
    let own = samples.iter().filter(|s| s.gear == gear);
    let (low, high) = own.fold((0.0f64, 0.0f64), |(a, b), s| (a.min(s.torque_nm), b.max(s.torque_nm)));
    let width = (high - low).max(1e-6) / 20.0;
    (0..=20).map(|k| ((low + f64::from(k) * width) * 1e4).round() / 1e4).collect()
}

/// Table 1 of one gear. `angles_deg` are the wheel angle of the runs and the vehicle's test angle.
pub(crate) fn accel_map(
    estimate: &Estimate,
    uncertainty: &Uncertainty,
    gear: Gear,
    settings: &FitSettings,
    samples: &[UsedSample],
    (wheel_angle_deg, test_angle_deg): (f64, f64),
) -> Result<AccelMap> {
    let own: Vec<UsedSample> = samples.iter().copied().filter(|s| s.gear == gear).collect();
    let speed = settings.speed_breaks_mps.clone().unwrap_or_else(|| speed_breaks(&own));
    let levels = torque_levels(estimate, gear, &own);
    // a sample belongs to the nearest cell, but however coarse the breaks are, it shows only what is near it: in torque as far as those are
    // apart that were held
    let near_nm = 0.5 * levels.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let torque = settings.torque_breaks_nm.clone().unwrap_or(levels);
    let surface = estimate.model.surface(gear);
    let limit = estimate.calibration.drive.limit;
    // progress is zero at the mean of the gear's runs, whose map the surface is
    let when = if settings.at == CampaignTime::End { estimate.data.end[gear] } else { Progress::default() };
    let change = estimate.drift.at(when);
    let grid = |torques: &[f64], speeds: &[f64], limit: TorqueLimit| -> Vec<Vec<f64>> {
        let accel_mps2 = |v: f64, u: f64| {
            surface.accel_mps2(v, (1.0 + change.torque_share) * limit.delivered_nm(v, u))
                + change.friction_share * surface.accel_mps2(v, 0.0)
        };
        torques.iter().map(|u| speeds.iter().map(|v| round9(accel_mps2(*v, *u))).collect()).collect()
    };
    let accel = grid(&torque, &speed, limit);
    let table = AccelTable::new(Axis::new("speed_mps", speed.clone())?, Axis::new("torque_nm", torque.clone())?, accel.concat())?;
    let csv = table.to_matrix().to_csv();

    let mut count = vec![vec![0u64; speed.len()]; torque.len()];
    let mut measured_torque_nm: Vec<Option<[f64; 2]>> = vec![None; speed.len()];
    let governed_from_mps = estimate.data.logs.iter().map(|log| log.governed_from_mps).fold(f64::INFINITY, f64::min);
    for sample in &own {
        let (i, j) = (table.torque_nm().nearest(sample.torque_nm), table.speed_mps().nearest(sample.speed_mps));
        let is_near = (sample.speed_mps - speed[j]).abs() <= SPEED_STEP_MPS && (sample.torque_nm - torque[i]).abs() <= near_nm;
        // a governor takes an unknown part of the torque that is asked for
        let is_governed = sample.torque_nm > 0.0 && speed[j] > governed_from_mps;
        count[i][j] += u64::from(is_near && !is_governed);
        let range = measured_torque_nm[j].get_or_insert([sample.torque_nm; 2]);
        *range = [range[0].min(sample.torque_nm), range[1].max(sample.torque_nm)];
    }
    for range in measured_torque_nm.iter_mut().flatten() {
        *range = range.map(|u| (u * 1e3).round() / 1e3);
    }
    let measured: Vec<Vec<bool>> = count.iter().map(|row| row.iter().map(|c| *c >= MEASURED_SAMPLES).collect()).collect();
    let status = statuses(&measured);
    let points: Vec<(f64, f64)> = torque.iter().flat_map(|u| speed.iter().map(|v| (*v, limit.delivered_nm(*v, *u)))).collect();
    let errors: Vec<f64> = uncertainty
        .std_errs_mps2(estimate, gear, &points)
        .into_iter()
        .zip(&points)
        .map(|(error, (v, u))| {
            let by_torque = u * surface.value_and_slope(*v, *u).1;
            error.hypot(estimate.drift.std_mps2(when, surface.accel_mps2(*v, 0.0), by_torque))
        })
        .collect();
    let std_err: Vec<Vec<f64>> = errors.chunks(speed.len()).map(|row| row.iter().map(|e| round6(*e)).collect()).collect();
    let confidence =
        std_err.iter().zip(&status).map(|(errors, row)| errors.iter().zip(row).map(|(e, s)| confidence(*e, *s)).collect()).collect();
    let lattice = &surface.lattice;
    let fastest = lattice.fastest_mps().max(speed[speed.len() - 1]);
    let mut fine: Vec<f64> = lattice.speed_mps.iter().copied().filter(|v| *v < 2.0 * FINE_STEP_MPS).collect();
    fine.extend((0..).map(|k| f64::from(k) * FINE_STEP_MPS).take_while(|v| *v < fastest));
    fine.push(fastest);
    fine.sort_unstable_by(f64::total_cmp);
    fine.dedup_by(|a, b| *a - *b < 1e-4);
    // between knots the surface bends: lines through a quarter of their distance follow it
    let knots = lattice.torque_knots_nm();
    let fine_torque: Vec<f64> = knots
        .windows(2)
        .flat_map(|k| (0..FINE_TORQUES).map(|n| k[0] + (k[1] - k[0]) * n as f64 / FINE_TORQUES as f64))
        .chain(knots.last().copied())
        .map(round9)
        .collect();
    Ok(AccelMap {
        gear,
        wheel_angle_deg,
        csv: CsvRef { file: csv_name("table1", gear, wheel_angle_deg, test_angle_deg), sha256: sha256_hex(csv.as_bytes()) },
        accel_mps2: accel,
        std_err_mps2: std_err,
        count,
        confidence,
        status,
        measured_torque_nm,
        breakaway: breakaway(estimate, uncertainty, gear),
        surface: FineSurface {
            // before the limit: a grid would cut off a corner between its lines
            accel_mps2: grid(&fine_torque, &fine, TorqueLimit::None),
            torque_nm: fine_torque,
            speed_mps: fine,
        },
        speed_mps: speed,
        torque_nm: torque,
    })
}

/// Confidence in a cell, 0 to 1.
pub(crate) fn confidence(std_err_mps2: f64, status: CellStatus) -> f64 {
    let by_error = 1.0 / (1.0 + (std_err_mps2 / HALF_CONFIDENCE_MPS2).powi(2));
    let most = if status == CellStatus::Extrapolated { 0.5 } else { 1.0 };
    (by_error.min(most) * 1e3).round() / 1e3
}

/// Measured where samples are; interpolated where measured cells lie on both sides in the row or the column; extrapolated elsewhere.
fn statuses(measured: &[Vec<bool>]) -> Vec<Vec<CellStatus>> {
    let rows = measured.len();
    let columns = measured.first().map_or(0, Vec::len);
    (0..rows)
        .map(|i| {
            (0..columns)
                .map(|j| {
                    if measured[i][j] {
                        return CellStatus::Measured;
                    }
                    let in_row = measured[i][..j].contains(&true) && measured[i][j + 1..].contains(&true);
                    let in_column = (0..i).any(|r| measured[r][j]) && (i + 1..rows).any(|r| measured[r][j]);
                    if in_row || in_column { CellStatus::Interpolated } else { CellStatus::Extrapolated }
                })
                .collect()
        })
        .collect()
}

/// The torque at which the surface at standstill crosses zero, within the bounds from the starts from rest.
fn breakaway(estimate: &Estimate, uncertainty: &Uncertainty, gear: Gear) -> BreakawayTorque {
    let surface = estimate.model.surface(gear);
    let trials = || estimate.data.logs.iter().flat_map(|l| &l.survey.start_trials).filter(move |t| t.gear == gear);
    let moved_from_nm = trials().filter(|t| t.moved).map(|t| t.torque_nm).min_by(f64::total_cmp);
    let at_rest_up_to_nm =
        trials().filter(|t| !t.moved && moved_from_nm.is_none_or(|m| t.torque_nm <= m)).map(|t| t.torque_nm).max_by(f64::total_cmp);
    let crossing = surface.zero_torque_nm(0.0).map(|u| u.max(0.0));
    let mut torque_nm = crossing.or(moved_from_nm).or(at_rest_up_to_nm).unwrap_or(0.0);
    if let Some(low) = at_rest_up_to_nm {
        torque_nm = torque_nm.max(low);
    }
    if let Some(high) = moved_from_nm {
        torque_nm = torque_nm.min(high);
    }
    let std_err_nm = crossing.map(|u| {
        let slope = surface.value_and_slope(0.0, u).1.max(1e-6);
        round6(uncertainty.std_errs_mps2(estimate, gear, &[(0.0, u)])[0] / slope)
    });
    BreakawayTorque { torque_nm: round6(torque_nm), std_err_nm, at_rest_up_to_nm, moved_from_nm }
}

/// From the last reading used of each run of a log that ends in a stop to the rest, in order [s].
fn stops(estimate: &Estimate, log: usize) -> Vec<(f64, f64)> {
    let mut last_s: BTreeMap<usize, f64> = BTreeMap::new();
    for segment in estimate.data.segments.iter().filter(|s| s.log == log) {
        last_s.extend(segment.readings.last().map(|r| (segment.run, r.t_s)));
    }
    let stretches = &estimate.data.logs[log].survey.stretches;
    last_s.into_iter().filter_map(|(run, last_s)| Some((last_s, stretches[run].stopped_s?))).collect()
}

/// The final verdict on every encoder sample of every log.
pub(crate) fn verdicts(estimate: &Estimate) -> Vec<Vec<SampleVerdict>> {
    let mut all: Vec<Vec<SampleVerdict>> = estimate.data.logs.iter().map(|l| l.survey.verdicts.clone()).collect();
    for (k, log) in estimate.data.logs.iter().enumerate() {
        let encoder = &log.survey.track.encoder_mps;
        // both in the order of time, and the last to begin is the last to end
        let (cuts, transients) = (&log.cuts.intervals, &estimate.data.transients[k]);
        let torque = estimate.data.logs[k].torque(&estimate.calibration.drive, estimate.calibration.drift);
        let stops = stops(estimate, k);
        let undelivered = |t: f64| log.undelivered_s.iter().any(|gap| t >= gap.0 && t <= gap.1);
        let missing = |t: f64| torque.gaps().iter().any(|gap| t >= gap.0 && t <= gap.1);
        for (i, verdict) in all[k].iter_mut().enumerate().filter(|(_, v)| **v == SampleVerdict::Used) {
            let t = encoder.t_s[i] - estimate.calibration.encoder_delay_s;
            let cut = cuts[..cuts.partition_point(|c| c.0 <= t)].last().filter(|c| t <= c.1).map(|c| c.2);
            let spike = log.cuts.readings.contains(&(0, i as u32));
            let transient = transients[..transients.partition_point(|c| c.0 <= t)].last().is_some_and(|c| t <= c.1);
            *verdict = if let Some(reason) = cut {
                reason
            } else if spike {
                SampleVerdict::Outlier
            } else if undelivered(t - estimate.calibration.dead_time_s[k]) {
                SampleVerdict::TorqueLimited
            } else if missing(t - estimate.calibration.dead_time_s[k]) {
                SampleVerdict::Gap
            } else if transient {
                SampleVerdict::Transient
            } else if stops[..stops.partition_point(|s| s.0 < t)].last().is_some_and(|s| t <= s.1) {
                SampleVerdict::Stopping
            } else {
                SampleVerdict::TooShort
            };
        }
    }
    for segment in &estimate.data.segments {
        for reading in segment.readings.iter().filter(|r| r.source == 0) {
            all[segment.log][reading.sample as usize] = SampleVerdict::Used;
        }
    }
    all
}

fn round9(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

fn round6(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_between_measured_ones_is_interpolated_and_one_beyond_is_not() {
        let found = statuses(&[vec![true, false, true, false], vec![false, false, false, false], vec![true, false, false, true]]);
        assert_eq!(found[0][1], CellStatus::Interpolated);
        assert_eq!(found[1][0], CellStatus::Interpolated);
        assert_eq!(found[0][3], CellStatus::Extrapolated);
        assert_eq!(found[1][1], CellStatus::Extrapolated);
        assert_eq!(found[2][3], CellStatus::Measured);
    }
}
