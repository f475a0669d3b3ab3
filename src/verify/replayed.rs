//! Recorded runs replayed by the plant that Table 1 identified: torque in, speed out, without any correction.
//!
//! In: the survey of a log, if possible of runs that the fit has not used, and `table1.json`. Out: per run, recorded and simulated speed,
//! R² = 1 − SSE/SST and the root mean square difference. The speed is the encoder's, corrected by its estimated delay and scale.

use crate::campaign::{Stretch, Survey};
use crate::map::{Gear, SpeedSource, Table1File};
use crate::signal::slope_through_origin;
use crate::sim;
use crate::sim::{RecordedRun, Replay};
use crate::verify::Result;
use serde::{Deserialize, Serialize};

/// A recorded run and the residuals of its replay.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReplayedRun {
    /// File name of the log.
    pub file: String,
    /// Whether Table 1 was fitted to this log; otherwise the run is held out.
    pub fitted: bool,
    /// Gear.
    pub gear: Gear,
    /// Start of the run in its log [s].
    pub from_s: f64,
    /// Compared time [s].
    pub seconds: f64,
    /// Compared speed readings.
    pub samples: usize,
    /// Share of the recorded speed's variance that the simulation explains; absent where the speed does not vary.
    pub r_squared: Option<f64>,
    /// Root mean square of simulated minus recorded speed [m/s].
    pub rmse_mps: f64,
    /// Largest difference [m/s].
    pub max_mps: f64,
    /// Constant acceleration that the simulation lacks, as a share of the acceleration by the largest torque.
    #[serde(default)]
    pub missing_share: f64,
}

/// Shortest run that is replayed [s]: a shorter one is mostly dead time.
const SHORTEST_S: f64 = 0.4;
/// Length of the torque input before the first compared reading [s]: longer than any dead time and some lags.
const LEAD_S: f64 = 1.0;

/// Replays every usable run of a surveyed log, in order of time. Runs in a gear that Table 1 does not have are skipped.
///
/// # Errors
/// A Table 1 that cannot be simulated.
pub(crate) fn replayed(table1: &Table1File, survey: &Survey) -> Result<Vec<ReplayedRun>> {
    let mut settings = sim::WorldSettings::identified(table1)?;
    let source = &survey.track.source;
    let known = table1.actuator.per_log.iter().find(|log| log.sha256 == source.sha256);
    if let Some(log) = known {
        settings.drive.dead_time_s = log.dead_time.value_s;
    }
    let encoder = table1.witnesses.iter().find(|w| w.name == SpeedSource::Encoder);
    let (delay_s, scale) = encoder.map_or((0.0, 1.0), |w| (w.delay_s, w.scale));
    let late_s = delay_s + known.map_or(0.0, |log| log.clock_offset.value_s);
    let fitted = known.is_some();
    let mut runs = Vec::new();
    for stretch in &survey.stretches {
        if stretch.to_s - stretch.from_s < SHORTEST_S || table1.map_at_test_angle(stretch.gear).is_none() {
            continue;
        }
        let Some(recorded) = Recorded::cut(survey, *stretch, late_s, scale) else { continue };
        let found = sim::replay(&settings, &recorded.run(stretch.gear))?;
        let missing_share = recorded.missing_mps2(&found) / reach_mps2(table1, stretch.gear)?.unwrap_or(f64::INFINITY);
        runs.push(ReplayedRun {
            file: source.file.clone(),
            fitted,
            gear: stretch.gear,
            from_s: stretch.from_s,
            seconds: stretch.to_s - stretch.from_s,
            samples: found.speed_mps.len(),
            r_squared: found.r_squared,
            rmse_mps: found.rmse_mps,
            max_mps: found.max_mps,
            missing_share,
        });
    }
    Ok(runs)
}

/// Acceleration by the largest torque of a gear's surface over that by none, just above standstill [m/s²]; `None` without the gear's map.
pub(crate) fn reach_mps2(table1: &Table1File, gear: Gear) -> Result<Option<f64>> {
    let Some(map) = table1.map_at_test_angle(gear) else { return Ok(None) };
    let surface = map.surface.table()?;
    let largest_nm = map.torque_nm.last().copied().unwrap_or(0.0);
    let accel_mps2 = |torque_nm: f64| surface.accel_from_torque_clamped(0.0, torque_nm).unwrap_or(0.0);
    Ok(Some((accel_mps2(largest_nm) - accel_mps2(0.0)).max(1e-6)))
}

/// One run's samples, gear frame: at every speed reading, and at every change of the command.
struct Recorded {
    t_s: Vec<f64>,
    torque_nm: Vec<f64>,
    speed_mps: Vec<f64>,
    score_from_s: f64,
}

impl Recorded {
    /// The run with the samples before it; `None` with fewer than a handful of readings.
    fn cut(survey: &Survey, stretch: Stretch, late_s: f64, scale: f64) -> Option<Self> {
        let (encoder, command, sign) = (&survey.track.encoder_mps, &survey.track.command_nm, stretch.gear.sign());
        let readings = encoder.range(stretch.from_s, stretch.to_s);
        if readings.len() < 8 {
            return None;
        }
        let score_from_s = encoder.t_s[readings.start] - late_s;
        let to_s = encoder.t_s[readings.end - 1] - late_s;
        let speed_at = |t_s: f64| encoder.interpolated(t_s + late_s).map(|v| sign * v / scale);
        let changes = command.range(score_from_s - LEAD_S, to_s).filter(|&k| k == 0 || command.value[k] != command.value[k - 1]);
        let mut t_s: Vec<f64> = readings.map(|k| encoder.t_s[k] - late_s).chain(changes.map(|k| command.t_s[k])).collect();
        t_s.push(score_from_s - LEAD_S);
        t_s.sort_by(f64::total_cmp);
        t_s.dedup();
        t_s.retain(|&t| t <= to_s);
        let torque_nm = t_s.iter().map(|&t| sign * command.held(t).unwrap_or(0.0)).collect();
        // the speed before the run is not compared and may be missing
        let speed_mps: Option<Vec<f64>> = t_s.iter().map(|&t| if t < score_from_s { Some(0.0) } else { speed_at(t) }).collect();
        Some(Self { torque_nm, speed_mps: speed_mps?, t_s, score_from_s })
    }

    /// Slope of recorded less simulated speed through the start of the comparison [m/s²].
    fn missing_mps2(&self, found: &Replay) -> f64 {
        let recorded = self.t_s.iter().zip(&self.speed_mps).skip(found.first);
        slope_through_origin(
            recorded.zip(&found.speed_mps).map(|((t_s, recorded), simulated)| (t_s - self.score_from_s, recorded - simulated)),
        )
    }

    fn run(&self, gear: Gear) -> RecordedRun<'_> {
        RecordedRun { gear, t_s: &self.t_s, torque_nm: &self.torque_nm, speed_mps: &self.speed_mps, score_from_s: self.score_from_s }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::campaign::SurveySettings;
    use crate::log::{Source, VehicleOverrides, read_bytes};
    use crate::map::{DelayEstimate, DelayStatus, LogActuator};
    use crate::record::{Campaign, record};
    use crate::signal::Track;
    use crate::sim::VehicleFile;
    use crate::verify::reference_maps::known_maps;

    const CAMPAIGN: &str = "[[runs]]\ntorque_nm = [16, 28]\nhold_s = 2\nspeed_limit_mps = 0.9\n\
                            [[runs]]\ngear = \"reverse\"\ntorque_nm = [20]\nhold_s = 2\nspeed_limit_mps = 0.9\n";

    /// Three runs of the bundled vehicle, and its own Table 1.
    fn driven() -> (Table1File, Survey) {
        let vehicle = VehicleFile::bundled().unwrap();
        let bytes = record(&vehicle, &Campaign::from_toml(CAMPAIGN).unwrap(), Some(1)).unwrap().bytes;
        let log = read_bytes(bytes, "three.mcap", &Source::Detect, &VehicleOverrides::default()).unwrap();
        let survey = Survey::new(Track::new(&log).unwrap(), &SurveySettings::default()).unwrap();
        (known_maps(&vehicle.settings()).unwrap().0, survey)
    }

    #[test]
    fn the_vehicles_own_map_explains_its_runs() {
        let (table1, survey) = driven();
        let runs = replayed(&table1, &survey).unwrap();
        assert_eq!(runs.iter().map(|r| r.gear).collect::<Vec<_>>(), [Gear::Forward, Gear::Forward, Gear::Reverse]);
        for run in &runs {
            assert!(!run.fitted && run.file == "three.mcap" && run.samples > 20 && run.seconds > 0.5, "{run:?}");
            // the disturbance of a run adds to the encoder's noise
            assert!(run.r_squared.unwrap() > 0.97 && run.rmse_mps < 0.05 && run.max_mps >= run.rmse_mps, "{run:?}");
            assert!(run.missing_share.abs() < 0.02, "{run:?}");
        }
        assert!(runs.windows(2).all(|pair| pair[0].from_s < pair[1].from_s));
    }

    #[test]
    fn a_log_of_the_fit_is_replayed_with_its_own_dead_time() {
        let (mut table1, survey) = driven();
        let held_out = replayed(&table1, &survey).unwrap();
        let delay = |value_s| DelayEstimate { value_s, std_err_s: None, status: DelayStatus::Estimated };
        let source = &survey.track.source;
        let late = LogActuator {
            sha256: source.sha256.clone(),
            file: source.file.clone(),
            dead_time: delay(table1.actuator.dead_time.value_s + 0.1),
            clock_offset: delay(0.0),
        };
        table1.actuator.per_log.push(late);
        let fitted = replayed(&table1, &survey).unwrap();
        assert!(fitted.iter().all(|run| run.fitted));
        // a tenth of a second too late is seen in every run
        assert!(fitted.iter().zip(&held_out).all(|(late, right)| late.rmse_mps > right.rmse_mps), "{fitted:?}");
    }

    #[test]
    fn a_gear_without_a_map_is_skipped() {
        let (mut table1, survey) = driven();
        table1.maps.retain(|map| map.gear == Gear::Forward);
        assert_eq!(replayed(&table1, &survey).unwrap().len(), 2);
    }
}
