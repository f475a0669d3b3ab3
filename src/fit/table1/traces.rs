//! The traces of a fit for a report: the runs, residuals over the cells and over time. Read only; the estimate does not change.

use crate::campaign::{Hold, SampleVerdict, runs};
use crate::fit::Result;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::motion::integration::Course;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::table1::angle_fit::AngleFit;
use crate::fit::table1::runs::{Compared, round};
use crate::map::{AccelMap, Axis, Gear, ResidualCells, ResidualTimes, RunRow, RunTrace};
use crate::units::RAD_PER_DEG;

/// Most traces: a page with more is not readable.
const MOST_RUNS: usize = 500;
/// Points of all traces together, and the fewest and most of one.
const POINTS: usize = 10_000;
const POINTS_OF_RUN: (usize, usize) = (20, 60);
/// Shown before and after a run [s].
const MARGIN_S: f64 = 0.2;
/// Residuals over time, all logs together.
const MOST_RESIDUALS: usize = 3000;
/// A simulated speed belongs to a time within this distance [s].
const NEAR_S: f64 = 0.05;

/// The traces of one wheel angle.
pub(crate) struct AngleTraces {
    /// Traces of the runs, each with the place of its row among the angle's own.
    pub(crate) runs: Vec<RunTrace>,
    pub(crate) residual_cells: Vec<ResidualCells>,
    pub(crate) residual_times: Vec<ResidualTimes>,
}

impl AngleTraces {
    /// Of a finished fit.
    ///
    /// # Errors
    /// Invalid axes.
    pub(crate) fn new(fit: &AngleFit) -> Result<Self> {
        let windows = windows(&fit.estimate);
        Ok(Self {
            runs: run_traces(fit),
            residual_cells: fit.maps.iter().map(|m| residual_cells(m, &windows)).collect::<Result<_>>()?,
            residual_times: residual_times(&fit.estimate, &windows),
        })
    }
}

/// The rows that are shown: all, or those with the largest residual.
fn shown(rows: &[RunRow]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rows.len()).collect();
    if rows.len() > MOST_RUNS {
        let size = |k: usize| rows[k].speed_rmse_mps.unwrap_or(-1.0);
        order.sort_by(|a, b| size(*b).total_cmp(&size(*a)).then(a.cmp(b)));
        order.truncate(MOST_RUNS);
        order.sort_unstable();
    }
    order
}

fn run_traces(fit: &AngleFit) -> Vec<RunTrace> {
    let AngleFit { estimate, compared, verdicts, .. } = fit;
    let shown = shown(&fit.figures.rows);
    let points = (POINTS / shown.len().max(1)).clamp(POINTS_OF_RUN.0, POINTS_OF_RUN.1);
    let lagged = estimate.torques();
    let mut traces = Vec::new();
    let mut row = 0;
    for (k, log) in estimate.data.logs.iter().enumerate() {
        let simulated = &compared[compared.partition_point(|c| c.log < k)..compared.partition_point(|c| c.log <= k)];
        for (hold, run) in runs(log.survey, &verdicts[k], estimate.calibration.encoder_scale) {
            if shown.binary_search(&row).is_ok() {
                traces.push(run_trace(estimate, (k, &lagged[k]), &verdicts[k], simulated, (row, &hold, run.gear), points));
            }
            row += 1;
        }
    }
    traces
}

fn run_trace(
    estimate: &Estimate,
    (log, lagged): (usize, &EffectiveTorque),
    verdicts: &[SampleVerdict],
    simulated: &[Compared],
    (row, hold, gear): (usize, &Hold, Gear),
    points: usize,
) -> RunTrace {
    let track = &estimate.data.logs[log].survey.track;
    let calibration = &estimate.calibration;
    let (from_s, to_s) = (hold.from_s - MARGIN_S, hold.to_s + MARGIN_S);
    let encoder = &track.encoder_mps;
    let samples = encoder.range(from_s, to_s);
    let stride = samples.len().div_ceil(points).max(1);
    let kept: Vec<usize> = samples.clone().step_by(stride).collect();
    let time = |i: usize| encoder.t_s[i] - calibration.encoder_delay_s;
    let each = |f: &dyn Fn(usize) -> f64, steps: f64| kept.iter().map(|i| round(f(*i), steps)).collect::<Vec<f64>>();

    let commanded = &track.command_nm;
    let mut command: Vec<[f64; 2]> = Vec::new();
    let mut change = |t: f64, v: f64| {
        if command.last().is_none_or(|c| c[1] != v) {
            command.push([round(t, 1e3), v]);
        }
    };
    change(from_s.max(0.0), round(gear.sign() * commanded.held(from_s).unwrap_or(0.0), 1e2));
    for i in commanded.range(from_s, to_s) {
        change(commanded.t_s[i], round(gear.sign() * commanded.value[i], 1e2));
    }
    // a command that moves all the time is thinned like the rest
    let stride = command.len().div_ceil(2 * points).max(1);
    let command = command.into_iter().step_by(stride).collect();

    let mut bands: Vec<(f64, f64, usize)> = Vec::new();
    for i in samples {
        let t = round(encoder.t_s[i], 1e3);
        let number = SampleVerdict::ALL.iter().position(|v| *v == verdicts[i]).unwrap_or(0);
        match bands.last_mut() {
            Some(last) if last.2 == number => last.1 = t,
            Some(last) => {
                last.1 = t;
                bands.push((t, t, number));
            }
            None => bands.push((t, t, number)),
        }
    }
    RunTrace {
        row,
        t_s: each(&time, 1e3),
        speed_mps: each(&|i| gear.sign() * encoder.value[i] / calibration.encoder_scale, 1e4),
        simulated_mps: kept.iter().map(|i| at(simulated, time(*i)).map(|v| round(v, 1e4))).collect(),
        effective_nm: each(&|i| gear.sign() * lagged.at(time(i) - calibration.dead_time_s[log]).torque_nm, 1e2),
        angle_deg: each(&|i| track.angle_rad.interpolated(encoder.t_s[i]).unwrap_or(0.0) / RAD_PER_DEG, 1e1),
        command,
        verdicts: bands,
    }
}

/// The simulated speed nearest to a time.
fn at(simulated: &[Compared], t_s: f64) -> Option<f64> {
    let k = simulated.partition_point(|c| c.t_s < t_s);
    let near = [k.checked_sub(1), Some(k)].into_iter().flatten().filter_map(|k| simulated.get(k));
    near.map(|c| ((c.t_s - t_s).abs(), c.simulated)).filter(|c| c.0 <= NEAR_S).min_by(|a, b| a.0.total_cmp(&b.0)).map(|c| c.1)
}

/// The residual acceleration in a window of about 0.1 s.
struct ResidualWindow {
    log: usize,
    gear: Gear,
    t_s: f64,
    speed_mps: f64,
    torque_nm: f64,
    residual_mps2: f64,
}

fn windows(estimate: &Estimate) -> Vec<ResidualWindow> {
    let lagged = estimate.torques();
    let mut windows = Vec::new();
    for (segment, smoothed) in estimate.data.segments.iter().zip(&estimate.paths.speeds_mps) {
        let dead_time_s = estimate.calibration.dead_time_s[segment.log];
        let torque = |t: f64| segment.gear.sign() * lagged[segment.log].at(t - dead_time_s).torque_nm;
        let model = Course::new(segment, &lagged[segment.log], dead_time_s)
            .predicted(&smoothed.clone().into(), estimate.model.surface(segment.gear));
        let mut from = 0;
        for k in 1..segment.readings.len() {
            let dt = segment.readings[k].t_s - segment.readings[from].t_s;
            if dt < 0.095 {
                continue;
            }
            let deviation = (smoothed[k] - model[k]) - (smoothed[from] - model[from]);
            let t_s = 0.5 * (segment.readings[k].t_s + segment.readings[from].t_s);
            windows.push(ResidualWindow {
                log: segment.log,
                gear: segment.gear,
                t_s,
                speed_mps: 0.5 * (smoothed[k] + smoothed[from]),
                torque_nm: torque(t_s),
                residual_mps2: deviation / dt,
            });
            from = k;
        }
    }
    windows
}

fn residual_cells(map: &AccelMap, windows: &[ResidualWindow]) -> Result<ResidualCells> {
    let speed = Axis::new("speed_mps", map.speed_mps.clone())?;
    let torque = Axis::new("torque_nm", map.torque_nm.clone())?;
    let mut sums = vec![vec![(0u32, 0.0f64, 0.0f64); speed.len()]; torque.len()];
    for window in windows.iter().filter(|w| w.gear == map.gear) {
        let cell = &mut sums[torque.nearest(window.torque_nm)][speed.nearest(window.speed_mps)];
        *cell = (cell.0 + 1, cell.1 + window.residual_mps2, cell.2 + window.residual_mps2 * window.residual_mps2);
    }
    let each = |f: &dyn Fn(f64, f64, f64) -> f64| {
        let value = |c: &(u32, f64, f64)| (c.0 > 0).then(|| round(f(f64::from(c.0), c.1, c.2), 1e4));
        sums.iter().map(|row| row.iter().map(value).collect()).collect()
    };
    Ok(ResidualCells {
        gear: map.gear,
        mean_mps2: each(&|n, sum, _| sum / n),
        rms_mps2: each(&|n, _, squares| (squares / n).sqrt()),
        count: sums.iter().map(|row| row.iter().map(|c| c.0).collect()).collect(),
    })
}

fn residual_times(estimate: &Estimate, windows: &[ResidualWindow]) -> Vec<ResidualTimes> {
    let stride = windows.len().div_ceil(MOST_RESIDUALS).max(1);
    let of_log = |k: usize| {
        let own: Vec<&ResidualWindow> = windows.iter().filter(|w| w.log == k).step_by(stride).collect();
        ResidualTimes {
            log: estimate.data.logs[k].survey.track.source.file.clone(),
            t_s: own.iter().map(|w| round(w.t_s, 1e2)).collect(),
            residual_mps2: own.iter().map(|w| round(w.residual_mps2, 1e4)).collect(),
        }
    };
    (0..estimate.data.logs.len()).map(of_log).collect()
}
