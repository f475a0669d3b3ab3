//! What a fit gives: `table1.json`, its CSVs, and the verdict on every sample.

use crate::campaign::{Survey, Verdict, ledger};
use crate::fit::drive::torque_input::Choice;
use crate::fit::rounds::cross_validation::Comparison;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::solve::monotone;
use crate::fit::table1::angle_fit::Part;
use crate::fit::table1::runs::{Compared, residual_rms_mps2, round};
use crate::fit::table1::soundness::coverage;
use crate::fit::table1::traces::traces;
use crate::fit::{Error, Result, Settings};
use crate::map::{
    AccelMap, Actuator, DelayEstimate, DelayStatus, FORMAT_VERSION, FitTraces, LogActuator, PlantNoise, SpeedReading, SpeedSource,
    Stage1Report, TABLE1_FORMAT, Table1File, Units, Vehicle,
};
use crate::signal::median;

/// Table 1 with its files.
#[derive(Debug, Clone)]
pub struct Fit {
    /// `table1.json`.
    pub file: Table1File,
    /// Name and text of each CSV beside it.
    pub csvs: Vec<(String, String)>,
    /// The final verdict on every encoder sample, per log in the order of `file.logs`.
    pub verdicts: Vec<Vec<Verdict>>,
    /// Whether the table may be trusted: enough of it measured or interpolated, torque varied, no log against another. The report's notes
    /// say what is missing.
    pub sound: bool,
}

/// An offset between the clocks of command and speed counts from here on [s]: smaller ones are sampling phases.
const CLOCK_OFFSET_S: f64 = 0.02;

/// Fits Table 1 to the surveyed logs of one vehicle. The order of the logs does not matter.
///
/// # Errors
/// No logs, logs of different vehicles, too little motion, one torque only, a speed signal that is too slow and alone.
pub fn fit(surveys: Vec<Survey>, settings: &Settings) -> Result<Fit> {
    Ok(fit_and(surveys, settings, |_, _, _| ())?.0)
}

/// The same fit with the traces that a report shows, thinned out.
///
/// # Errors
/// As [`fit`].
pub fn fit_traced(surveys: Vec<Survey>, settings: &Settings) -> Result<(Fit, FitTraces)> {
    let (fit, traces) = fit_and(surveys, settings, traces)?;
    Ok((fit, traces?))
}

/// Fits, and lets `look` see the estimate.
fn fit_and<T>(mut surveys: Vec<Survey>, settings: &Settings, look: impl FnOnce(&Estimate, &[Compared], &Fit) -> T) -> Result<(Fit, T)> {
    surveys.sort_by(|a, b| a.track.source.cmp(&b.track.source));
    same_vehicle(&surveys)?;
    let vehicle = vehicle(&surveys);
    let choice = Choice::new(&surveys, settings);
    let part = Part::new(&surveys, &choice, settings, vehicle.test_angle_deg)?;
    let notes = part.notes();
    let Part { estimate, verdicts, figures, .. } = part;
    let (maps, csvs): (Vec<AccelMap>, Vec<String>) = part.maps.into_iter().unzip();
    let csvs = maps.iter().map(|m| m.csv.file.clone()).zip(csvs).collect();
    let table = ledger(verdicts.iter().zip(&surveys).flat_map(|(v, s)| v.iter().copied().zip(s.seconds.iter().copied())));
    let report = Stage1Report {
        ledger: table,
        runs: figures.rows,
        residual_rms_mps2: round(residual_rms_mps2(&estimate), 1e5),
        coverage: round(coverage(&maps).0, 1e4),
        iterations: estimate.iterations as u32,
        notes,
        diagnostics: diagnostics(&estimate, part.monotone, figures.pooled),
    };
    let delays = Delays {
        dead_time_s: estimate.calibration.dead_time_s.clone(),
        dead_time_std_err_s: estimate.calibration_errors.dead_time_s.clone(),
        lag_s: estimate.calibration.lag_s,
        lag_std_err_s: estimate.calibration_errors.lag_s,
    };
    let file = Table1File {
        format: TABLE1_FORMAT.to_owned(),
        format_version: FORMAT_VERSION,
        tool_version: env!("CARGO_PKG_VERSION").to_owned(),
        units: Units::default(),
        vehicle,
        logs: surveys.iter().map(|s| s.track.source.clone()).collect(),
        settings: serde_json::to_value(settings).map_err(crate::map::Error::from)?,
        actuator: actuator(&delays, &surveys.iter().collect::<Vec<_>>(), &choice, settings),
        witnesses: witnesses(&estimate),
        noise: plant_noise(&estimate),
        maps,
        families: Vec::new(),
        report,
    };
    let fit = Fit { file, csvs, verdicts, sound: part.objections.is_empty() };
    let seen = look(&estimate, &part.compared, &fit);
    Ok((fit, seen))
}

/// The vehicle, with the largest commanded torque where no limit is given.
pub(crate) fn vehicle(surveys: &[Survey]) -> Vehicle {
    let mut vehicle = surveys[0].track.vehicle;
    let commanded = surveys.iter().flat_map(|s| &s.track.command_nm.value).fold(0.0f64, |m, v| m.max(v.abs()));
    vehicle.torque_limit_nm = vehicle.torque_limit_nm.or(Some(commanded));
    vehicle
}

/// What is random about the plant.
pub(crate) fn plant_noise(estimate: &Estimate) -> PlantNoise {
    PlantNoise {
        disturbance_mps2: round(estimate.noise.disturbance_mps2, 1e6),
        disturbance_time_s: round(estimate.noise.disturbance_time_s, 1e6),
        run_offset_mps2: round(estimate.noise.offset_mps2, 1e6),
        speed_noise_mps: round(estimate.noise.reading_mps[0], 1e6),
    }
}

/// Logs of one vehicle agree on its geometry.
pub(crate) fn same_vehicle(surveys: &[Survey]) -> Result<()> {
    let first = surveys.first().ok_or(Error::NoLogs)?;
    for other in &surveys[1..] {
        let (a, b) = (&first.track.vehicle, &other.track.vehicle);
        for (field, x, y) in [
            ("wheelbase_m", a.wheelbase_m, b.wheelbase_m),
            ("wheel_radius_m", a.wheel_radius_m, b.wheel_radius_m),
            ("test_angle_deg", a.test_angle_deg, b.test_angle_deg),
        ] {
            if (x - y).abs() > 1e-6 * x.abs().max(y.abs()) {
                return Err(Error::DifferentVehicles {
                    field,
                    first: first.track.source.file.clone(),
                    first_value: x,
                    second: other.track.source.file.clone(),
                    second_value: y,
                });
            }
        }
    }
    Ok(())
}

/// Delays as estimated, one dead time per log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Delays {
    pub(crate) dead_time_s: Vec<f64>,
    pub(crate) dead_time_std_err_s: Vec<f64>,
    pub(crate) lag_s: f64,
    pub(crate) lag_std_err_s: f64,
}

/// Dead times, lag and clock offsets, each with its status; one survey per log.
///
/// Where the feedback was the input, the delays found are those from it to the speed. What a controller needs leads from the command: the
/// feedback's own dead time comes on top, and its lag takes the place of none.
pub(crate) fn actuator(found: &Delays, surveys: &[&Survey], choice: &Choice, settings: &Settings) -> Actuator {
    let status = |given: bool, std_err_s: f64| {
        if given {
            DelayStatus::Given
        } else if std_err_s > 0.01 {
            DelayStatus::WeaklyDetermined
        } else {
            DelayStatus::Estimated
        }
    };
    let told = |value_s: f64, std_err_s: f64, given: bool| DelayEstimate {
        value_s: round(value_s, 1e6),
        std_err_s: (!given).then(|| round(std_err_s, 1e6)),
        status: status(given, std_err_s),
    };
    let given = settings.dead_time_s.is_some();
    let mut std_errs_s = Vec::new();
    let per_log: Vec<LogActuator> = surveys
        .iter()
        .enumerate()
        .map(|(k, survey)| {
            let own = (found.dead_time_s[k], found.dead_time_std_err_s[k]);
            let feedback = choice.delays(&survey.track.source);
            // dead time from command to speed, and what of it the feedback does not show
            let ((total, std_err), offset) = match feedback {
                Some(f) if choice.is_feedback() => ((f.dead_time_s + own.0, own.1.hypot(f.misfit() * f.dead_time_std_err_s)), Some(own)),
                Some(f) => (own, Some((own.0 - f.dead_time_s, (own.1 * own.1 + f.dead_time_std_err_s * f.dead_time_std_err_s).sqrt()))),
                None => (own, None),
            };
            std_errs_s.push(std_err);
            let (clock_offset, dead_time) = match (offset, feedback) {
                (Some((offset, error)), Some(f)) => {
                    let real = offset.abs() > CLOCK_OFFSET_S.max(4.0 * error);
                    let estimate = DelayEstimate {
                        value_s: round(offset, 1e6),
                        std_err_s: Some(round(error, 1e6)),
                        status: if real { DelayStatus::Estimated } else { DelayStatus::NoneFound },
                    };
                    (estimate, if real { f.dead_time_s } else { total })
                }
                _ => (DelayEstimate { value_s: 0.0, std_err_s: None, status: DelayStatus::NotSeparable }, total),
            };
            LogActuator {
                sha256: survey.track.source.sha256.clone(),
                file: survey.track.source.file.clone(),
                dead_time: told(dead_time, std_err, given),
                clock_offset,
            }
        })
        .collect();
    let (mean, spread) = mean_and_error(&per_log.iter().map(|l| l.dead_time.value_s).collect::<Vec<_>>());
    let of_errors = std_errs_s.iter().map(|e| e * e).sum::<f64>().sqrt() / std_errs_s.len() as f64;
    let (lag_s, lag_std_err_s) = if choice.is_feedback() {
        let (lag_s, spread) = mean_and_error(&choice.all_delays().map(|f| f.lag_s).collect::<Vec<_>>());
        let squares: f64 = choice.all_delays().map(|f| (f.misfit() * f.lag_std_err_s).powi(2)).sum();
        (lag_s, spread.max(squares.sqrt() / choice.all_delays().len() as f64))
    } else {
        (found.lag_s, found.lag_std_err_s)
    };
    Actuator {
        dead_time: told(mean, spread.max(of_errors), given),
        lag: told(lag_s, lag_std_err_s, settings.lag_s.is_some()),
        input: choice.told(),
        per_log,
    }
}

/// Mean, and its standard error by the spread of the values; 0 for a single one.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let spread =
        if values.len() > 1 { (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0) / count).sqrt() } else { 0.0 };
    (mean, spread)
}

pub(crate) fn witnesses(estimate: &Estimate) -> Vec<SpeedReading> {
    let encoder = SpeedReading {
        name: SpeedSource::Encoder,
        scale: round(estimate.calibration.encoder_scale, 1e6),
        scale_std_err: estimate.has_yaw.then(|| round(estimate.calibration_errors.encoder_scale, 1e6)),
        delay_s: round(estimate.calibration.encoder_delay_s, 1e6),
        noise_mps: round(estimate.noise.reading_mps[0], 1e6),
    };
    let mut all = vec![encoder];
    if estimate.has_yaw {
        all.push(SpeedReading {
            name: SpeedSource::YawRate,
            scale: 1.0,
            scale_std_err: None,
            delay_s: 0.0,
            noise_mps: round(estimate.noise.reading_mps[1], 1e6),
        });
    }
    all
}

pub(crate) fn diagnostics(estimate: &Estimate, moved: monotone::Outcome, pooled: Option<(f64, f64)>) -> serde_json::Value {
    let innovations: Vec<f64> = estimate.white.iter().flatten().map(|e| e.abs()).collect();
    let blocks: Vec<serde_json::Value> = estimate
        .design
        .blocks
        .iter()
        .zip(estimate.stacked.solution.penalties.iter().zip(&estimate.stacked.solution.degrees))
        .map(|(block, (penalty, degrees))| {
            serde_json::json!({
                "block": block.name,
                "coefficients": block.range.len(),
                "effective": round(*degrees, 1e3),
                "penalty": if block.penalised && penalty.is_finite() { serde_json::json!(penalty) } else { serde_json::Value::Null },
            })
        })
        .collect();
    let model_choice = estimate.validation.as_ref().map(|v| {
        let Comparison { gain, in_std_errs, runs, surface_share } = v.comparison;
        serde_json::json!({
            "surface_share": round(surface_share, 1e3),
            "gain_of_surface": round(gain, 1e3),
            "in_std_errs": round(in_std_errs, 1e2),
            "runs": runs,
        })
    });
    let held_out = pooled.zip(estimate.validation.as_ref()).map(|((rmse_mps, r_squared), v)| {
        serde_json::json!({ "rmse": round(rmse_mps, 1e5), "r_squared": round(r_squared, 1e5), "folds": v.without.len() })
    });
    serde_json::json!({
        "model_choice": model_choice,
        "held_out": held_out,
        "stribeck_speed_mps": round(estimate.design.stribeck_mps, 1e6),
        "blocks": blocks,
        "penalties_settled": estimate.stacked.solution.settled,
        "monotone": match moved {
            monotone::Outcome::AlreadyMonotone => "by itself".to_owned(),
            monotone::Outcome::Moved(n) => format!("{n} differences bind"),
            monotone::Outcome::Forced => "forced".to_owned(),
        },
        "innovation_scale": round(median(&innovations) / 0.674_489_750_196_082, 1e4),
    })
}
