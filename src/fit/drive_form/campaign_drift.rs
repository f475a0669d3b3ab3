//! What changes while a vehicle is driven: friction, as gears and tyres warm up, and the torque constant, as a battery empties or a motor
//! heats.
//!
//! Both are linear in the time in motion, over the whole campaign and over each log: before a log the vehicle may have cooled down. With w
//! from the beginning to the end of either, zero at the mean of a gear's runs, a(v, u, w) = A(v, (1 + Σ w·κ)·u) + Σ w·φ·A(v, 0): the surface
//! A is that of the mean, φ the relative change of friction over half of the span, κ that of the torque constant.

use crate::campaign::Survey;
use crate::map::PerGear;

/// Over the campaign, and over each log.
pub(crate) const SPANS: usize = 2;

/// Where a run lies in the campaign and in its log: 2 from the beginning to the end, 0 at the mean of its gear's runs.
pub(crate) type Progress = [f64; SPANS];

/// The changes over half of the campaign, and of each log.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct CampaignDrift {
    /// φ: of friction, as a share.
    pub(crate) friction_share: [f64; SPANS],
    /// κ: of the torque under the same command, as a share.
    pub(crate) torque_share: [f64; SPANS],
}

/// The change at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct DriftNow {
    /// Of friction, as a share.
    pub(crate) friction_share: f64,
    /// Of the torque, as a share.
    pub(crate) torque_share: f64,
}

impl CampaignDrift {
    /// The change at a time.
    pub(crate) fn at(&self, progress: Progress) -> DriftNow {
        let sum = |of: [f64; SPANS]| of.iter().zip(progress).map(|(change, w)| change * w).sum();
        DriftNow { friction_share: sum(self.friction_share), torque_share: sum(self.torque_share) }
    }
}

/// Where everything lies in the campaign.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CampaignProgress {
    /// The stretches of each log.
    pub(crate) stretches: Vec<Vec<Progress>>,
    /// The end of the campaign, for each gear.
    pub(crate) end: PerGear<Progress>,
}

impl CampaignProgress {
    /// From the stretches of the logs and when they were driven.
    pub(crate) fn of(surveys: &[Survey]) -> Self {
        let begins_s = |survey: &Survey, from_s: f64| survey.track.start_ns as f64 * 1e-9 + from_s;
        let mut order: Vec<(f64, usize, usize, f64)> = Vec::new();
        for (log, survey) in surveys.iter().enumerate() {
            order.extend(survey.stretches.iter().enumerate().map(|(k, s)| (begins_s(survey, s.from_s), log, k, s.to_s - s.from_s)));
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let total_s: f64 = order.iter().map(|o| o.3).sum();
        let own_s: Vec<f64> = surveys.iter().map(|s| s.stretches.iter().map(|s| s.to_s - s.from_s).sum()).collect();
        let mut stretches: Vec<Vec<Progress>> = surveys.iter().map(|s| vec![[0.0; SPANS]; s.stretches.len()]).collect();
        let (mut passed_s, mut passed_own_s) = (0.0, vec![0.0; surveys.len()]);
        // sums of time and of time times progress
        let mut sums = PerGear::from_fn(|_| (1e-9, [0.0; SPANS]));
        for (_, log, stretch, length_s) in order {
            let share = |passed_s: f64, total_s: f64| 2.0 * (passed_s + 0.5 * length_s) / total_s.max(1e-9) - 1.0;
            let at = [share(passed_s, total_s), share(passed_own_s[log], own_s[log])];
            stretches[log][stretch] = at;
            passed_s += length_s;
            passed_own_s[log] += length_s;
            let (time_s, sum) = &mut sums[surveys[log].stretches[stretch].gear];
            *time_s += length_s;
            sum.iter_mut().zip(at).for_each(|(sum, at)| *sum += length_s * at);
        }
        let mean = PerGear::from_fn(|gear| sums[gear].1.map(|sum| sum / sums[gear].0));
        for (survey, own) in surveys.iter().zip(&mut stretches) {
            for (stretch, progress) in survey.stretches.iter().zip(own) {
                progress.iter_mut().zip(mean[stretch.gear]).for_each(|(at, mean)| *at -= mean);
            }
        }
        Self { stretches, end: PerGear::from_fn(|gear| mean[gear].map(|mean| 1.0 - mean)) }
    }
}
