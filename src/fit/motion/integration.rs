//! A segment with the effective torque along it, ready to be integrated with any speeds and any surface.
//!
//! ∫f(V̂(t), u(t))dt by the midpoint rule: steps of at most 5 ms while the torque moves, 10 ms during its last twentieth, 20 ms while it is
//! constant, and never across a reading.

use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::lagged_command::Share;
use crate::fit::drive_form::campaign_drift::{DriftNow, SPANS};
use crate::fit::drive_form::parameters::PARAMETERS;
use crate::fit::drive_form::torque::Torque;
use crate::fit::drive_form::torque_limit::TorqueLimit;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::segment::Segment;
use crate::fit::nuisance;
use crate::fit::surface::lattice::LatticeSurface;
use crate::map::PerGear;
use rayon::prelude::*;

/// Share of the largest torque still to come, with the longest step of the integration until then [s].
const LONGEST_STEP: [(f64, f64); 2] = [(0.05, 5e-3), (1e-3, 10e-3)];
/// Longest step while the torque is constant [s].
const LONGEST_STANDING_S: f64 = 20e-3;

/// One step of the integration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct IntegrationStep {
    /// Position of its middle between the reading before and the reading after.
    pub(crate) fraction: f64,
    pub(crate) length_s: f64,
    /// In the gear's frame.
    pub(crate) torque: Torque,
}

/// The integration steps of one segment.
#[derive(Debug, Clone)]
pub(crate) struct Course<'a> {
    pub(crate) segment: &'a Segment,
    steps: Vec<IntegrationStep>,
    /// Number of steps up to and including each reading.
    ends: Vec<u32>,
    limit: TorqueLimit,
    /// The change at this time of the campaign.
    drift: DriftNow,
}

impl<'a> Course<'a> {
    /// Along `segment` with the effective torque of its log, `dead_time_s` late.
    pub(crate) fn new(segment: &'a Segment, lagged: &EffectiveTorque, dead_time_s: f64) -> Self {
        let sign = segment.gear.sign();
        let mut cursor = lagged.cursor();
        let mut steps = Vec::with_capacity(2 * segment.readings.len());
        let mut ends = Vec::with_capacity(segment.readings.len());
        let longest = LONGEST_STEP.map(|(share, step_s)| (Share::new(share), step_s));
        let mut from_s = segment.start_s;
        for reading in &segment.readings {
            let length_s = (reading.t_s - from_s).max(0.0);
            let moving = |(share, _): &&(Share, f64)| cursor.moves(from_s - dead_time_s, reading.t_s - dead_time_s, *share);
            let longest_s = longest.iter().find(moving).map_or(LONGEST_STANDING_S, |(_, s)| *s);
            let count = (length_s / longest_s).ceil().max(1.0);
            for k in 0..count as usize {
                let fraction = (k as f64 + 0.5) / count;
                let torque = cursor.at(from_s + fraction * length_s - dead_time_s).in_gear(sign);
                steps.push(IntegrationStep { fraction, length_s: length_s / count, torque });
            }
            ends.push(steps.len() as u32);
            from_s = reading.t_s.max(from_s);
        }
        Self { segment, steps, ends, limit: lagged.limit(), drift: lagged.drift().at(segment.progress) }
    }

    /// Share by which friction has changed at this time of the campaign.
    pub(crate) fn friction_share(&self) -> f64 {
        self.drift.friction_share
    }

    /// Number of readings.
    pub(crate) fn rows(&self) -> usize {
        self.ends.len()
    }

    /// The steps that lead to a reading.
    pub(crate) fn steps(&self, row: usize) -> &[IntegrationStep] {
        let from = if row > 0 { self.ends[row - 1] as usize } else { 0 };
        &self.steps[from..self.ends[row] as usize]
    }

    /// The steps that lead to a reading, each with its speed [m/s] and the torque that is delivered at it: linear from the filtered speed at
    /// the reading before to the expected speed at this one, 0 at an anchored start, never negative.
    pub(crate) fn along<'b>(&'b self, speeds: &'b Speeds, row: usize) -> impl Iterator<Item = (f64, IntegrationStep)> + 'b {
        let from = if row > 0 {
            speeds.after[row - 1]
        } else if self.segment.anchored {
            0.0
        } else {
            speeds.before[0]
        };
        let rise = speeds.before[row] - from;
        self.steps(row).iter().map(move |step| {
            let speed_mps = (from + step.fraction * rise).max(0.0);
            let mut torque = self.limit.delivered(speed_mps, step.torque);
            torque.torque_nm *= 1.0 + self.drift.torque_share;
            (speed_mps, IntegrationStep { torque, ..*step })
        })
    }

    /// The speed that a surface predicts at each reading, from 0 at the segment's start [m/s].
    pub(crate) fn predicted(&self, speeds: &Speeds, surface: &LatticeSurface) -> Vec<f64> {
        self.predicted_with(speeds, surface, &[])
    }

    /// The same after changes of the nuisance values (`nuisance`), in their order; those of the encoder are not a part of the prediction.
    pub(crate) fn predicted_with(&self, speeds: &Speeds, surface: &LatticeSurface, changes: &[f64]) -> Vec<f64> {
        let change = |k: usize| changes.get(k).copied().unwrap_or(0.0);
        let drive: [f64; PARAMETERS] = std::array::from_fn(|p| change(nuisance::DRIVE + p));
        let dead_time_s = change(nuisance::DEAD_TIME + self.segment.log);
        let of_spans = |first: usize| -> f64 { (0..SPANS).map(|k| self.segment.progress[k] * change(first + k)).sum() };
        let friction_share = self.drift.friction_share + of_spans(nuisance::DRIFT_FRICTION);
        let torque_share = of_spans(nuisance::DRIFT_TORQUE);
        let mut sum = 0.0;
        (0..self.rows())
            .map(|row| {
                for (v, step) in self.along(speeds, row) {
                    let Torque { torque_nm, by_drive, by_dead_time } = step.torque;
                    let by_drive: f64 = drive.iter().zip(by_drive).map(|(change, by)| change * by).sum();
                    let torque_nm = torque_nm * (1.0 + torque_share) + by_drive + dead_time_s * by_dead_time;
                    sum += step.length_s * surface.accel_mps2(v, torque_nm);
                    if friction_share != 0.0 {
                        sum += step.length_s * friction_share * surface.accel_mps2(v, 0.0);
                    }
                }
                sum
            })
            .collect()
    }
}

/// The courses of segments: `lagged` holds the effective torque of each log.
pub(crate) fn courses<'a>(segments: &'a [Segment], lagged: &[EffectiveTorque], calibration: &Calibration) -> Vec<Course<'a>> {
    segments.par_iter().map(|s| Course::new(s, &lagged[s.log], calibration.dead_time_s[s.log])).collect()
}

/// The same segments under other delays.
pub(crate) fn courses_again<'a>(courses: &[Course<'a>], lagged: &[EffectiveTorque], calibration: &Calibration) -> Vec<Course<'a>> {
    courses.par_iter().map(|c| Course::new(c.segment, &lagged[c.segment.log], calibration.dead_time_s[c.segment.log])).collect()
}

/// The surface of a segment's gear among those of both: forward, reverse.
pub(crate) fn surface_of<'a>(surfaces: &'a PerGear<LatticeSurface>, segment: &Segment) -> &'a LatticeSurface {
    &surfaces[segment.gear]
}
