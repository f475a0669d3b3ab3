//! Pivots recorded in operation: the acceleration that the controller asked for, and the one that the vehicle had.
//!
//! In: the survey of a log, the log's desired acceleration, Table 1. Out: per gear, mean and RMS of actual − desired, over windows of 0.2 s in
//! which the wheel moved at the test angle with a gear set. The actual acceleration is the slope of the encoder's speed, corrected by its delay
//! and scale; the desired one has passed the drive's dead time and lag. A controller's speed loop is in both.

use crate::campaign::Survey;
use crate::log::{Recording, Signal, SignalName};
use crate::map::{Gear, SpeedSource, Table1File};
use crate::signal::{Series, slope_through_origin};
use crate::units::NS_PER_S;
use crate::verify::replayed::reach_mps2;
use crate::verify::{Error, Result};
use serde::{Deserialize, Serialize};

/// Actual against desired acceleration of the pivots of a log in one gear.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordedPivots {
    /// File name of the log.
    pub file: String,
    /// Gear.
    pub gear: Gear,
    /// Compared time [s].
    pub seconds: f64,
    /// Mean of actual − desired acceleration, gear frame [m/s²].
    pub mean_mps2: f64,
    /// Root mean square of the same [m/s²].
    pub rms_mps2: f64,
    /// Part of the RMS that the noise of the speed readings explains [m/s²].
    pub noise_mps2: f64,
    /// Root mean square of the desired acceleration [m/s²].
    pub desired_rms_mps2: f64,
    /// Actual over desired acceleration, by least squares: 1 with a map that is right.
    pub gain: f64,
    /// The largest acceleration: that by the largest torque of Table 1 over that by none [m/s²].
    pub reach_mps2: f64,
}

/// Length of a window [s]: ten readings at 50 Hz; a desired acceleration rises in about as long.
const WINDOW_S: f64 = 0.2;
/// Fewest speed readings of a window.
const FEWEST_READINGS: usize = 4;
/// A desired acceleration that is older has ended [s]: a controller asks in each of its periods.
const OLDEST_S: f64 = 0.5;
/// Least time that is compared in one gear [s]: two windows of acceleration, and as many of braking.
const LEAST_S: f64 = 0.8;

/// Compares the pivots of a log, per gear that Table 1 has.
///
/// # Errors
/// The log has no desired acceleration, it has no sign, or nothing can be compared.
pub(crate) fn recorded_pivots(table1: &Table1File, recording: &Recording, survey: &Survey) -> Result<Vec<RecordedPivots>> {
    let log = || recording.source.file.clone();
    let Some(signal) = recording.signals.get(SignalName::DesiredAccel) else {
        let key = SignalName::DesiredAccel.key();
        let why = recording.notes.iter().find_map(|note| note.strip_prefix(key)?.strip_prefix(" is left out: "));
        return Err(Error::NoDesiredAccel { log: log(), reason: why.map_or(String::new(), |why| format!(" ({why})")) });
    };
    if signal.unsigned {
        return Err(Error::UnsignedAccel { log: log() });
    }
    let desired = Desired::new(signal, survey, table1.actuator.lag.value_s);
    let mut found = Vec::new();
    for gear in [Gear::Forward, Gear::Reverse] {
        let Some(reach_mps2) = reach_mps2(table1, gear)? else { continue };
        let windows = windows(table1, survey, &desired, gear);
        found.extend(RecordedPivots::new(log(), gear, &windows, reach_mps2));
    }
    if found.is_empty() {
        let driven_s = survey.stretches.iter().map(|s| s.to_s - s.from_s).sum();
        return Err(Error::NoPivots { log: log(), needed_s: LEAST_S, age_s: OLDEST_S, driven_s, values: signal.len() });
    }
    Ok(found)
}

/// The desired acceleration on the clock of the survey, and what the drive's lag has made of it.
struct Desired {
    asked_mps2: Series,
    /// Behind the lag, at the times of the messages.
    lagged_mps2: Vec<f64>,
    lag_s: f64,
    relative_to_gear: bool,
}

impl Desired {
    fn new(signal: &Signal, survey: &Survey, lag_s: f64) -> Self {
        let t_s = signal.time_ns.iter().map(|ns| ns.saturating_sub(survey.track.start_ns) as f64 / NS_PER_S).collect();
        let asked_mps2 = Series { t_s, value: signal.value.clone() };
        let mut desired = Self { asked_mps2, lagged_mps2: Vec::new(), lag_s, relative_to_gear: signal.relative_to_gear };
        for k in 0..signal.len() {
            // nothing was asked for before, and the wheel rested
            let lagged = if k == 0 { None } else { desired.lagged(k - 1, desired.asked_mps2.t_s[k]) };
            desired.lagged_mps2.push(lagged.unwrap_or(0.0));
        }
        desired
    }

    /// Behind the lag at `t_s`, after message `k` and before the next; `None` where that message is too old.
    fn lagged(&self, k: usize, t_s: f64) -> Option<f64> {
        let (asked, age_s) = (self.asked_mps2.value[k], t_s - self.asked_mps2.t_s[k]);
        let left = if self.lag_s > 0.0 { (-age_s / self.lag_s).exp() } else { 0.0 };
        (age_s <= OLDEST_S).then(|| asked + (self.lagged_mps2[k] - asked) * left)
    }

    /// The mean from `from_s` to `to_s`, gear frame [m/s²]; `None` where nothing was asked for.
    fn mean(&self, gear: Gear, from_s: f64, to_s: f64) -> Option<f64> {
        let sign = if self.relative_to_gear { 1.0 } else { gear.sign() };
        let steps = 10;
        let values: Option<Vec<f64>> = (0..steps)
            .map(|k| {
                let t_s = from_s + (f64::from(k) + 0.5) / f64::from(steps) * (to_s - from_s);
                self.lagged(self.asked_mps2.count_until(t_s).checked_sub(1)?, t_s)
            })
            .collect();
        values.map(|values| sign * values.iter().sum::<f64>() / f64::from(steps))
    }
}

/// One window: desired and actual acceleration, and the variance of the latter by the readings' scatter.
#[derive(Debug, Clone, Copy, PartialEq)]
struct AccelWindow {
    desired_mps2: f64,
    actual_mps2: f64,
    variance: f64,
    scatter: f64,
}

fn windows(table1: &Table1File, survey: &Survey, desired: &Desired, gear: Gear) -> Vec<AccelWindow> {
    let encoder = &survey.track.encoder_mps;
    let witness = table1.witnesses.iter().find(|w| w.name == SpeedSource::Encoder);
    let (delay_s, scale) = witness.map_or((0.0, 1.0), |w| (w.delay_s, w.scale));
    let late_s = delay_s + table1.actuator.dead_time.value_s;
    let mut windows = Vec::new();
    for stretch in survey.stretches.iter().filter(|s| s.gear == gear) {
        let count = ((stretch.to_s - stretch.from_s) / WINDOW_S).floor().max(0.0) as usize;
        for k in 0..count {
            let from_s = stretch.from_s + k as f64 * WINDOW_S;
            let readings = encoder.range(from_s, from_s + WINDOW_S);
            if readings.len() < FEWEST_READINGS {
                continue;
            }
            let n = readings.len() as f64;
            let (first_s, last_s) = (encoder.t_s[readings.start], encoder.t_s[readings.end - 1]);
            let Some(desired_mps2) = desired.mean(gear, first_s - late_s, last_s - late_s) else { continue };
            let mean_s = encoder.t_s[readings.clone()].iter().sum::<f64>() / n;
            let mean_mps = encoder.value[readings.clone()].iter().sum::<f64>() / n;
            let points: Vec<(f64, f64)> = readings.map(|i| (encoder.t_s[i] - mean_s, encoder.value[i] - mean_mps)).collect();
            let slope_mps2 = slope_through_origin(points.iter().copied());
            let scatter = points.iter().map(|(t, v)| (v - slope_mps2 * t).powi(2)).sum::<f64>() / (n - 2.0);
            let spread = points.iter().map(|(t, _)| t * t).sum::<f64>();
            windows.push(AccelWindow {
                desired_mps2,
                actual_mps2: gear.sign() * slope_mps2 / scale,
                variance: 1.0 / spread.max(1e-12),
                scatter,
            });
        }
    }
    windows
}

impl RecordedPivots {
    /// The figures of one gear; `None` with too few windows.
    fn new(file: String, gear: Gear, windows: &[AccelWindow], reach_mps2: f64) -> Option<Self> {
        let (n, seconds) = (windows.len() as f64, windows.len() as f64 * WINDOW_S);
        if seconds < LEAST_S - 1e-9 {
            return None;
        }
        let mean = |of: &dyn Fn(&AccelWindow) -> f64| windows.iter().map(of).sum::<f64>() / n;
        let off = |w: &AccelWindow| w.actual_mps2 - w.desired_mps2;
        // the median: a window in which the acceleration changes scatters more
        let mut scatter: Vec<f64> = windows.iter().map(|w| w.scatter).collect();
        scatter.sort_unstable_by(f64::total_cmp);
        let scatter = scatter[scatter.len() / 2];
        Some(Self {
            file,
            gear,
            seconds,
            mean_mps2: mean(&off),
            rms_mps2: mean(&|w| off(w).powi(2)).sqrt(),
            noise_mps2: (scatter * mean(&|w| w.variance)).sqrt(),
            desired_rms_mps2: mean(&|w| w.desired_mps2.powi(2)).sqrt(),
            gain: slope_through_origin(windows.iter().map(|w| (w.desired_mps2, w.actual_mps2))),
            reach_mps2,
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::campaign::SurveySettings;
    use crate::log::{Source, VehicleOverrides, read_split};
    use crate::map::Vehicle;
    use crate::signal::Track;
    use crate::sim::{PhysicalSettings, WorldSettings};
    use crate::verify::judge::verify_with;
    use crate::verify::reference_maps::known_maps;
    use crate::verify::settings::Wanted;
    use crate::verify::{Maps, Scenario, VerifySettings};

    /// A turn of 180° with the exact map of a vehicle, driven by one whose mass and inertia are `heavier` times as large: Table 1, log, survey.
    pub(crate) fn driven(heavier: f64) -> (Table1File, Recording, Survey) {
        let vehicle = Vehicle {
            wheelbase_m: 0.92,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        };
        let usual = PhysicalSettings::default();
        let (table1, table2) = known_maps(&WorldSettings::physical(vehicle, usual)).unwrap();
        let heavy = PhysicalSettings { mass_kg: heavier * usual.mass_kg, yaw_inertia_kgm2: heavier * usual.yaw_inertia_kgm2, ..usual };
        let plant = Some(WorldSettings::physical(vehicle, heavy));
        let scenarios = Scenario::all().into_iter().filter(|s| s.name == "left-180").collect();
        let settings = VerifySettings { scenarios, draws: 0, comparison_draws: 0, plant, ..VerifySettings::new().unwrap() };
        let maps = Maps::new(table1, table2).unwrap();
        let logs = verify_with(&maps, &settings, Wanted { logs: true, ..Wanted::default() }).unwrap().logs;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("shift.mcap");
        std::fs::write(&path, &logs[0].bytes).unwrap();
        let overrides = VehicleOverrides { wheelbase_m: Some(0.92), wheel_radius_m: Some(0.12), ..VehicleOverrides::default() };
        let recording = read_split(&[path], &SignalName::OPERATION, &Source::Detect, &overrides, &|_| {}).unwrap();
        let survey = Survey::new(Track::new(&recording).unwrap(), &SurveySettings::default()).unwrap();
        (maps.table1, recording, survey)
    }

    #[test]
    fn a_right_map_gives_what_was_desired_and_a_heavier_vehicle_less() {
        let figures = |heavier: f64| {
            let (table1, recording, survey) = driven(heavier);
            let found = recorded_pivots(&table1, &recording, &survey).unwrap();
            assert_eq!(found.iter().map(|p| p.gear).collect::<Vec<_>>(), [Gear::Forward]);
            found[0].clone()
        };
        let (right, heavy) = (figures(1.0), figures(1.3));
        assert!(right.file == "shift.mcap" && right.seconds > 4.0 && right.reach_mps2 > 1.0, "{right:?}");
        // the speed loop follows the noise of the readings, which the lag and the window take away: the gain is a little below 1
        assert!((0.88..1.05).contains(&right.gain) && right.mean_mps2.abs() < 0.03, "{right:?}");
        assert!((0.6..0.85).contains(&heavy.gain) && heavy.rms_mps2 > 1.5 * right.rms_mps2, "{heavy:?}");
    }

    #[test]
    fn a_log_that_cannot_be_compared_is_an_error_that_says_what_is_missing() {
        let (table1, recording, survey) = driven(1.0);
        let error = |change: &dyn Fn(&mut Recording)| {
            let mut changed = recording.clone();
            change(&mut changed);
            recorded_pivots(&table1, &changed, &survey).unwrap_err().to_string()
        };
        let name = SignalName::DesiredAccel;
        let missing = error(&|r| {
            r.signals.lateral.remove(&name);
            r.notes.push("desired_accel is left out: the log has no topic /accel".to_owned());
        });
        let expected = "shift.mcap: the signal desired_accel is missing (the log has no topic /accel): ";
        assert!(missing.starts_with(expected) && missing.contains("desired_accel = { path = \"/topic.field\" }"), "{missing}");
        let unsigned = error(&|r| r.signals.lateral.get_mut(&name).unwrap().unsigned = true);
        assert!(unsigned.contains("has no sign"), "{unsigned}");
        let early = error(&|r| {
            let signal = r.signals.lateral.get_mut(&name).unwrap();
            signal.time_ns.truncate(1);
            signal.value.truncate(1);
        });
        assert!(early.contains("desired_accel has 1 value(s)"), "{early}");
    }

    #[test]
    fn what_is_asked_for_passes_the_lag_and_ends_with_its_messages() {
        let t_s = vec![1.0, 1.02, 1.04];
        let desired = Desired {
            asked_mps2: Series { t_s, value: vec![1.0; 3] },
            lagged_mps2: vec![0.0, 0.2, 0.36],
            lag_s: 0.1,
            relative_to_gear: false,
        };
        let mean = desired.mean(Gear::Reverse, 1.4, 1.45).unwrap();
        assert!((-1.0..-0.97).contains(&mean), "{mean}");
        assert_eq!((desired.mean(Gear::Forward, 0.9, 1.1), desired.mean(Gear::Forward, 1.4, 1.6)), (None, None));
    }
}
