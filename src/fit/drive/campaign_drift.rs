//! What changes while a vehicle is driven: friction, as gears and tyres warm up, and the torque constant, as a battery empties or a motor
//! heats.
//!
//! Both are linear in the time in motion, over the whole campaign and over each log, before which the vehicle may have cooled down. With w
//! from −1 at the beginning to 1 at the end of either, a(v, u, w) = A(v, (1 + Σ w·κ)·u) + Σ w·d: the surface A is that of the middle, d the
//! change of the acceleration by friction, κ that of the torque constant.

use crate::campaign::Survey;

/// Over the campaign, and over each log.
pub(crate) const SPANS: usize = 2;

/// Where a run lies in the campaign and in its log: −1 at the beginning, 1 at the end.
pub(crate) type Progress = [f64; SPANS];

/// The changes from the middle to the end of the campaign, and of each log.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct CampaignDrift {
    /// d: of the acceleration under the same torque [m/s²].
    pub(crate) accel_mps2: [f64; SPANS],
    /// κ: of the torque under the same command, as a share.
    pub(crate) torque_share: [f64; SPANS],
}

/// A change as it stands at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Change {
    /// Of the acceleration [m/s²].
    pub(crate) accel_mps2: f64,
    /// Of the torque, as a share.
    pub(crate) torque_share: f64,
}

impl CampaignDrift {
    /// The change at a time.
    pub(crate) fn at(&self, progress: Progress) -> Change {
        let sum = |of: [f64; SPANS]| of.iter().zip(progress).map(|(change, w)| change * w).sum();
        Change { accel_mps2: sum(self.accel_mps2), torque_share: sum(self.torque_share) }
    }
}

/// Where the stretches of each log lie.
pub(crate) fn progress(surveys: &[Survey]) -> Vec<Vec<Progress>> {
    let begins_s = |survey: &Survey, from_s: f64| survey.track.start_ns as f64 * 1e-9 + from_s;
    let mut order: Vec<(f64, usize, usize, f64)> = Vec::new();
    for (log, survey) in surveys.iter().enumerate() {
        order.extend(survey.stretches.iter().enumerate().map(|(k, s)| (begins_s(survey, s.from_s), log, k, s.to_s - s.from_s)));
    }
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let total_s: f64 = order.iter().map(|o| o.3).sum();
    let own_s: Vec<f64> = surveys.iter().map(|s| s.stretches.iter().map(|s| s.to_s - s.from_s).sum()).collect();
    let mut progress: Vec<Vec<Progress>> = surveys.iter().map(|s| vec![[0.0; SPANS]; s.stretches.len()]).collect();
    let (mut passed_s, mut passed_own_s) = (0.0, vec![0.0; surveys.len()]);
    for (_, log, stretch, length_s) in order {
        let share = |passed_s: f64, total_s: f64| 2.0 * (passed_s + 0.5 * length_s) / total_s.max(1e-9) - 1.0;
        progress[log][stretch] = [share(passed_s, total_s), share(passed_own_s[log], own_s[log])];
        passed_s += length_s;
        passed_own_s[log] += length_s;
    }
    progress
}
