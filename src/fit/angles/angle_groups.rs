//! Table 1 at several wheel angles from one campaign.
//!
//! In: [`Grouped`] surveys, an [`AngleGroup`] per wheel angle. Out: one [`Fit`] with the maps of all angles and what they have in common.
//!
//! Drive and encoder are the same at every angle, and so are dead times (one per log), lag and encoder calibration. Each angle with a yaw
//! rate is fitted by itself first and tells the delays, which are pooled by their standard errors; the encoder's scale and delay come from
//! the angle with the largest |sin δ|, where the yaw rate tells speeds best. Angles without a yaw rate then tell the dead times of logs
//! that no other angle shares. With all of that held, every angle is fitted again. Angles never share samples: friction and inertia are
//! each angle's own. What the finished maps have in common is found from them, and draws them together as far as their standard errors
//! allow (`family`).

use crate::campaign::{AngleGroup, Grouped, Survey, Verdict, ledger};
use crate::fit::angles::family::families;
use crate::fit::angles::shrink_together::draw_together;
use crate::fit::drive::torque_input::Choice;
use crate::fit::known_calibration::KnownCalibration;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::rounds::search::estimate;
use crate::fit::table1::angle_fit::Part;
use crate::fit::table1::product::{Delays, Fit, actuator, diagnostics, plant_noise, same_vehicle, vehicle, witnesses};
use crate::fit::table1::runs::{residual_rms_mps2, round};
use crate::fit::table1::soundness::coverage;
use crate::fit::table1::traces::traces;
use crate::fit::{Error, Result, Settings, fit_traced};
use crate::map::{AccelMap, FORMAT_VERSION, FitTraces, LogRef, RunRow, SAME_ANGLE_DEG, Stage1Report, TABLE1_FORMAT, Table1File, Units};
use crate::units::RAD_PER_DEG;
use std::collections::BTreeMap;

/// A standard error below this is not believed when estimates are pooled [s].
const LEAST_DELAY_STD_ERR_S: f64 = 1e-4;

/// Fits every group, the maps of `test_angle_deg` being those of the plain file names. One group, with no angle left empty, is fitted as by
/// [`fit`](crate::fit::fit).
///
/// An angle that cannot be fitted is left out, and a note says why; at `test_angle_deg` it is an error. With `asked`, the angles were asked
/// for by name: one that is left out, or whose table is not sound, makes the fit not sound. Without, angles were only found in the logs,
/// and one that makes no sound table is left out like one that cannot be fitted: a drive across the yard spoils no campaign.
///
/// # Errors
/// As [`fit`](crate::fit::fit); no group at `test_angle_deg`.
pub fn fit_angles(grouped: Grouped, asked: bool, test_angle_deg: f64, settings: &Settings) -> Result<(Fit, FitTraces)> {
    let Grouped { mut groups, empty, notes } = grouped;
    for group in &mut groups {
        group.surveys.sort_by(|a, b| a.track.source.cmp(&b.track.source));
        same_vehicle(&group.surveys)?;
    }
    groups.sort_by(|a, b| a.wheel_angle_deg.total_cmp(&b.wheel_angle_deg));
    let is_test = |angle_deg: f64| (angle_deg - test_angle_deg).abs() < SAME_ANGLE_DEG;
    if !groups.iter().any(|g| is_test(g.wheel_angle_deg)) {
        return Err(Error::NoTestAngle { test_angle_deg, found: list(groups.iter().map(|g| g.wheel_angle_deg)) });
    }
    if groups.len() == 1 && empty.is_empty() {
        return fit_traced(groups.remove(0).surveys, settings);
    }
    same_vehicle_at_every_angle(&groups)?;

    let choice = Choice::new(groups.iter().flat_map(|g| &g.surveys), settings);
    let (known, delays, mut failed) = shared(&groups, &choice, settings);
    let held = Settings { known: Some(known), ..settings.clone() };
    let mut parts: Vec<(f64, Part)> = Vec::new();
    let mut unsound = Vec::new();
    for group in &groups {
        if failed.iter().any(|(angle, _)| angle.total_cmp(&group.wheel_angle_deg).is_eq()) {
            continue;
        }
        match Part::new(&group.surveys, &choice, &held, test_angle_deg) {
            Ok(part) if asked || part.objections.is_empty() || is_test(group.wheel_angle_deg) => parts.push((group.wheel_angle_deg, part)),
            Ok(part) => unsound.push((group.wheel_angle_deg, part.objections.join("; "))),
            Err(error) => failed.push((group.wheel_angle_deg, error)),
        }
    }
    if let Some(at) = failed.iter().position(|(angle, _)| is_test(*angle)) {
        return Err(failed.swap_remove(at).1);
    }
    let mut left_out: Vec<(f64, String)> =
        failed.iter().map(|(angle, error)| (*angle, error.to_string())).chain(unsound).chain(empty).collect();
    left_out.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut fit, traces) = assemble(&groups, &parts, (&left_out, notes), (test_angle_deg, &delays), (&choice, settings))?;
    fit.sound &= left_out.is_empty() || !asked;
    Ok((fit, traces))
}

/// Wheelbase and wheel radius are the same at every angle.
fn same_vehicle_at_every_angle(groups: &[AngleGroup]) -> Result<()> {
    let all: Vec<Survey> = groups
        .iter()
        .flat_map(|g| &g.surveys)
        .map(|s| {
            let mut survey = s.clone();
            survey.track.vehicle.test_angle_deg = groups[0].wheel_angle_deg;
            survey
        })
        .collect();
    same_vehicle(&all)
}

/// Values pooled by their standard errors.
#[derive(Debug, Clone, Copy, Default)]
struct Pool {
    weight: f64,
    sum: f64,
}

impl Pool {
    fn add(&mut self, value: f64, std_err: f64) {
        let weight = std_err.max(LEAST_DELAY_STD_ERR_S).powi(-2);
        self.weight += weight;
        self.sum += weight * value;
    }

    fn mean(self) -> Option<(f64, f64)> {
        (self.weight > 0.0).then(|| (self.sum / self.weight, self.weight.powf(-0.5)))
    }
}

/// Delays of the logs and the lag, pooled over the angles.
#[derive(Debug, Default)]
struct Pooled {
    dead_time_s: BTreeMap<String, Pool>,
    lag_s: Pool,
}

impl Pooled {
    fn add(&mut self, estimate: &Estimate) {
        let calibration = &estimate.calibration;
        for ((log, dead_time_s), std_err_s) in
            estimate.logs.iter().zip(&calibration.dead_time_s).zip(&estimate.calibration_errors.dead_time_s)
        {
            self.dead_time_s.entry(log.survey.track.source.sha256.clone()).or_default().add(*dead_time_s, *std_err_s);
        }
        self.lag_s.add(calibration.lag_s, estimate.calibration_errors.lag_s);
    }

    fn known(&self, encoder: Option<(f64, f64)>) -> KnownCalibration {
        KnownCalibration {
            dead_time_s: self.dead_time_s.iter().filter_map(|(log, pool)| Some((log.clone(), pool.mean()?.0))).collect(),
            lag_s: self.lag_s.mean().map(|m| m.0),
            encoder,
        }
    }
}

/// What the angles share, and the angles that cannot be fitted.
fn shared(groups: &[AngleGroup], choice: &Choice, settings: &Settings) -> (KnownCalibration, Pooled, Vec<(f64, Error)>) {
    let has_yaw = |g: &&AngleGroup| g.surveys.iter().any(|s| s.track.yaw_speed_mps.is_some());
    let mut pooled = Pooled::default();
    let mut failed = Vec::new();
    let mut best: Option<(f64, (f64, f64))> = None;
    for group in groups.iter().filter(has_yaw) {
        match estimate(&group.surveys, choice, settings) {
            Ok(estimate) => {
                pooled.add(&estimate);
                let sine = (group.wheel_angle_deg * RAD_PER_DEG).sin().abs();
                if best.is_none_or(|(s, _)| sine > s) {
                    best = Some((sine, (estimate.calibration.encoder_scale, estimate.calibration.encoder_delay_s)));
                }
            }
            Err(error) => failed.push((group.wheel_angle_deg, error)),
        }
    }
    let encoder = best.map(|(_, encoder)| encoder);
    // the encoder alone: its delay is known by now, or stays within the dead time
    let so_far = pooled.known(encoder);
    let mut others = Pooled::default();
    for group in groups.iter().filter(|g| !has_yaw(g)) {
        let all_known = group.surveys.iter().all(|s| so_far.dead_time_s.contains_key(&s.track.source.sha256));
        if all_known {
            continue;
        }
        let held = Settings { known: Some(so_far.clone()), ..settings.clone() };
        match estimate(&group.surveys, choice, &held) {
            Ok(estimate) => others.add(&estimate),
            Err(error) => failed.push((group.wheel_angle_deg, error)),
        }
    }
    for (log, pool) in others.dead_time_s {
        pooled.dead_time_s.entry(log).or_insert(pool);
    }
    if pooled.lag_s.mean().is_none() {
        pooled.lag_s = others.lag_s;
    }
    (pooled.known(encoder), pooled, failed)
}

/// One file from the fits of all angles.
fn assemble(
    groups: &[AngleGroup],
    parts: &[(f64, Part)],
    (left_out, mut notes): (&[(f64, String)], Vec<String>),
    (test_angle_deg, pooled): (f64, &Pooled),
    (choice, settings): (&Choice, &Settings),
) -> Result<(Fit, FitTraces)> {
    let surveys: BTreeMap<&LogRef, &Survey> = groups.iter().flat_map(|g| &g.surveys).map(|s| (&s.track.source, s)).collect();
    let logs: Vec<LogRef> = surveys.keys().map(|log| (*log).clone()).collect();
    let surveys: Vec<&Survey> = surveys.into_values().collect();
    let verdicts = merged_verdicts(&logs, &surveys, parts);
    let test = parts.iter().find(|(angle, _)| (angle - test_angle_deg).abs() < SAME_ANGLE_DEG);
    let (_, test) = test.ok_or_else(|| Error::NoTestAngle { test_angle_deg, found: list(parts.iter().map(|p| p.0)) })?;

    notes.extend(left_out.iter().map(|(angle, reason)| format!("{angle}° is left out: {reason}")));
    notes.extend(surveys.iter().flat_map(|s| s.track.notes.iter().map(|n| format!("{}: {n}", s.track.source.file))));
    notes.extend(choice.note());
    let of_tracks = notes.len();
    for (angle, part) in parts {
        notes.extend(
            part.notes()
                .into_iter()
                .map(|n| format!("{angle}°: {n}"))
                .filter(|n| {
                    // what a log says of its signals is the same at every angle
                    !notes[..of_tracks].iter().any(|track| n.ends_with(track.as_str()))
                })
                .collect::<Vec<_>>(),
        );
    }
    let mut maps: Vec<AccelMap> = parts.iter().flat_map(|(_, p)| p.maps.iter().map(|(map, _)| map.clone())).collect();
    let found = families(&maps)?;
    draw_together(&mut maps, &found)?;
    let families = found.into_iter().map(|f| f.told).collect();
    let csvs = maps.iter().map(|map| Ok((map.csv.file.clone(), map.table()?.to_matrix().to_csv()))).collect::<Result<_>>()?;

    let (rows, places) = merged_rows(&logs, parts);
    let squares: f64 = parts.iter().map(|(_, p)| residual_rms_mps2(&p.estimate).powi(2) * p.samples.len() as f64).sum();
    let used: usize = parts.iter().map(|(_, p)| p.samples.len()).sum();
    let mut all = diagnostics(&test.estimate, test.monotone, test.figures.pooled);
    all["angles"] = parts
        .iter()
        .map(|(angle, p)| {
            let mut one = diagnostics(&p.estimate, p.monotone, p.figures.pooled);
            one["wheel_angle_deg"] = serde_json::json!(angle);
            one
        })
        .collect();
    let report = Stage1Report {
        ledger: ledger(verdicts.iter().zip(&surveys).flat_map(|(v, s)| v.iter().copied().zip(s.seconds.iter().copied()))),
        runs: rows,
        residual_rms_mps2: round((squares / used.max(1) as f64).sqrt(), 1e5),
        coverage: round(coverage(&maps).0, 1e4),
        iterations: parts.iter().map(|(_, p)| p.estimate.iterations as u32).max().unwrap_or(0),
        notes,
        diagnostics: all,
    };
    let of_logs: Vec<Survey> = surveys.iter().map(|s| (*s).clone()).collect();
    let mut vehicle = vehicle(&of_logs);
    vehicle.test_angle_deg = test_angle_deg;
    let file = Table1File {
        format: TABLE1_FORMAT.to_owned(),
        format_version: FORMAT_VERSION,
        tool_version: env!("CARGO_PKG_VERSION").to_owned(),
        units: Units::default(),
        vehicle,
        actuator: actuator(&delays(&logs, pooled, &test.estimate), &surveys, choice, settings),
        logs,
        settings: serde_json::to_value(settings).map_err(crate::map::Error::from)?,
        witnesses: witnesses(&test.estimate),
        noise: plant_noise(&test.estimate),
        maps,
        families,
        report,
    };
    let sound = parts.iter().all(|(_, p)| p.objections.is_empty());
    let fit = Fit { file, csvs, verdicts, sound };
    let traces = merged_traces(&fit, parts, &places, test_angle_deg)?;
    Ok((fit, traces))
}

fn list(angles: impl Iterator<Item = f64>) -> String {
    let all: Vec<String> = angles.map(|a| format!("{a}°")).collect();
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}

fn delays(logs: &[LogRef], pooled: &Pooled, test: &Estimate) -> Delays {
    let of_log = |log: &LogRef| {
        let own = pooled.dead_time_s.get(&log.sha256).and_then(|p| p.mean());
        // a log whose only angle could not be fitted
        own.unwrap_or((test.calibration.dead_time_s[0], test.calibration_errors.dead_time_s[0]))
    };
    let dead_times: Vec<(f64, f64)> = logs.iter().map(of_log).collect();
    let (lag_s, lag_std_err_s) = pooled.lag_s.mean().unwrap_or((test.calibration.lag_s, test.calibration_errors.lag_s));
    Delays {
        dead_time_s: dead_times.iter().map(|d| d.0).collect(),
        dead_time_std_err_s: dead_times.iter().map(|d| d.1).collect(),
        lag_s,
        lag_std_err_s,
    }
}

/// One verdict per sample: that of the angle at which the wheel was, else *wheel not at angle*.
fn merged_verdicts(logs: &[LogRef], surveys: &[&Survey], parts: &[(f64, Part)]) -> Vec<Vec<Verdict>> {
    let mut merged: Vec<Vec<Verdict>> = surveys.iter().map(|s| s.verdicts.clone()).collect();
    for (at, log) in logs.iter().enumerate() {
        merged[at].fill(Verdict::WheelNotAtAngle);
        for (_, part) in parts {
            let Some(k) = part.estimate.logs.iter().position(|l| l.survey.track.source == *log) else { continue };
            for (all, own) in merged[at].iter_mut().zip(&part.verdicts[k]) {
                if *all == Verdict::WheelNotAtAngle {
                    *all = *own;
                }
            }
        }
    }
    merged
}

/// The runs of all angles by log and time, and the place of every part's rows among them.
fn merged_rows(logs: &[LogRef], parts: &[(f64, Part)]) -> (Vec<RunRow>, Vec<Vec<usize>>) {
    let log_of = |row: &RunRow| logs.iter().position(|l| l.file == row.log).unwrap_or(usize::MAX);
    let mut all: Vec<(usize, usize, RunRow)> = Vec::new();
    for (at, (angle, part)) in parts.iter().enumerate() {
        for (k, row) in part.figures.rows.iter().enumerate() {
            all.push((at, k, RunRow { wheel_angle_deg: Some(*angle), ..row.clone() }));
        }
    }
    all.sort_by(|a, b| log_of(&a.2).cmp(&log_of(&b.2)).then(a.2.start_s.total_cmp(&b.2.start_s)).then(a.0.cmp(&b.0)));
    let mut places: Vec<Vec<usize>> = parts.iter().map(|(_, p)| vec![0; p.figures.rows.len()]).collect();
    for (place, (part, row, _)) in all.iter().enumerate() {
        places[*part][*row] = place;
    }
    (all.into_iter().map(|(_, _, row)| row).collect(), places)
}

/// The traces of all angles; cells and delays of the test angle.
fn merged_traces(fit: &Fit, parts: &[(f64, Part)], places: &[Vec<usize>], test_angle_deg: f64) -> Result<FitTraces> {
    let mut merged: Option<FitTraces> = None;
    let (mut runs, mut times) = (Vec::new(), Vec::new());
    for ((angle, part), places) in parts.iter().zip(places) {
        // a part is drawn as the fit that it would be alone
        let mut file = fit.file.clone();
        file.maps = part.maps.iter().map(|(map, _)| map.clone()).collect();
        file.report.runs.clone_from(&part.figures.rows);
        let alone = Fit { file, csvs: Vec::new(), verdicts: part.verdicts.clone(), sound: fit.sound };
        let mut own = traces(&part.estimate, &part.compared, &alone)?;
        for run in &mut own.runs {
            run.row = places[run.row];
        }
        runs.append(&mut own.runs);
        times.append(&mut own.residual_times);
        if (angle - test_angle_deg).abs() < SAME_ANGLE_DEG {
            merged = Some(own);
        }
    }
    runs.sort_by_key(|run| run.row);
    let mut merged = merged.ok_or(Error::NoLogs)?;
    merged.runs = runs;
    merged.residual_times = times;
    merged.table1.sha256 = crate::map::sha256_hex(fit.file.to_json()?.as_bytes());
    Ok(merged)
}
