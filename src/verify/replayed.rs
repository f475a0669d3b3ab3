//! Recorded runs replayed by the plant that Table 1 identified: torque in, speed out, without any correction.
//!
//! In: the survey of a log, if possible of runs that the fit has not used, and `table1.json`. Out: per run, recorded and simulated speed,
//! R² = 1 − SSE/SST and root mean square. The speed is the encoder's, corrected by its estimated delay and scale.

use crate::campaign::{Stretch, Survey};
use crate::map::{Gear, SpeedSource, Table1File};
use crate::sim;
use crate::sim::RecordedRun;
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
        });
    }
    Ok(runs)
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

    fn run(&self, gear: Gear) -> RecordedRun<'_> {
        RecordedRun { gear, t_s: &self.t_s, torque_nm: &self.torque_nm, speed_mps: &self.speed_mps, score_from_s: self.score_from_s }
    }
}
