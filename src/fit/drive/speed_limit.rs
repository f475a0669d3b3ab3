//! A governor by what the speed does: runs with different driving torques settle at one speed, and get there abruptly.
//!
//! Friction that grows with the speed lets another torque settle at another speed, and every torque approach it slowly: with a deceleration
//! in proportion to v or to v², the mean acceleration from 50 to 95 % of the settled speed is 0.29 or 0.39 of that from 10 to 50 %; a limit of
//! power or torque gives no more. A governor lets go near its speed only.

use crate::campaign::Survey;
use crate::signal::{median, slope_through_origin};

/// A run has settled when its speed changes by no more than this share over its last part of this length [s].
const SETTLED_SHARE: f64 = 0.03;
const SETTLED_S: f64 = 0.6;
/// Settled speeds within this share of their median are one speed.
const SAME_SPEED: f64 = 0.08;
/// Torques differ from this ratio on.
const OTHER_TORQUE: f64 = 1.15;
/// A run approaches its speed abruptly from this ratio of the mean accelerations on.
const ABRUPT: f64 = 0.55;
/// Nothing drives faster than this multiple of the limit.
const FASTEST: f64 = 1.1;
/// The torque falls from this share of the lowest settled speed on: a run settles within the range in which the governor takes the torque away.
const ONSET: f64 = 0.88;
/// Half the width of a moving average of the speed [s].
const SMOOTH_S: f64 = 0.05;
/// What is left out around an interval: the dead time before it, and after it the time until the drive has forgotten its torque [s].
const MARGIN_S: (f64, f64) = (0.1, 0.25);

/// A driving run that settled.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SettledRun {
    torque_nm: f64,
    speed_mps: f64,
    /// Mean acceleration from 50 to 95 % of the speed over that from 10 to 50 %; absent for a run that did not start slower.
    abruptness: Option<f64>,
}

/// A governor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpeedLimit {
    /// The lowest speed at which a run settled [m/s].
    pub(crate) speed_mps: f64,
}

impl SpeedLimit {
    /// The governor of the vehicle of all logs; `None` without signs of one.
    pub(crate) fn of(surveys: &[&Survey]) -> Option<Self> {
        let drives: Vec<DrivingRun> = surveys.iter().flat_map(|survey| drives(survey)).collect();
        let settled: Vec<SettledRun> = drives.iter().filter_map(DrivingRun::settled).collect();
        let fastest_mps = drives.iter().flat_map(|d| &d.points).map(|p| p.1).fold(0.0, f64::max);
        Self::of_runs(&settled, fastest_mps)
    }

    fn of_runs(settled: &[SettledRun], fastest_mps: f64) -> Option<Self> {
        let usual_mps = median(&settled.iter().map(|r| r.speed_mps).collect::<Vec<_>>());
        let same: Vec<&SettledRun> = settled.iter().filter(|r| (r.speed_mps - usual_mps).abs() <= SAME_SPEED * usual_mps).collect();
        let by = |of: fn(&SettledRun) -> f64| {
            let values = || same.iter().map(|r| of(r));
            (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max))
        };
        let (torques, speeds) = (by(|r| r.torque_nm), by(|r| r.speed_mps));
        let abrupt: Vec<f64> = same.iter().filter_map(|r| r.abruptness).collect();
        let is_one = same.len() >= 2 && torques.1 >= OTHER_TORQUE * torques.0 && fastest_mps <= FASTEST * speeds.1;
        (is_one && !abrupt.is_empty() && median(&abrupt) >= ABRUPT).then_some(Self { speed_mps: speeds.0 })
    }

    /// The speed from which on a driving torque may not be delivered [m/s].
    pub(crate) fn onset_mps(self) -> f64 {
        ONSET * self.speed_mps
    }

    /// Where a log's driving torque may not have been delivered, on the command's clock [s]: starts and ends rise.
    pub(crate) fn undelivered_s(self, survey: &Survey) -> Vec<(f64, f64)> {
        let mut found: Vec<(f64, f64)> = Vec::new();
        let fast = drives(survey).into_iter().flat_map(|d| d.points).filter(|p| p.1 > self.onset_mps());
        for (t_s, _) in fast {
            let (from_s, to_s) = (t_s - MARGIN_S.0, t_s + MARGIN_S.1);
            match found.last_mut() {
                Some(last) if from_s <= last.1 => last.1 = to_s,
                _ => found.push((from_s, to_s)),
            }
        }
        found
    }
}

/// The motion under one held driving torque: time [s] and speed [m/s], smoothed, gear frame.
struct DrivingRun {
    torque_nm: f64,
    points: Vec<(f64, f64)>,
}

/// The driving runs of a log in order of time.
fn drives(survey: &Survey) -> Vec<DrivingRun> {
    let encoder = &survey.track.encoder_mps;
    let smoothed = encoder.smoothed(SMOOTH_S);
    let mut all = Vec::new();
    for stretch in &survey.stretches {
        let sign = stretch.gear.sign();
        for hold in survey.holds.iter().filter(|h| h.steady && sign * h.torque_nm > 0.0) {
            let (from_s, to_s) = (stretch.from_s.max(hold.from_s), stretch.to_s.min(hold.to_s));
            if from_s < to_s {
                let points = encoder.range(from_s, to_s).map(|k| (encoder.t_s[k], sign * smoothed[k])).collect();
                all.push(DrivingRun { torque_nm: sign * hold.torque_nm, points });
            }
        }
    }
    all
}

impl DrivingRun {
    fn settled(&self) -> Option<SettledRun> {
        let (first_s, last_s) = (self.points.first()?.0, self.points.last()?.0);
        if last_s - first_s < SETTLED_S {
            return None;
        }
        let end = &self.points[self.points.partition_point(|p| p.0 < last_s - SETTLED_S)..];
        let mean = |of: fn(&(f64, f64)) -> f64| end.iter().map(of).sum::<f64>() / end.len() as f64;
        let (middle_s, speed_mps) = (mean(|p| p.0), mean(|p| p.1));
        let slope_mps2 = slope_through_origin(end.iter().map(|p| (p.0 - middle_s, p.1 - speed_mps)));
        let has_settled = end.len() >= 5 && speed_mps > 0.0 && slope_mps2.abs() * SETTLED_S <= SETTLED_SHARE * speed_mps;
        has_settled.then(|| SettledRun { torque_nm: self.torque_nm, speed_mps, abruptness: self.abruptness(speed_mps) })
    }

    fn abruptness(&self, settled_mps: f64) -> Option<f64> {
        let reached = |share: f64| self.points.iter().find(|p| p.1 >= share * settled_mps);
        let [low, middle, high] = [reached(0.1)?, reached(0.5)?, reached(0.95)?];
        let accel = |from: &(f64, f64), to: &(f64, f64)| (to.1 - from.1) / (to.0 - from.0).max(1e-3);
        let starts_slower = self.points[0].1 < 0.25 * settled_mps && middle.0 > low.0 && high.0 > middle.0;
        starts_slower.then(|| accel(middle, high) / accel(low, middle))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A vehicle of 13 N·m per m/s² from rest for 8 s: what is delivered of a torque at a speed, and friction of 8 N·m and 14 N·m per m/s.
    fn run(torque_nm: f64, delivered: impl Fn(f64, f64) -> f64) -> DrivingRun {
        let (mut speed_mps, mut points) = (0.0, Vec::new());
        for k in 0..800 {
            points.push((f64::from(k) * 0.01, speed_mps));
            speed_mps += 0.01 * (delivered(torque_nm, speed_mps) - 8.0 - 14.0 * speed_mps) / 13.0;
        }
        DrivingRun { torque_nm, points }
    }

    fn found(torques: &[f64], delivered: impl Fn(f64, f64) -> f64 + Copy) -> Option<SpeedLimit> {
        let runs: Vec<DrivingRun> = torques.iter().map(|u| run(*u, delivered)).collect();
        let settled: Vec<SettledRun> = runs.iter().filter_map(DrivingRun::settled).collect();
        assert!(settled.len() >= 2, "{settled:?}");
        SpeedLimit::of_runs(&settled, runs.iter().flat_map(|d| &d.points).map(|p| p.1).fold(0.0, f64::max))
    }

    #[test]
    fn a_governor_is_found_and_friction_and_limits_of_torque_and_power_are_none() {
        let torques = [24.0, 32.0, 40.0];
        let governed = |u: f64, v: f64| u * ((0.65 - v) / 0.05).clamp(0.0, 1.0);
        let limit = found(&torques, governed).unwrap();
        assert!((0.60..0.65).contains(&limit.speed_mps) && limit.onset_mps() < 0.6, "{limit:?}");
        assert_eq!(found(&torques, |u, _| u), None);
        assert_eq!(found(&torques, |u, _| u.min(20.0)), None);
        assert_eq!(found(&torques, |u, v| u.min(12.0 / v.max(1e-6))), None);
        // a single torque is no evidence
        assert_eq!(found(&[40.0, 40.0], governed), None);
    }

    #[test]
    fn what_drives_faster_than_a_speed_contradicts_its_limit() {
        let run = |torque_nm| SettledRun { torque_nm, speed_mps: 0.6, abruptness: Some(0.9) };
        let runs = [run(24.0), run(40.0)];
        assert_eq!(SpeedLimit::of_runs(&runs, 0.62), Some(SpeedLimit { speed_mps: 0.6 }));
        assert_eq!(SpeedLimit::of_runs(&runs, 0.9), None);
        assert_eq!(SpeedLimit::of_runs(&[], 0.0), None);
    }
}
