//! The wheel angles at which a log's runs were driven.
//!
//! In: the [`Track`]s of the logs. Out: a [`Census`]: the angles at which torque was held, with their runs. An angle belongs to runs, not
//! to samples: the wheel angle of a run is the median over its motion. A run during which the wheel drifts has no angle. Runs within
//! `angle_tolerance_deg` of one angle are one group, so two angles are separate if they differ by at least twice the tolerance.

use crate::campaign::SurveySettings;
use crate::campaign::gates::clean_angle;
use crate::campaign::hold::holds;
use crate::signal::{Series, Track, median};
use crate::units::RAD_PER_DEG;
use std::fmt;

/// Below this speed it is uncertain whether the wheel moves [m/s].
const MOVING_MPS: f64 = 0.03;
/// Shortest motion of a run that counts [s].
const SHORTEST_RUN_S: f64 = 0.2;
/// Torques closer than this share of the largest count as one.
const SAME_TORQUE: f64 = 0.04;
/// Smallest number of torques at an angle for a map.
const FEWEST_TORQUES: usize = 3;

/// A wheel angle of some runs.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub(crate) struct HeldAngle {
    /// The angle [°], left positive: the test angle, or the median of the runs in whole degrees. An angle sensor's bias and noise are some
    /// tenths of a degree, and test angles are usually whole degrees.
    pub wheel_angle_deg: f64,
    /// Lowest and highest median of a run [°].
    pub range_deg: [f64; 2],
    /// Number of runs.
    pub runs: usize,
    /// Number of torques, either gear.
    pub torques: usize,
    /// Time in motion [s].
    pub moving_s: f64,
}

impl HeldAngle {
    /// Whether enough torques were held for a map of this angle.
    pub(crate) fn is_campaign(&self) -> bool {
        self.torques >= FEWEST_TORQUES
    }
}

impl fmt::Display for HeldAngle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}° ({} runs, {} torques, {:.1} s)", self.wheel_angle_deg, self.runs, self.torques, self.moving_s)
    }
}

/// The wheel angles of some logs.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Census {
    /// The angles, ascending.
    pub held: Vec<HeldAngle>,
    /// Number of runs during which the wheel turned by more than the width of a group.
    pub drifting_runs: usize,
    /// Number of runs near an angle with more runs: too far away to belong to it, too near to form a separate angle.
    pub between_runs: usize,
}

/// One run.
#[derive(Debug, Clone, Copy)]
struct AngledRun {
    angle_deg: f64,
    torque_nm: f64,
    moving_s: f64,
}

impl Census {
    /// The census of the runs in `tracks`. If some runs are within the tolerance of the vehicle's test angle, that angle is one of the
    /// groups.
    pub(crate) fn new<'a>(tracks: impl IntoIterator<Item = &'a Track>, settings: &SurveySettings) -> Self {
        let mut census = Self::default();
        let mut runs = Vec::new();
        let mut test_angle_deg = None;
        for track in tracks {
            test_angle_deg.get_or_insert(track.vehicle.test_angle_deg);
            runs.extend(runs_of(track, settings, &mut census.drifting_runs));
        }
        let Some(test_angle_deg) = test_angle_deg else { return census };
        // any order of the logs gives the same groups
        runs.sort_by(|a, b| {
            a.angle_deg.total_cmp(&b.angle_deg).then(a.torque_nm.total_cmp(&b.torque_nm)).then(a.moving_s.total_cmp(&b.moving_s))
        });
        let tolerance_deg = settings.angle_tolerance_deg;
        let largest_nm = runs.iter().fold(1e-9f64, |m, r| m.max(r.torque_nm.abs()));
        let mut centre = runs.iter().any(|r| (r.angle_deg - test_angle_deg).abs() <= tolerance_deg).then_some(test_angle_deg);
        while let Some(angle_deg) = centre.take().or_else(|| busiest(&runs, tolerance_deg)) {
            let (own, others): (Vec<AngledRun>, Vec<AngledRun>) =
                runs.into_iter().partition(|r| (r.angle_deg - angle_deg).abs() <= tolerance_deg);
            let (near, rest): (Vec<AngledRun>, Vec<AngledRun>) =
                others.into_iter().partition(|r| (r.angle_deg - angle_deg).abs() < 2.0 * tolerance_deg);
            census.between_runs += near.len();
            runs = rest;
            let (Some(first), Some(last)) = (own.first(), own.last()) else { break };
            let mut levels: Vec<i64> = own.iter().map(|r| (r.torque_nm / (SAME_TORQUE * largest_nm)).round() as i64).collect();
            levels.sort_unstable();
            levels.dedup();
            census.held.push(HeldAngle {
                wheel_angle_deg: angle_deg,
                range_deg: [first.angle_deg, last.angle_deg],
                runs: own.len(),
                torques: levels.len(),
                moving_s: own.iter().map(|r| r.moving_s).sum(),
            });
        }
        census.held.sort_by(|a, b| a.wheel_angle_deg.total_cmp(&b.wheel_angle_deg));
        census
    }

    /// Whether runs were driven at other wheel angles than `test_angle_deg`.
    pub(crate) fn has_others(&self, test_angle_deg: f64) -> bool {
        self.held.iter().any(|h| (h.wheel_angle_deg - test_angle_deg).abs() > 1e-9)
    }

    /// The held angle for `wheel_angle_deg`: the nearest one within the tolerance.
    pub(crate) fn find(&self, wheel_angle_deg: f64, settings: &SurveySettings) -> Option<&HeldAngle> {
        let away = |h: &HeldAngle| (h.wheel_angle_deg - wheel_angle_deg).abs();
        self.held.iter().filter(|h| away(h) <= settings.angle_tolerance_deg).min_by(|a, b| away(a).total_cmp(&away(b)))
    }

    /// The angles as text.
    pub(crate) fn text(&self) -> String {
        if self.held.is_empty() {
            return "none".to_owned();
        }
        self.held.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
    }
}

/// The whole degree with the most motion within the tolerance.
fn busiest(runs: &[AngledRun], tolerance_deg: f64) -> Option<f64> {
    let window = |first: usize| runs[first..].iter().take_while(move |r| r.angle_deg <= runs[first].angle_deg + 2.0 * tolerance_deg - 1.0);
    let weight = |first: usize| window(first).map(|r| r.moving_s).sum::<f64>();
    let first = (0..runs.len()).max_by(|a, b| weight(*a).total_cmp(&weight(*b)).then(b.cmp(a)))?;
    let angles: Vec<f64> = window(first).map(|r| r.angle_deg).collect();
    // the median, limited so that the whole window stays within the tolerance
    let (low, high) = (angles[0], angles[angles.len() - 1]);
    let centre = median(&angles).clamp((high - tolerance_deg + 0.5).min(low + tolerance_deg - 0.5), low + tolerance_deg - 0.5).round();
    Some(if centre == 0.0 { 0.0 } else { centre })
}

/// The runs of a log: holds of a steady torque in motion.
fn runs_of(track: &Track, settings: &SurveySettings, drifting: &mut usize) -> Vec<AngledRun> {
    let angle = clean_angle(&track.angle_rad);
    let speed = Series { t_s: track.encoder_mps.t_s.clone(), value: track.encoder_mps.smoothed(0.04) };
    let period_s = track.encoder_mps.median_period_s().min(1.0);
    let largest_nm = track.command_nm.value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let mut runs = Vec::new();
    for hold in holds(&track.command_nm, settings).iter().filter(|h| h.steady && h.torque_nm.abs() > settings.hold_tolerance * largest_nm) {
        let moving: Vec<usize> = speed.range(hold.from_s, hold.to_s).filter(|&k| speed.value[k].abs() > MOVING_MPS).collect();
        let moving_s = moving.len() as f64 * period_s;
        let (Some(first), Some(last)) = (moving.first(), moving.last()) else { continue };
        if moving_s < SHORTEST_RUN_S {
            continue;
        }
        let (from_s, to_s) = (speed.t_s[*first], speed.t_s[*last]);
        let range = angle.range(from_s, to_s);
        // a slow angle signal may have no sample within a short run
        let seen: Vec<f64> = if range.is_empty() { angle.held(from_s).into_iter().collect() } else { angle.value[range].to_vec() };
        let degrees: Vec<f64> = seen.iter().map(|a| a / RAD_PER_DEG).collect();
        let (low, high) = degrees.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), d| (a.min(*d), b.max(*d)));
        if !(high - low).is_finite() {
            continue;
        }
        if high - low > 2.0 * settings.angle_tolerance_deg {
            *drifting += 1;
            continue;
        }
        runs.push(AngledRun { angle_deg: median(&degrees), torque_nm: hold.torque_nm, moving_s });
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{LogRef, Vehicle};

    /// Runs of one second: (wheel angle at its start and end [°], torque), each followed by a second at rest.
    fn track(runs: &[(f64, f64, f64)]) -> Track {
        let rate_hz = 50.0;
        let (mut t_s, mut speed, mut torque, mut angle) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (k, (from_deg, to_deg, torque_nm)) in runs.iter().enumerate() {
            for n in 0..100u32 {
                let within = f64::from(n) / rate_hz;
                t_s.push(2.0 * k as f64 + within);
                let on = n < 50;
                speed.push(if on { 0.5 } else { 0.0 });
                torque.push(if on { *torque_nm } else { 0.0 });
                angle.push((from_deg + (to_deg - from_deg) * within.min(1.0)) * RAD_PER_DEG);
            }
        }
        let series = |value: Vec<f64>| Series { t_s: t_s.clone(), value };
        Track {
            source: LogRef { sha256: String::new(), file: "test".to_owned(), bytes: 0, loss: None },
            vehicle: Vehicle {
                wheelbase_m: 0.9,
                wheel_radius_m: 0.12,
                test_angle_deg: 90.0,
                torque_limit_nm: None,
                torque_full_scale_nm: None,
            },
            wheel_angle_deg: 90.0,
            start_ns: 0,
            encoder_mps: series(speed),
            yaw_speed_mps: None,
            command_nm: series(torque),
            command_std_s: 0.0,
            feedback_nm: None,
            angle_rad: series(angle),
            gear: None,
            estop: None,
            notes: Vec::new(),
        }
    }

    fn angles(census: &Census) -> Vec<f64> {
        census.held.iter().map(|h| h.wheel_angle_deg).collect()
    }

    #[test]
    fn runs_are_grouped_by_angle_and_left_is_not_right() {
        let steady = |angle: f64, torque: f64| (angle, angle, torque);
        let track = track(&[
            steady(90.4, 10.0),
            steady(89.8, 20.0),
            steady(30.3, 10.0),
            steady(30.1, 20.0),
            steady(30.2, 30.0),
            steady(-30.2, 10.0),
            steady(0.2, 10.0),
        ]);
        let census = Census::new([&track], &SurveySettings::default());
        assert_eq!(angles(&census), [-30.0, 0.0, 30.0, 90.0]);
        let thirty = census.find(29.0, &SurveySettings::default()).copied();
        assert_eq!(thirty.map(|h| (h.runs, h.torques, h.is_campaign())), Some((3, 3, true)));
        assert!(census.find(26.0, &SurveySettings::default()).is_none() && !census.held[0].is_campaign());
        assert_eq!(census.held[3].range_deg.map(|a| (a * 10.0).round() / 10.0), [89.8, 90.4]);
    }

    #[test]
    fn angles_within_the_tolerance_are_one_and_runs_between_two_are_reported() {
        let steady = |angle: f64| (angle, angle, 10.0);
        let census = Census::new([&track(&[steady(30.0), steady(33.0), steady(86.0), steady(90.0)])], &SurveySettings::default());
        // 30 and 33 are within 2.5° of 31 or 32; 86 is too far from the test angle and too near to be another one
        assert_eq!(census.held.len(), 2);
        assert!((31.0..=32.0).contains(&census.held[0].wheel_angle_deg) && census.held[0].runs == 2, "{census:?}");
        assert_eq!((census.held[1].wheel_angle_deg, census.held[1].runs, census.between_runs), (90.0, 1, 1));
        let apart = Census::new([&track(&[steady(30.0), steady(36.0)])], &SurveySettings::default());
        assert_eq!(angles(&apart), [30.0, 36.0]);
    }

    #[test]
    fn a_run_during_which_the_wheel_drifts_has_no_angle() {
        let census = Census::new([&track(&[(20.0, 50.0, 10.0), (30.0, 31.0, 10.0)])], &SurveySettings::default());
        assert_eq!((census.drifting_runs, census.held.len()), (1, 1));
        assert_eq!(census.held[0].runs, 1);
    }
}
