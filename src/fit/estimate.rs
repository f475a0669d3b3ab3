//! The outer loop: speeds, torques and noise, surface and delays, each from the others, until the surface stands still.

use super::actuator::LaggedCommand;
use super::anova::Design;
use super::coarse;
use super::gram::Gram;
use super::hyper;
use super::kalman::{Noise, smooth};
use super::lattice::{Lattice, LatticeSurface};
use super::passes::{Along, Way, offsets_of, total, wide_speeds};
use super::penalised::{Solution, System, nuisance_prior_std};
use super::regressors::nuisance;
use super::robust;
use super::sampling;
use super::segment::{Calibration, Cuts, LogData, Segment};
use super::validation::{self, Validation};
use super::{Error, Result, Settings};
use crate::campaign::Survey;
use crate::map::Gear;
use crate::signal::{Series, noise_std, quantum};
use std::collections::BTreeSet;

/// Movement of the surface below which it stands still [m/s², root mean square].
const STILL_MPS2: f64 = 2e-4;
/// Largest step of a delay in one iteration [s].
const DELAY_STEP_S: f64 = 0.02;
/// Quantum of speed above which a start cannot be anchored: the first reading after it comes late and biased [m/s].
const COARSE_QUANTUM_MPS: f64 = 0.01;

/// A speed signal slower than this cannot follow a lag of some 50 ms [Hz].
const SLOW_HZ: f64 = 10.0;

/// Everything that the estimator found out.
pub(crate) struct Estimate<'a> {
    pub(crate) logs: Vec<LogData<'a>>,
    pub(crate) design: Design,
    pub(crate) calibration: Calibration,
    /// Standard errors of dead times (per log), lag, encoder scale and delay.
    pub(crate) dead_time_std_err_s: Vec<f64>,
    pub(crate) lag_std_err_s: f64,
    pub(crate) encoder_scale_std_err: f64,
    pub(crate) noise: Noise,
    pub(crate) noise_bounds: Vec<&'static str>,
    pub(crate) gears: Vec<Gear>,
    pub(crate) surfaces: [LatticeSurface; 2],
    pub(crate) solution: Solution,
    pub(crate) system: System,
    pub(crate) segments: Vec<Segment>,
    /// Speeds along the segments, smoothed [m/s].
    pub(crate) speeds: Vec<Vec<f64>>,
    /// Offset of each segment [m/s²].
    pub(crate) offsets: Vec<f64>,
    /// Whitened residuals of the segments.
    pub(crate) white: Vec<Vec<f64>>,
    pub(crate) transients: Vec<Vec<(f64, f64)>>,
    pub(crate) iterations: usize,
    pub(crate) converged: bool,
    pub(crate) has_yaw: bool,
    /// What runs left out say; absent with fewer than two runs.
    pub(crate) validation: Option<Validation>,
}

impl Estimate<'_> {
    /// The surface of a gear.
    pub(crate) fn surface(&self, gear: Gear) -> &LatticeSurface {
        &self.surfaces[usize::from(gear == Gear::Reverse)]
    }

    /// The lagged command of a log.
    pub(crate) fn lagged(&self, log: usize) -> LaggedCommand {
        LaggedCommand::new(&self.logs[log].survey.track.command_nm, self.calibration.lag_s)
    }
}

/// Runs the estimator.
pub(crate) fn estimate<'a>(surveys: &'a [Survey], settings: &Settings) -> Result<Estimate<'a>> {
    if let Some((survey, rate_hz)) = surveys.iter().filter(|s| s.track.yaw_speed_mps.is_none()).find_map(|s| Some((s, slow_rate_hz(s)?))) {
        return Err(Error::SlowSpeed { file: survey.track.source.file.clone(), rate_hz, needed_hz: SLOW_HZ });
    }
    let mut logs: Vec<LogData> = surveys.iter().map(log_data).collect();
    let has_yaw = surveys.iter().any(|s| s.track.yaw_speed_mps.is_some());
    let mut calibration = first_calibration(surveys);
    hold_known(&mut calibration, surveys, settings);
    let mut noise = first_noise(surveys);
    let gears: Vec<Gear> = Gear::ALL.into_iter().filter(|g| surveys.iter().any(|s| s.stretches.iter().any(|r| r.gear == *g))).collect();

    // dead time and lag, coarsely
    let lagged0: Vec<LaggedCommand> = surveys.iter().map(|s| LaggedCommand::new(&s.track.command_nm, calibration.lag_s)).collect();
    let none = vec![Vec::new(); logs.len()];
    let segments = build(&logs, &calibration, &lagged0, None, &none);
    let usable_s: f64 = segments.iter().map(span_s).sum();
    if usable_s < 5.0 {
        return Err(Error::TooLittle { seconds: usable_s, needed_s: 5.0 });
    }
    let speeds = wide_speeds(&segments);
    {
        let views: Vec<coarse::LogView> = (0..logs.len())
            .map(|k| {
                let own: Vec<usize> = (0..segments.len()).filter(|s| segments[*s].log == k).collect();
                coarse::LogView {
                    segments: own.iter().map(|s| &segments[*s]).collect(),
                    speed_mps: own.iter().map(|s| speeds[*s].as_slice()).collect(),
                    command: &surveys[k].track.command_nm,
                }
            })
            .collect();
        let (dead_time_s, lag_s) = coarse::search(&views, &noise, settings.dead_time_s, settings.lag_s);
        calibration.dead_time_s = dead_time_s;
        calibration.lag_s = lag_s;
        hold_known(&mut calibration, surveys, settings);
    }

    let lattice = lattice_of(&segments, &speeds, surveys, settings)?;
    let design = Design::new(&lattice, gears.len() > 1);
    let zero = LatticeSurface { theta: vec![0.0; lattice.columns()], lattice };
    let mut surfaces = [zero.clone(), zero];
    let prior = nuisance_prior_std(logs.len(), has_yaw);
    let mut penalties: Vec<f64> = Vec::new();
    let mut noise_bounds = Vec::new();
    let mut last: Option<(Solution, System)> = None;
    let mut have_surface = false;
    let (mut iterations, mut converged) = (0, false);
    let (mut dead_time_std_err_s, mut lag_std_err_s, mut encoder_scale_std_err) = (vec![0.0; logs.len()], 0.0, 0.0);
    let mut final_parts = None;

    let (chosen, sampled) = sampling::choose(surveys);
    for (log, chosen) in logs.iter_mut().zip(&chosen) {
        log.chosen.clone_from(chosen);
    }
    // delays free on the sample, once more on everything where the sample left something out, then delays fixed and transients cut
    let schedule = [(0, settings.iterations[0]), (0, usize::from(sampled)), (1, settings.iterations[1])];
    for (phase, (stage, rounds)) in schedule.into_iter().enumerate() {
        if phase == 1 {
            for log in &mut logs {
                log.chosen.fill(true);
            }
        }
        for round in 0..rounds {
            iterations += 1;
            let lagged: Vec<LaggedCommand> = surveys.iter().map(|s| LaggedCommand::new(&s.track.command_nm, calibration.lag_s)).collect();
            let cut = if stage == 0 { none.clone() } else { transients(&lagged, &calibration, surveys, settings) };
            let known = have_surface.then_some(&surfaces);
            // robust cuts: each time from all readings, so that an early mistake is taken back
            if have_surface && ((stage == 0 && (round >= 2 || phase == 1)) || (stage == 1 && round == 0)) {
                let threshold = if stage == 0 && (round == 2 || phase == 1) { 6.0 } else { 5.0 };
                for log in &mut logs {
                    log.cuts = Cuts::default();
                }
                // judged without the moments after steps, which no static map explains
                let steps = transients(&lagged, &calibration, surveys, settings);
                let judged = Way { lagged: &lagged, calibration: &calibration, surfaces: &surfaces, noise: &calm(&noise, &surfaces[0]) };
                let mut suspects: Option<BTreeSet<(usize, usize)>> = None;
                for pass in 0..robust::PASSES {
                    let mut segments = build(&logs, &calibration, &lagged, known, &steps);
                    segments.retain(|s| suspects.as_ref().is_none_or(|runs| runs.contains(&(s.log, s.run))));
                    let whole = pass + 1 == robust::PASSES;
                    let white = judged.along(&segments, None).white;
                    let cut = |(s, white): (&Segment, &Vec<f64>)| {
                        robust::find(s, white, threshold, whole, &mut logs[s.log].cuts).then_some((s.log, s.run))
                    };
                    let found: BTreeSet<(usize, usize)> = segments.iter().zip(&white).filter_map(cut).collect();
                    if found.is_empty() {
                        break;
                    }
                    suspects = Some(found);
                }
                for log in &mut logs {
                    robust::join(&mut log.cuts);
                }
            }
            let segments = build(&logs, &calibration, &lagged, known, &cut);
            let way = Way { lagged: &lagged, calibration: &calibration, surfaces: &surfaces, noise: &noise };
            let speeds = if have_surface { way.along(&segments, None).speeds } else { wide_speeds(&segments) };
            let with_nuisance = stage == 0 && have_surface;
            // the last sums are kept apart by fold for the cross-validation
            let (fold, folds) = if stage == 1 { validation::deal(&segments) } else { (vec![0; segments.len()], 1) };
            let parts = way.assemble(&segments, &speeds, with_nuisance, logs.len(), (&fold, folds));
            let grams = total(&parts);
            let nuisances = if with_nuisance { prior.len() } else { 0 };
            let pairs: Vec<(Gear, &Gram)> = gears.iter().map(|g| (*g, &grams[usize::from(*g == Gear::Reverse)])).collect();
            let system = System::new(&design, &pairs, nuisances);
            let updates = if stage == 1 { 50 } else { 4 };
            if stage == 1 && round == 0 {
                penalties.clear();
            }
            let solution = system.solve(&design.blocks, &penalties, updates, &prior[..nuisances]).ok_or(Error::Singular)?;
            penalties.clone_from(&solution.penalties);
            if with_nuisance {
                step_nuisance(&solution, design.coefficients(), settings, has_yaw, &mut calibration);
                hold_known(&mut calibration, surveys, settings);
                let std_err = |k: usize| solution.covariance[(design.coefficients() + k, design.coefficients() + k)].max(0.0).sqrt();
                lag_std_err_s = std_err(nuisance::LAG);
                encoder_scale_std_err = std_err(nuisance::ENCODER_SCALE);
                dead_time_std_err_s = (0..logs.len()).map(|k| std_err(nuisance::DEAD_TIME + k)).collect();
            }
            let next = Gear::ALL.map(|g| LatticeSurface {
                lattice: surfaces[0].lattice.clone(),
                theta: design.lattice_values(g, &solution.beta[..design.coefficients()]),
            });
            let way = Way { lagged: &lagged, calibration: &calibration, surfaces: &next, noise: &noise };
            let moved = way.movement(&segments, &speeds, &surfaces);
            let Along { speeds, residuals, white } = way.along(&segments, Some(&speeds));
            surfaces = next;
            have_surface = true;
            // noise: updates with delays free, one more with transients cut
            if (phase == 0 && (1..=4).contains(&round)) || (stage == 1 && round == 0) {
                // before the first cuts pushes and slips are still in: only what is well explained tells the noise
                let share = if stage == 0 { 0.6 } else { 0.85 };
                let (kept, kept_residuals) = well_explained(&segments, &residuals, &white, share);
                let spread = offset_spread(&segments, &residuals, &noise);
                let found = hyper::estimate(&kept, &kept_residuals, noise, spread);
                noise = found.noise;
                noise_bounds = found.at_bounds;
            }
            let offsets = offsets_of(&segments, &residuals, &noise);
            last = Some((solution, system));
            final_parts = Some((segments, speeds, offsets, white, cut, fold, parts));
            converged = moved < STILL_MPS2;
            if converged && round >= if stage == 0 { 5 } else { 1 } {
                break;
            }
        }
    }
    let (mut solution, system) = last.ok_or(Error::Singular)?;
    let (segments, mut speeds, mut offsets, mut white, transients, fold, parts) = final_parts.ok_or(Error::Singular)?;
    let lagged: Vec<LaggedCommand> = surveys.iter().map(|s| LaggedCommand::new(&s.track.command_nm, calibration.lag_s)).collect();
    let validation = {
        let torque = |s: &Segment, t: f64| s.gear.sign() * lagged[s.log].at(t - calibration.dead_time_s[s.log]).torque_nm;
        let along = validation::Along { segments: &segments, speeds: &speeds, torque: &torque, noise: &noise };
        validation::validate(&design, &surfaces[0].lattice, &gears, (&fold, &parts), (&system, &solution), &along)
    };
    if validation.as_ref().is_some_and(|v| v.comparison.plain_alone) {
        let penalties = validation::plain_penalties(&design.blocks, &solution.penalties);
        solution = system.solve(&design.blocks, &penalties, 50, &[]).ok_or(Error::Singular)?;
        surfaces = Gear::ALL.map(|g| LatticeSurface {
            lattice: surfaces[0].lattice.clone(),
            theta: design.lattice_values(g, &solution.beta[..design.coefficients()]),
        });
        let residuals;
        let way = Way { lagged: &lagged, calibration: &calibration, surfaces: &surfaces, noise: &noise };
        Along { speeds, residuals, white } = way.along(&segments, Some(&speeds));
        offsets = offsets_of(&segments, &residuals, &noise);
    }
    Ok(Estimate {
        logs,
        design,
        calibration,
        dead_time_std_err_s,
        lag_std_err_s,
        encoder_scale_std_err,
        noise,
        noise_bounds,
        gears,
        surfaces,
        solution,
        system,
        segments,
        speeds,
        offsets,
        white,
        transients,
        iterations,
        converged,
        has_yaw,
        validation,
    })
}

/// The rate of a speed signal that is too slow to tell accelerations by itself [Hz]; `None` when it is fast enough.
pub(crate) fn slow_rate_hz(survey: &Survey) -> Option<f64> {
    let gaps: Vec<f64> = survey.track.encoder_mps.t_s.windows(2).map(|t| t[1] - t[0]).collect();
    let rate_hz = if gaps.is_empty() { 0.0 } else { 1.0 / crate::signal::median(&gaps) };
    (rate_hz < SLOW_HZ).then_some(rate_hz)
}

fn log_data(survey: &Survey) -> LogData<'_> {
    let yaw_outliers = survey.track.yaw_speed_mps.as_ref().map(hampel).unwrap_or_default();
    let encoder = &survey.track.encoder_mps.value;
    let dithered = noise_std(encoder) > 0.2 * quantum(encoder);
    let may_anchor = survey.track.yaw_speed_mps.is_some() || quantum(encoder) < COARSE_QUANTUM_MPS || dithered;
    LogData { survey, yaw_outliers, cuts: Cuts::default(), may_anchor, chosen: vec![true; survey.stretches.len()] }
}

/// Hampel's rule at 6 scaled median absolute deviations over ±3 readings.
fn hampel(series: &Series) -> Vec<bool> {
    let floor = noise_std(&series.value).max(quantum(&series.value)).max(1e-6);
    let n = series.len();
    (0..n)
        .map(|i| {
            let range = i.saturating_sub(3)..(i + 4).min(n);
            let centre = crate::signal::median(&series.value[range.clone()]);
            let spread: Vec<f64> = series.value[range].iter().map(|v| (v - centre).abs()).collect();
            (series.value[i] - centre).abs() > 6.0 * (1.4826 * crate::signal::median(&spread)).max(floor)
        })
        .collect()
}

fn first_calibration(surveys: &[Survey]) -> Calibration {
    let alignments: Vec<_> = surveys.iter().filter_map(|s| s.alignment).collect();
    let median_of = |f: fn(&crate::signal::Alignment) -> f64, otherwise: f64| {
        let values: Vec<f64> = alignments.iter().map(f).collect();
        if values.is_empty() { otherwise } else { crate::signal::median(&values) }
    };
    Calibration {
        dead_time_s: vec![0.05; surveys.len()],
        lag_s: 0.05,
        encoder_scale: median_of(|a| a.scale, 1.0),
        encoder_delay_s: median_of(|a| a.delay_s, 0.0),
    }
}

/// What runs at other wheel angles have told stays as it is.
fn hold_known(calibration: &mut Calibration, surveys: &[Survey], settings: &Settings) {
    if let Some(known) = &settings.known {
        known.hold(calibration, surveys);
    }
}

fn first_noise(surveys: &[Survey]) -> Noise {
    let largest = |f: &dyn Fn(&Survey) -> Option<f64>| surveys.iter().filter_map(f).fold(0.0, f64::max).clamp(1e-3, 0.1);
    let reading = |s: &Series| noise_std(&s.value).max(quantum(&s.value) / 12f64.sqrt());
    Noise {
        disturbance_mps2: 0.15,
        disturbance_time_s: 0.3,
        offset_mps2: 0.05,
        reading_mps: [largest(&|s| Some(reading(&s.track.encoder_mps))), largest(&|s| s.track.yaw_speed_mps.as_ref().map(reading))],
    }
}

fn span_s(segment: &Segment) -> f64 {
    segment.readings.last().map_or(0.0, |r| r.t_s - segment.start_s)
}

fn build(
    logs: &[LogData],
    calibration: &Calibration,
    lagged: &[LaggedCommand],
    surfaces: Option<&[LatticeSurface; 2]>,
    transients: &[Vec<(f64, f64)>],
) -> Vec<Segment> {
    logs.iter().enumerate().flat_map(|(k, log)| log.segments(k, calibration, &lagged[k], surfaces, &transients[k])).collect()
}

fn step_nuisance(solution: &Solution, q: usize, settings: &Settings, has_yaw: bool, calibration: &mut Calibration) {
    let step = |k: usize| solution.beta[q + k].clamp(-DELAY_STEP_S, DELAY_STEP_S);
    if settings.lag_s.is_none() {
        calibration.lag_s = (calibration.lag_s + step(nuisance::LAG)).clamp(0.0, 0.3);
    }
    if settings.dead_time_s.is_none() {
        for (k, dead_time) in calibration.dead_time_s.iter_mut().enumerate() {
            *dead_time = (*dead_time + step(nuisance::DEAD_TIME + k)).clamp(-0.1, 0.5);
        }
    }
    if has_yaw {
        calibration.encoder_scale *= 1.0 + solution.beta[q + nuisance::ENCODER_SCALE].clamp(-0.02, 0.02);
        calibration.encoder_delay_s = (calibration.encoder_delay_s + step(nuisance::ENCODER_DELAY)).clamp(-0.3, 0.3);
    }
}

/// The `share` of the segments that the surface explains best by mean square innovation, so that pushes and slips do not pass for noise.
fn well_explained(segments: &[Segment], residuals: &[Vec<f64>], white: &[Vec<f64>], share: f64) -> (Vec<Segment>, Vec<Vec<f64>>) {
    let score: Vec<f64> = white.iter().map(|w| w.iter().map(|e| e * e).sum::<f64>() / w.len().max(1) as f64).collect();
    let mut sorted = score.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let limit = sorted[((sorted.len() as f64 * share) as usize).min(sorted.len() - 1)];
    let kept: Vec<usize> = (0..segments.len()).filter(|k| score[*k] <= limit).collect();
    (kept.iter().map(|k| segments[*k].clone()).collect(), kept.iter().map(|k| residuals[*k].clone()).collect())
}

/// The noise for judging what does not belong: offset and disturbance at most a fiftieth of the accelerations that the torque commands, so
/// that a push, which is a disturbance, does not explain itself.
fn calm(noise: &Noise, surface: &LatticeSurface) -> Noise {
    let torques = &surface.lattice.torque_nm;
    let range = surface.accel_mps2(0.0, torques[torques.len() - 1]) - surface.accel_mps2(0.0, torques[0]);
    let most = (0.02 * range.abs()).max(0.01);
    Noise { disturbance_mps2: noise.disturbance_mps2.min(most), offset_mps2: noise.offset_mps2.min(most), ..*noise }
}

/// Spread of the runs' offsets [m/s²]: what σ_b cannot exceed.
fn offset_spread(segments: &[Segment], residuals: &[Vec<f64>], noise: &Noise) -> f64 {
    let loose = Noise { offset_mps2: 1.0, ..*noise };
    let offsets: Vec<f64> = segments
        .iter()
        .zip(residuals)
        .filter(|(s, _)| span_s(s) > 0.5)
        .map(|(s, r)| smooth(r, &s.readings, s.start_s, &loose, s.start_std_mps).offset_mps2)
        .collect();
    let centre = crate::signal::median(&offsets);
    let spread: Vec<f64> = offsets.iter().map(|o| (o - centre).abs()).collect();
    if spread.len() < 4 { 0.2 } else { 2.0 * 1.4826 * crate::signal::median(&spread) }
}

fn transients(lagged: &[LaggedCommand], calibration: &Calibration, surveys: &[Survey], settings: &Settings) -> Vec<Vec<(f64, f64)>> {
    lagged
        .iter()
        .zip(surveys)
        .enumerate()
        .map(|(k, (lagged, survey))| {
            let largest = survey.track.command_nm.value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            let dead = calibration.dead_time_s[k];
            lagged.steps(0.05 * largest).into_iter().map(|t| (t + dead, t + dead + settings.transient_s)).collect()
        })
        .collect()
}

/// The lattice over the speeds and torques of the segments.
fn lattice_of(segments: &[Segment], speeds: &[Vec<f64>], surveys: &[Survey], settings: &Settings) -> Result<Lattice> {
    let fastest = speeds.iter().flatten().fold(0.0f64, |m, v| m.max(*v));
    let (mut low, mut high) = (0.0f64, 0.0f64);
    let mut torques = Vec::new();
    for s in segments {
        let command = &surveys[s.log].track.command_nm;
        if let (Some(first), Some(last)) = (s.readings.first(), s.readings.last()) {
            for k in command.range(first.t_s, last.t_s) {
                let u = s.gear.sign() * command.value[k];
                low = low.min(u);
                high = high.max(u);
                torques.push(u);
            }
        }
    }
    let (least, most) = torques.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| (a.min(*u), b.max(*u)));
    if most - least < 1e-6 * most.abs().max(1e-9) || high - low <= 0.0 {
        let torque_nm = most;
        return Err(Error::OneTorque { torque_nm, suggestion_nm: 0.5 * torque_nm, suggestion2_nm: 1.5 * torque_nm });
    }
    Ok(Lattice::new(fastest, low, high, settings.speed_nodes, settings.torque_nodes))
}
