//! One log as the estimator sees it, and the data that it ignores.

use crate::campaign::{SampleVerdict, Survey};
use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::{EffectiveTorque, Instead};
use crate::fit::drive::step_timing::StepTiming;
use crate::fit::drive::torque_input::TorqueInput;
use crate::fit::drive_form::campaign_drift::{CampaignDrift, Progress};
use crate::fit::drive_form::drive_model::DriveModel;
use crate::fit::noise::model::Reading;
use crate::map::Gear;
use crate::signal::Series;
use std::collections::BTreeSet;

/// Data of one log that are ignored.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Cuts {
    /// Intervals [s], each with its verdict.
    pub(crate) intervals: Vec<(f64, f64, SampleVerdict)>,
    /// Single readings: (source, sample).
    pub(crate) readings: BTreeSet<(u8, u32)>,
}

/// One log as the estimator sees it.
#[derive(Debug, Clone)]
pub(crate) struct LogData<'a> {
    pub(crate) survey: &'a Survey,
    /// The command [N·m], where it changes.
    pub(crate) command: Series,
    /// Source of its effective torque.
    pub(crate) input: TorqueInput,
    /// The feedback instead of the command's torque where it was not delivered.
    pub(crate) instead: Option<Instead>,
    /// Where the drive did not deliver the torque that was asked for, on the command's clock [s].
    pub(crate) undelivered_s: Vec<(f64, f64)>,
    /// The speed from which on a governor may take the driving torque away [m/s]; infinite without one.
    pub(crate) governed_from_mps: f64,
    /// Timing errors of the steps of its command.
    pub(crate) timing: StepTiming,
    /// Outliers among the yaw readings.
    pub(crate) yaw_outliers: Vec<bool>,
    pub(crate) cuts: Cuts,
    /// Steps of each speed source that are coarse: larger than its noise [m/s]; 0 for a fine one.
    pub(crate) coarse_mps: [f64; 2],
    /// Where each of the survey's stretches lies in the campaign and in its log.
    pub(crate) progress: Vec<Progress>,
    /// Which of the survey's stretches are used.
    pub(crate) chosen: Vec<bool>,
}

impl LogData<'_> {
    /// The effective torque; the drive counts for a command only.
    pub(crate) fn torque(&self, drive: &DriveModel, drift: CampaignDrift) -> EffectiveTorque {
        let torque = self.input.torque(&self.survey.track, &self.command, drive).drifting(drift);
        match &self.instead {
            Some(instead) => torque.with_feedback(instead.clone()),
            None => torque,
        }
    }

    /// Readings of encoder and yaw rate in an interval, in order of time and in the gear's frame.
    pub(crate) fn readings(&self, gear: Gear, from_s: f64, to_s: f64, calibration: &Calibration) -> Vec<Reading> {
        let track = &self.survey.track;
        let encoder = &track.encoder_mps;
        let mut readings: Vec<Reading> = encoder
            .range(from_s + calibration.encoder_delay_s, to_s)
            .filter(|&k| !matches!(self.survey.verdicts[k], SampleVerdict::Outlier))
            .map(|k| {
                let speed_mps = gear.sign() * encoder.value[k] / calibration.encoder_scale;
                Reading::single(encoder.t_s[k] - calibration.encoder_delay_s, speed_mps, 0, k as u32)
            })
            .collect();
        if let Some(yaw) = &track.yaw_speed_mps {
            readings.extend(yaw.range(from_s, to_s).filter(|&k| !self.yaw_outliers[k]).map(|k| {
                let speed_mps = gear.sign() * (yaw.value[k] - self.survey.yaw_bias_mps);
                Reading::single(yaw.t_s[k], speed_mps, 1, k as u32)
            }));
        }
        readings.retain(|r| !self.cuts.readings.contains(&(r.source, r.sample)));
        readings.sort_by(|a, b| a.t_s.total_cmp(&b.t_s).then(a.source.cmp(&b.source)));
        readings
    }

    /// Mean speed over the 60 ms around `t_s`, gear frame.
    pub(crate) fn mean_speed(&self, gear: Gear, t_s: f64, calibration: &Calibration) -> Option<f64> {
        let readings = self.readings(gear, t_s - 0.04, t_s + 0.02, calibration);
        (!readings.is_empty()).then(|| readings.iter().map(|r| r.speed_mps).sum::<f64>() / readings.len() as f64)
    }
}
