//! What changes during a campaign: friction, as gears and tyres warm up, and the torque constant, as a battery empties or a motor heats.
//!
//! Both are taken as linear in the time in motion. With w from −1 at the beginning to 1 at the end, a(v, u, w) = A(v, (1 + w·κ)·u) + w·d:
//! the surface A is that of the middle of the campaign, d the change of the acceleration by friction, κ that of the torque constant.

use crate::campaign::Survey;

/// The change from the middle of a campaign to its end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct CampaignDrift {
    /// d: of the acceleration under the same torque [m/s²].
    pub(crate) accel_mps2: f64,
    /// κ: of the torque under the same command, as a share.
    pub(crate) torque_share: f64,
}

impl CampaignDrift {
    /// The same change as it stands at w.
    pub(crate) fn at(self, progress: f64) -> Self {
        Self { accel_mps2: progress * self.accel_mps2, torque_share: progress * self.torque_share }
    }
}

/// Where the runs of each log lie in the campaign: for every stretch of every log, w at its middle.
pub(crate) fn progress(surveys: &[Survey]) -> Vec<Vec<f64>> {
    let begins_s = |survey: &Survey, from_s: f64| survey.track.start_ns as f64 * 1e-9 + from_s;
    let mut order: Vec<(f64, usize, usize, f64)> = Vec::new();
    for (log, survey) in surveys.iter().enumerate() {
        order.extend(survey.stretches.iter().enumerate().map(|(k, s)| (begins_s(survey, s.from_s), log, k, s.to_s - s.from_s)));
    }
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let total_s: f64 = order.iter().map(|o| o.3).sum();
    let mut progress: Vec<Vec<f64>> = surveys.iter().map(|s| vec![0.0; s.stretches.len()]).collect();
    let mut passed_s = 0.0;
    for (_, log, stretch, length_s) in order {
        progress[log][stretch] = 2.0 * (passed_s + 0.5 * length_s) / total_s.max(1e-9) - 1.0;
        passed_s += length_s;
    }
    progress
}
