//! Before the first round: the logs' signals, first guesses of calibration and noise, dead time and lag from a coarse search, the lattice.

use crate::campaign::{SampleVerdict, Survey};
use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::speed_limit::SpeedLimit;
use crate::fit::drive::step_timing::StepTiming;
use crate::fit::drive::torque_input::{TorqueChoice, TorqueInput};
use crate::fit::drive_form::campaign_drift::{CampaignDrift, CampaignProgress, Progress};
use crate::fit::drive_form::drive_model::DriveModel;
use crate::fit::motion::log_data::{Cuts, LogData};
use crate::fit::motion::passes::wide_speed;
use crate::fit::motion::segment::Segment;
use crate::fit::motion::segmentation::all_segments;
use crate::fit::noise::model::{Noise, Reading};
use crate::fit::rounds::delay_grid::{self, KnownDrive};
use crate::fit::surface::lattice::Lattice;
use crate::fit::{Error, FitSettings, Result};
use crate::map::{Gear, PerGear};
use crate::signal::{Series, noise_std, quantum};
use rayon::prelude::*;

/// Steps of speed below this are fine [m/s]: over a few readings any motion crosses them.
const COARSE_QUANTUM_MPS: f64 = 0.004;
/// Noise of this share of a step makes readings as good as continuous.
const DITHERED: f64 = 0.2;
/// A speed signal slower than this cannot follow a lag of some 50 ms [Hz]. It shows accelerations where the torque holds.
const SLOW_HZ: f64 = 10.0;
/// The slowest that is usable [Hz]: one at 5 Hz, with losses.
const SLOWEST_HZ: f64 = 4.5;
/// A slower signal must show a usual hold by so many readings.
const READINGS_OF_HOLD: f64 = 8.0;
/// Least time in motion for a fit [s].
const LEAST_MOTION_S: f64 = 5.0;

/// Start of the rounds.
pub(crate) struct InitialGuess<'a> {
    pub(crate) logs: Vec<LogData<'a>>,
    /// The end of the campaign.
    pub(crate) end: PerGear<Progress>,
    pub(crate) gears: Vec<Gear>,
    pub(crate) has_yaw: bool,
    pub(crate) calibration: Calibration,
    pub(crate) noise: Noise,
    pub(crate) lattice: Lattice,
    /// Lag by the torque feedback, with its standard error [s].
    pub(crate) feedback_lag: Option<(f64, f64)>,
    /// Whitened squared error of the small model with the drive found.
    pub(crate) deviance: f64,
}

/// The logs as they are before dead times and drive are known.
pub(crate) struct Examined<'a> {
    logs: Vec<LogData<'a>>,
    end: PerGear<Progress>,
    gears: Vec<Gear>,
    has_yaw: bool,
    calibration: Calibration,
    noise: Noise,
    segments: Vec<Segment>,
    /// Speeds along the segments from their readings alone [m/s].
    speeds: Vec<Vec<f64>>,
    lattice: Lattice,
}

impl<'a> Examined<'a> {
    /// Examines the surveys.
    ///
    /// # Errors
    /// A slow speed signal without a yaw rate, too little motion, one torque only.
    pub(crate) fn new(surveys: &'a [Survey], choice: &TorqueChoice, settings: &FitSettings) -> Result<Self> {
        if let Some((survey, rate_hz)) =
            surveys.iter().filter(|s| s.track.yaw_speed_mps.is_none()).find_map(|s| Some((s, useless_rate_hz(s)?)))
        {
            return Err(Error::SlowSpeed { file: survey.track.source.file.clone(), rate_hz, needed_hz: SLOW_HZ });
        }
        let grains: Vec<Grains> = surveys.iter().map(Grains::of).collect();
        let progress = CampaignProgress::of(surveys);
        let logs: Vec<LogData> = surveys.iter().zip(&grains).zip(progress.stretches).map(|((s, g), p)| log_data(s, g, p, choice)).collect();
        let end = progress.end;
        let gears = Gear::ALL.into_iter().filter(|g| surveys.iter().any(|s| s.stretches.iter().any(|r| r.gear == *g))).collect();
        let mut calibration = first_calibration(surveys, choice);
        hold_known(&mut calibration, &logs, settings);
        let noise = first_noise(&grains);
        let lagged: Vec<EffectiveTorque> = logs.iter().map(|l| l.torque(&calibration.drive, calibration.drift)).collect();
        let segments = all_segments(&logs, &calibration, &lagged, None, &vec![Vec::new(); logs.len()]);
        let seconds: f64 = segments.iter().map(Segment::span_s).sum();
        if seconds < LEAST_MOTION_S {
            return Err(Error::TooLittle { seconds, needed_s: LEAST_MOTION_S });
        }
        let speeds: Vec<Vec<f64>> = segments.par_iter().map(wide_speed).collect();
        let lattice = lattice_of(&segments, &speeds, surveys, settings)?;
        let has_yaw = surveys.iter().any(|s| s.track.yaw_speed_mps.is_some());
        Ok(Self { logs, end, gears, has_yaw, calibration, noise, segments, speeds, lattice })
    }

    /// The first guess with the best of some drives, `beside` one that is known already; a known lag and a feedback leave no choice.
    pub(crate) fn guess(
        &self,
        choice: &TorqueChoice,
        settings: &FitSettings,
        drives: &[DriveModel],
        beside: Option<KnownDrive>,
    ) -> InitialGuess<'a> {
        self.guess_from(&self.all_spread_out(), (choice, settings), drives, beside)
    }

    /// The same from the segments of most power first: those that show a limit of it. A limit acts in few of them.
    pub(crate) fn guess_of_most_power(
        &self,
        choice: &TorqueChoice,
        settings: &FitSettings,
        drives: &[DriveModel],
        beside: KnownDrive,
    ) -> InitialGuess<'a> {
        self.guess_from(&self.by_power(), (choice, settings), drives, Some(beside))
    }

    /// The numbers of the segments in an order in which any first part is spread over the whole.
    fn all_spread_out(&self) -> Vec<usize> {
        let own = |log: usize| -> Vec<usize> { (0..self.segments.len()).filter(|s| self.segments[*s].log == log).collect() };
        (0..self.logs.len()).flat_map(|log| spread_out(&own(log))).collect()
    }

    /// The numbers of the segments: that of most driving power, one of all, and so on, so that both the limited and the usual are at the front.
    fn by_power(&self) -> Vec<usize> {
        let power = |s: usize| {
            let (segment, speeds) = (&self.segments[s], &self.speeds[s]);
            let mut command = self.logs[segment.log].survey.track.command_nm.cursor();
            let of = |(reading, v): (&Reading, &f64)| command.held(reading.t_s).unwrap_or(0.0) * segment.gear.sign() * v;
            segment.readings.iter().zip(speeds).map(of).fold(0.0, f64::max)
        };
        let powers: Vec<f64> = (0..self.segments.len()).map(power).collect();
        let mut by_power: Vec<usize> = (0..self.segments.len()).collect();
        by_power.sort_by(|a, b| powers[*b].total_cmp(&powers[*a]));
        let mut taken = vec![false; self.segments.len()];
        let in_turn = by_power.into_iter().zip(self.all_spread_out()).flat_map(|(strong, usual)| [strong, usual]);
        in_turn.filter(|s| !std::mem::replace(&mut taken[*s], true)).collect()
    }

    fn guess_from(
        &self,
        order: &[usize],
        (choice, settings): (&TorqueChoice, &FitSettings),
        drives: &[DriveModel],
        beside: Option<KnownDrive>,
    ) -> InitialGuess<'a> {
        let views: Vec<delay_grid::GridLog> = (0..self.logs.len())
            .map(|k| {
                let own: Vec<usize> = order.iter().copied().filter(|s| self.segments[*s].log == k).collect();
                delay_grid::GridLog {
                    segments: own.iter().map(|s| &self.segments[*s]).collect(),
                    speed_mps: own.iter().map(|s| self.speeds[*s].as_slice()).collect(),
                    log: &self.logs[k],
                }
            })
            .collect();
        let found = delay_grid::search(&views, &self.noise, &drives_to_try(choice, settings, drives), beside);
        let mut calibration = self.calibration.clone();
        (calibration.dead_time_s, calibration.drive) = (found.dead_time_s, found.drive);
        hold_known(&mut calibration, &self.logs, settings);
        InitialGuess {
            logs: self.logs.clone(),
            end: self.end,
            gears: self.gears.clone(),
            has_yaw: self.has_yaw,
            calibration,
            noise: self.noise,
            lattice: self.lattice.clone(),
            feedback_lag: choice.feedback_lag(),
            deviance: found.deviance,
        }
    }
}

/// The same in an order in which any first part is spread over the whole: by the fractional parts of multiples of the golden ratio (Weyl).
fn spread_out(all: &[usize]) -> Vec<usize> {
    let place = |k: usize| (k as f64 * 0.5 * (5f64.sqrt() - 1.0)).fract();
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|a, b| place(*a).total_cmp(&place(*b)));
    // the k-th one taken has the rank of the k-th multiple
    let mut taken = vec![0; all.len()];
    for (own, k) in all.iter().zip(order) {
        taken[k] = *own;
    }
    taken
}

/// The drives among which the coarse search chooses; a single one where it is known, or where the feedback already holds the drive.
fn drives_to_try(choice: &TorqueChoice, settings: &FitSettings, drives: &[DriveModel]) -> Vec<DriveModel> {
    match settings.lag_s {
        _ if choice.is_feedback() => vec![DriveModel::first_order(0.0)],
        Some(lag_s) => {
            let mut all: Vec<DriveModel> = drives.iter().map(|d| DriveModel { limit: d.limit, ..DriveModel::first_order(lag_s) }).collect();
            all.dedup();
            all
        }
        None => drives.to_vec(),
    }
}

/// The largest torque of the commands [N·m].
pub(crate) fn largest_nm(surveys: &[Survey]) -> f64 {
    let commands = surveys.iter().flat_map(|s| &s.track.command_nm.value);
    commands.fold(0.0f64, |m, v| m.max(v.abs())).max(1e-9)
}

/// The largest driving torque times speed of the samples in use [N·m·m/s].
pub(crate) fn largest_power(surveys: &[Survey]) -> f64 {
    let of = |survey: &Survey| {
        let (encoder, mut command) = (&survey.track.encoder_mps, survey.track.command_nm.cursor());
        let used = (0..encoder.len()).filter(|k| survey.verdicts[*k] == SampleVerdict::Used);
        used.map(|k| command.held(encoder.t_s[k]).unwrap_or(0.0) * encoder.value[k]).fold(0.0f64, f64::max)
    };
    surveys.iter().map(of).fold(0.0, f64::max)
}

/// Copies the delays and the encoder's calibration from runs at other wheel angles into `calibration`, whose logs are `logs`.
pub(crate) fn hold_known(calibration: &mut Calibration, logs: &[LogData], settings: &FitSettings) {
    let Some(known) = &settings.known else { return };
    for (dead_time_s, log) in calibration.dead_time_s.iter_mut().zip(logs) {
        if let Some(known) = known.dead_time_s.get(&log.survey.track.source.sha256) {
            *dead_time_s = *known;
        }
    }
    if let Some(drive) = known.drive {
        calibration.drive = drive;
    }
    if let Some((scale, delay_s)) = known.encoder {
        calibration.encoder_scale = scale;
        calibration.encoder_delay_s = delay_s;
    }
}

/// The rate of a speed signal that is too slow to show accelerations by itself [Hz]; `None` when it is fast enough.
pub(crate) fn slow_rate_hz(survey: &Survey) -> Option<f64> {
    let gaps: Vec<f64> = survey.track.encoder_mps.t_s.windows(2).map(|t| t[1] - t[0]).collect();
    let rate_hz = if gaps.is_empty() { 0.0 } else { 1.0 / crate::signal::median(&gaps) };
    (rate_hz < SLOW_HZ).then_some(rate_hz)
}

/// The same, of a signal that shows no accelerations even where the torque holds.
fn useless_rate_hz(survey: &Survey) -> Option<f64> {
    let holds: Vec<f64> = survey.stretches.iter().map(|s| s.to_s - s.from_s).collect();
    let is_enough = |rate_hz: f64| rate_hz > SLOWEST_HZ && !holds.is_empty() && crate::signal::median(&holds) * rate_hz >= READINGS_OF_HOLD;
    slow_rate_hz(survey).filter(|rate_hz| !is_enough(*rate_hz))
}

/// Resolution of a speed source.
struct Grain {
    noise_mps: f64,
    quantum_mps: f64,
}

impl Grain {
    fn of(series: &Series) -> Self {
        Self { noise_mps: noise_std(&series.value), quantum_mps: quantum(&series.value) }
    }

    /// The step of readings whose noise it hides [m/s]; 0 where noise makes them as good as continuous.
    fn coarse_mps(&self) -> f64 {
        if self.noise_mps > DITHERED * self.quantum_mps || self.quantum_mps < COARSE_QUANTUM_MPS { 0.0 } else { self.quantum_mps }
    }
}

/// The same for the speed sources of one log.
struct Grains {
    encoder: Grain,
    yaw: Option<Grain>,
}

impl Grains {
    fn of(survey: &Survey) -> Self {
        Self { encoder: Grain::of(&survey.track.encoder_mps), yaw: survey.track.yaw_speed_mps.as_ref().map(Grain::of) }
    }
}

fn log_data<'a>(survey: &'a Survey, grains: &Grains, progress: Vec<Progress>, choice: &TorqueChoice) -> LogData<'a> {
    let yaw_outliers = survey.track.yaw_speed_mps.as_ref().zip(grains.yaw.as_ref()).map(|(yaw, grain)| hampel(yaw, grain));
    let coarse_mps = [grains.encoder.coarse_mps(), grains.yaw.as_ref().map_or(0.0, Grain::coarse_mps)];
    LogData {
        survey,
        command: changes(&survey.track.command_nm),
        input: choice.of(&survey.track.source),
        yaw_outliers: yaw_outliers.unwrap_or_default(),
        instead: choice.instead(&survey.track),
        undelivered_s: undelivered_s(choice, survey),
        governed_from_mps: choice.speed_limit().map_or(f64::INFINITY, SpeedLimit::onset_mps),
        timing: StepTiming::new(&survey.track.command_nm).unsure(survey.track.command_std_s),
        cuts: Cuts::default(),
        coarse_mps,
        progress,
        chosen: vec![true; survey.stretches.len()],
    }
}

/// Where the drive did not deliver, with starts and ends that rise: by a feedback where the command is the input, and by a governor unless the
/// input is a feedback that shows what is delivered.
fn undelivered_s(choice: &TorqueChoice, survey: &Survey) -> Vec<(f64, f64)> {
    let input = choice.of(&survey.track.source);
    let found = if input == TorqueInput::Command { choice.undelivered(&survey.track.source) } else { &[] };
    let governed = choice.speed_limit().filter(|_| !choice.is_for_undelivered()).map(|limit| limit.undelivered_s(survey));
    let mut all: Vec<(f64, f64)> = found.iter().map(|u| (u.from_s, u.to_s)).chain(governed.into_iter().flatten()).collect();
    all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    for k in 1..all.len() {
        all[k].1 = all[k].1.max(all[k - 1].1);
    }
    all
}

/// Hampel's rule at 6 scaled median absolute deviations over ±3 readings.
fn hampel(series: &Series, grain: &Grain) -> Vec<bool> {
    crate::signal::hampel(&series.value, 6.0, grain.noise_mps.max(grain.quantum_mps).max(1e-6))
}

/// The samples of a command that differ from the one before.
fn changes(command: &Series) -> Series {
    let mut changes = Series::default();
    for (t_s, value) in command.t_s.iter().zip(&command.value) {
        if changes.value.last() != Some(value) {
            changes.t_s.push(*t_s);
            changes.value.push(*value);
        }
    }
    changes
}

fn first_calibration(surveys: &[Survey], choice: &TorqueChoice) -> Calibration {
    let alignments: Vec<_> = surveys.iter().filter_map(|s| s.alignment).collect();
    let median_of = |f: fn(&crate::signal::Alignment) -> f64, otherwise: f64| {
        let values: Vec<f64> = alignments.iter().map(f).collect();
        if values.is_empty() { otherwise } else { crate::signal::median(&values) }
    };
    // a feedback is used as it is
    let delay_s = if choice.is_feedback() { 0.0 } else { 0.05 };
    Calibration {
        dead_time_s: vec![delay_s; surveys.len()],
        drive: DriveModel::first_order(delay_s),
        drift: CampaignDrift::default(),
        encoder_scale: median_of(|a| a.scale, 1.0),
        encoder_delay_s: median_of(|a| a.delay_s, 0.0),
    }
}

fn first_noise(grains: &[Grains]) -> Noise {
    let largest = |f: &dyn Fn(&Grains) -> Option<f64>| grains.iter().filter_map(f).fold(0.0, f64::max).clamp(1e-3, 0.1);
    let reading = |grain: &Grain| grain.noise_mps.max(grain.quantum_mps / 12f64.sqrt());
    Noise {
        disturbance_mps2: 0.15,
        disturbance_time_s: 0.3,
        offset_mps2: 0.05,
        reading_mps: [largest(&|g| Some(reading(&g.encoder))), largest(&|g| g.yaw.as_ref().map(reading))],
        start_scale: 1.0,
    }
}

/// The lattice over the speeds and torques of the segments.
fn lattice_of(segments: &[Segment], speeds: &[Vec<f64>], surveys: &[Survey], settings: &FitSettings) -> Result<Lattice> {
    let fastest = speeds.iter().flatten().fold(0.0f64, |m, v| m.max(*v));
    let (mut low, mut high) = (0.0f64, 0.0f64);
    let mut torques = Vec::new();
    for s in segments {
        let command = &surveys[s.log].track.command_nm;
        if let (Some(first), Some(last)) = (s.readings.first(), s.readings.last()) {
            // with the command in force at the start
            let inside = command.range(first.t_s, last.t_s).map(|k| command.value[k]);
            for value in command.held(first.t_s).into_iter().chain(inside) {
                let u = s.gear.sign() * value;
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
