//! Segments: stretches of readings on one clock, ready to be integrated.

use crate::fit::drive_form::campaign_drift::Progress;
use crate::fit::noise::model::{Noise, Reading};
use crate::map::Gear;

/// A stretch of readings without interruption.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Segment {
    /// Index of the log.
    pub(crate) log: usize,
    /// Index of the stretch in the log's survey: the unit that is left out in cross-validation, and resampled in the sandwich.
    pub(crate) run: usize,
    pub(crate) gear: Gear,
    /// Where the run lies in the campaign and in its log.
    pub(crate) progress: Progress,
    /// Where integration starts [s].
    pub(crate) start_s: f64,
    /// Whether the speed is 0 at the start.
    pub(crate) anchored: bool,
    /// Prior standard deviation of the speed at the start [m/s], before the noise of starts from rest is known.
    pub(crate) start_std_mps: f64,
    pub(crate) readings: Vec<Reading>,
}

impl Segment {
    /// Standard deviation of the speed at the start [m/s]; at a start from rest, as estimated.
    pub(crate) fn start_std(&self, noise: &Noise) -> f64 {
        if self.anchored { noise.start_scale * self.start_std_mps } else { self.start_std_mps }
    }

    /// Time that the segment takes [s].
    pub(crate) fn span_s(&self) -> f64 {
        self.readings.last().map_or(0.0, |r| r.t_s - self.start_s)
    }
}
