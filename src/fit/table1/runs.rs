//! How well the surface explains each run. Users understand the simulated speed best, from a surface fitted without the run.

use crate::campaign::{SampleVerdict, runs};
use crate::fit::motion::integration::Course;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::surface::lattice::LatticeSurface;
use crate::map::RunRow;
use crate::signal::median;

/// A reading against its simulation.
pub(crate) struct Compared {
    pub(crate) log: usize,
    pub(crate) t_s: f64,
    recorded: f64,
    pub(crate) simulated: f64,
    offset: f64,
}

impl Compared {
    /// Speed that the simulation lacks [m/s].
    pub(crate) fn missing_mps(&self) -> f64 {
        self.recorded - self.simulated
    }
}

/// The runs, and the held-out figures over all of them.
pub(crate) struct RunFigures {
    /// One row per hold, with its errors.
    pub(crate) rows: Vec<RunRow>,
    /// The log of each row.
    pub(crate) logs: Vec<usize>,
    /// RMSE [m/s] and R² of the simulated speed over all readings; absent with fewer than two runs.
    pub(crate) pooled: Option<(f64, f64)>,
}

/// One row per hold, with its errors by a surface fitted without its run.
///
/// `compared` is in the order of the logs and of time: segments follow one another and do not overlap.
pub(crate) fn run_figures(estimate: &Estimate, compared: &[Compared], verdicts: &[Vec<SampleVerdict>]) -> RunFigures {
    let held_out = estimate.validation.is_some();
    let (mut rows, mut logs) = (Vec::new(), Vec::new());
    for (k, log) in estimate.data.logs.iter().enumerate() {
        let own = &compared[compared.partition_point(|c| c.log < k)..compared.partition_point(|c| c.log <= k)];
        for (hold, row) in runs(log.survey, &verdicts[k], estimate.calibration.encoder_scale) {
            let inside = &own[own.partition_point(|c| c.t_s < hold.from_s)..own.partition_point(|c| c.t_s < hold.to_s)];
            logs.push(k);
            rows.push(RunRow {
                speed_rmse_mps: rmse(inside).filter(|_| held_out).map(|v| round(v, 1e5)),
                r_squared: r_squared(inside).filter(|_| held_out).map(|v| round(v, 1e4)),
                offset_mps2: (!inside.is_empty()).then(|| round(inside.iter().map(|c| c.offset).sum::<f64>() / inside.len() as f64, 1e4)),
                ..row
            });
        }
    }
    let pooled = rmse(compared).zip(r_squared(compared)).filter(|_| held_out);
    RunFigures { rows, logs, pooled }
}

/// An offset further from the median than this many robust standard deviations disagrees with the rest.
const DISAGREES: f64 = 4.0;
/// Least offset that counts as a disagreement, whatever the spread [m/s²].
const LEAST_DISAGREEMENT_MPS2: f64 = 0.02;
/// Fewest runs for a spread of the offsets.
const FEWEST_OFFSETS: usize = 8;
/// Shortest run in this comparison [s]: shorter ones hardly show an offset.
const LONG_ENOUGH_S: f64 = 0.5;

/// One note per log about its runs that disagree with the rest: a slope, a battery, a drift.
pub(crate) fn disagreements(rows: &[RunRow]) -> Vec<String> {
    let offsets: Vec<(&RunRow, f64)> =
        rows.iter().filter(|r| r.used_s >= LONG_ENOUGH_S).filter_map(|r| Some((r, r.offset_mps2?))).collect();
    if offsets.len() < FEWEST_OFFSETS {
        return Vec::new();
    }
    let centre = median(&offsets.iter().map(|(_, o)| *o).collect::<Vec<_>>());
    let spread = 1.4826 * median(&offsets.iter().map(|(_, o)| (o - centre).abs()).collect::<Vec<_>>());
    let mut notes: Vec<(&str, Vec<String>)> = Vec::new();
    for (row, offset) in offsets.iter().filter(|(_, o)| (o - centre).abs() > (DISAGREES * spread).max(LEAST_DISAGREEMENT_MPS2)) {
        let run = format!("at {:.1} s ({} N·m, {}, {offset:+.3} m/s²)", row.start_s, row.torque_nm, row.gear);
        match notes.last_mut().filter(|(log, _)| *log == row.log) {
            Some((_, runs)) => runs.push(run),
            None => notes.push((&row.log, vec![run])),
        }
    }
    notes
        .into_iter()
        .map(|(log, runs)| {
            let runs = runs.join(", ");
            format!("{log}: runs that disagree with the rest by a constant acceleration (a slope, a battery, a drift): {runs}")
        })
        .collect()
}

/// Rounds to 1/`steps`: figures of a report need no sixteen digits.
pub(crate) fn round(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps
}

fn rmse(inside: &[Compared]) -> Option<f64> {
    (inside.len() > 4).then(|| (inside.iter().map(|c| (c.recorded - c.simulated).powi(2)).sum::<f64>() / inside.len() as f64).sqrt())
}

fn r_squared(inside: &[Compared]) -> Option<f64> {
    if inside.len() < 5 {
        return None;
    }
    let mean = inside.iter().map(|c| c.recorded).sum::<f64>() / inside.len() as f64;
    let total: f64 = inside.iter().map(|c| (c.recorded - mean).powi(2)).sum();
    let left: f64 = inside.iter().map(|c| (c.recorded - c.simulated).powi(2)).sum();
    (total > 0.0).then(|| 1.0 - left / total)
}

/// The surface that judges a segment: fitted without its fold, where there are folds.
fn judge<'a>(estimate: &'a Estimate, segment: usize) -> &'a LatticeSurface {
    let gear = estimate.data.segments[segment].gear;
    match &estimate.validation {
        Some(held_out) => &held_out.without[held_out.fold[segment]][gear],
        None => estimate.model.surface(gear),
    }
}

/// Longest step of the simulation [s]: fine enough for the midpoint rule even while the torque moves.
const LONGEST_STEP_S: f64 = 10e-3;

/// Every segment simulated open loop from its own start, v̇ = A(v, u), never corrected by its readings.
pub(crate) fn simulate(estimate: &Estimate) -> Vec<Compared> {
    let lagged = estimate.torques();
    let mut compared = Vec::with_capacity(estimate.data.segments.iter().map(|s| s.readings.len()).sum());
    for (k, ((segment, smoothed), offset)) in
        estimate.data.segments.iter().zip(&estimate.paths.speeds_mps).zip(&estimate.paths.offsets_mps2).enumerate()
    {
        let surface = judge(estimate, k);
        let mut cursor = lagged[segment.log].cursor();
        let mut torque = |t: f64| segment.gear.sign() * cursor.at(t - estimate.calibration.dead_time_s[segment.log]).torque_nm;
        let (limit, drift) = (lagged[segment.log].limit(), lagged[segment.log].drift().at(segment.progress));
        let friction_mps2 = |v: f64| if drift.friction_share == 0.0 { 0.0 } else { drift.friction_share * surface.accel_mps2(v, 0.0) };
        let accel_mps2 =
            |v: f64, asked_nm: f64| surface.accel_mps2(v, (1.0 + drift.torque_share) * limit.delivered_nm(v, asked_nm)) + friction_mps2(v);
        let mut v = if segment.anchored { 0.0 } else { smoothed[0] };
        let mut t = segment.start_s;
        for reading in &segment.readings {
            let steps = ((reading.t_s - t) / LONGEST_STEP_S).ceil().max(1.0);
            let dt = (reading.t_s - t).max(0.0) / steps;
            for _ in 0..steps as usize {
                let half = v + 0.5 * dt * accel_mps2(v, torque(t));
                v = (v + dt * accel_mps2(half, torque(t + 0.5 * dt))).max(0.0);
                t += dt;
            }
            compared.push(Compared { log: segment.log, t_s: reading.t_s, recorded: reading.speed_mps, simulated: v, offset: *offset });
        }
    }
    compared
}

/// Root mean square residual of the acceleration, from the smoothed speeds [m/s²].
pub(crate) fn residual_rms_mps2(estimate: &Estimate) -> f64 {
    let lagged = estimate.torques();
    let (mut sum, mut count) = (0.0, 0usize);
    for (segment, smoothed) in estimate.data.segments.iter().zip(&estimate.paths.speeds_mps) {
        let course = Course::new(segment, &lagged[segment.log], estimate.calibration.dead_time_s[segment.log]);
        let model = course.predicted(&smoothed.clone().into(), estimate.model.surface(segment.gear));
        // over windows of about 0.1 s: the difference quotient of the deviation
        let n = segment.readings.len();
        let stride = (n * 100 / ((segment.readings[n - 1].t_s - segment.start_s) * 1000.0).max(1.0) as usize).max(1);
        for k in (stride..n).step_by(stride) {
            let dt = segment.readings[k].t_s - segment.readings[k - stride].t_s;
            if dt > 0.02 {
                let deviation = (smoothed[k] - model[k]) - (smoothed[k - stride] - model[k - stride]);
                sum += (deviation / dt).powi(2);
                count += 1;
            }
        }
    }
    (sum / count.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Gear;

    fn compared(recorded: f64, simulated: f64) -> Compared {
        Compared { log: 0, t_s: 0.0, recorded, simulated, offset: 0.0 }
    }

    fn row(log: &str, start_s: f64, offset_mps2: f64) -> RunRow {
        RunRow {
            log: log.to_owned(),
            wheel_angle_deg: None,
            start_s,
            duration_s: 2.0,
            gear: Gear::Forward,
            torque_nm: 20.0,
            start_speed_mps: 0.0,
            end_speed_mps: 0.9,
            used_s: 2.0,
            speed_rmse_mps: None,
            r_squared: None,
            offset_mps2: Some(offset_mps2),
            rejected: Vec::new(),
        }
    }

    #[test]
    fn the_errors_of_a_run_need_five_readings() {
        let off: Vec<Compared> = (0..6).map(|k| compared(f64::from(k), f64::from(k) + 0.1)).collect();
        assert!((rmse(&off).unwrap() - 0.1).abs() < 1e-12);
        assert!((r_squared(&off).unwrap() - (1.0 - 6.0 * 0.01 / 17.5)).abs() < 1e-12);
        assert!(rmse(&off[..4]).is_none() && r_squared(&off[..4]).is_none());
        let still: Vec<Compared> = (0..6).map(|_| compared(0.5, 0.4)).collect();
        assert!(r_squared(&still).is_none(), "a speed that does not vary has nothing to explain");
    }

    #[test]
    fn a_run_that_disagrees_is_named_with_its_log() {
        let mut rows: Vec<RunRow> = (0..10).map(|k| row("a.mcap", 5.0 * f64::from(k), 1e-3 * f64::from(k % 3))).collect();
        assert!(disagreements(&rows).is_empty());
        rows.push(row("b.mcap", 70.0, -0.08));
        let notes = disagreements(&rows);
        assert_eq!(notes.len(), 1);
        assert!(notes[0].starts_with("b.mcap: ") && notes[0].contains("at 70.0 s (20 N·m, forward, -0.080 m/s²)"), "{notes:?}");
        // a short run hardly shows an offset, and few runs show no spread
        rows.last_mut().unwrap().used_s = 0.3;
        assert!(disagreements(&rows).is_empty() && disagreements(&rows[8..]).is_empty());
    }
}
