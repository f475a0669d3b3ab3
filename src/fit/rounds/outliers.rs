//! Readings and stretches that do not fit the model: spikes, slip without a second speed source to show it, pushes by hand.

use crate::campaign::SampleVerdict;
use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::motion::coarse_readings::replace_coarse;
use crate::fit::motion::integration::courses;
use crate::fit::motion::log_data::{Cuts, LogData};
use crate::fit::motion::passes::Pass;
use crate::fit::motion::segment::Segment;
use crate::fit::motion::segmentation::segments_of;
use crate::fit::motion::so_far::SoFar;
use crate::fit::noise::model::Noise;
use crate::fit::surface::lattice::LatticeSurface;
use crate::map::PerGear;
use std::collections::BTreeSet;

/// One innovation beyond this, with a normal successor, is a spike.
const SPIKE: f64 = 5.5;
/// Lengths of the windows over which innovations are summed.
const WINDOWS: [usize; 3] = [8, 15, 30];

/// Most passes over a run: each cuts one window, and the filter restarts after it.
const PASSES: usize = 16;
/// Shortest stretch between two cuts that can be judged by itself [s].
const JOINED_S: f64 = 0.3;
/// Also cut before and after a window [s].
const MARGIN_S: f64 = 0.02;

/// Threshold of the standardised windowed sums in the first round with cuts, and later.
pub(crate) const CUT_BEYOND: [f64; 2] = [6.0, 5.0];

/// The reference for the readings.
pub(crate) struct Judge<'a> {
    pub(crate) calibration: &'a Calibration,
    pub(crate) lagged: &'a [EffectiveTorque],
    /// Forward, reverse.
    pub(crate) surfaces: &'a PerGear<LatticeSurface>,
    pub(crate) noise: &'a Noise,
    /// The moments after steps, which no static map explains; they are not judged.
    pub(crate) transients: &'a [Vec<(f64, f64)>],
}

impl Judge<'_> {
    /// Cuts each log again from all its readings, so that earlier mistakes are undone.
    pub(crate) fn cut(&self, logs: &mut [LogData], threshold: f64) {
        for log in &mut *logs {
            log.cuts = Cuts::default();
        }
        let calm = calm(self.noise, &self.surfaces.forward);
        // only runs that were cut are examined again
        let mut again: Option<BTreeSet<(usize, usize)>> = None;
        let so_far = SoFar { surfaces: self.surfaces, noise: self.noise };
        for pass in 0..PASSES {
            let mut segments = segments_of(logs, self.calibration, self.lagged, Some(so_far), self.transients, |log, run| {
                again.as_ref().map_or_else(|| logs[log].chosen[run], |again| again.contains(&(log, run)))
            });
            replace_coarse(&mut segments, logs, self.calibration, self.lagged, SoFar { noise: &calm, ..so_far });
            let courses = courses(&segments, self.lagged, self.calibration);
            let white = Pass { courses: &courses, surfaces: self.surfaces, noise: &calm }.along(None).white;
            let whole = pass + 1 == PASSES;
            let cut = |(s, white): (&Segment, &Vec<f64>)| find(s, white, threshold, whole, &mut logs[s.log].cuts).then_some((s.log, s.run));
            let found: BTreeSet<(usize, usize)> = segments.iter().zip(&white).filter_map(cut).collect();
            if found.is_empty() {
                break;
            }
            again = Some(found);
        }
        for log in logs {
            join(&mut log.cuts);
        }
    }
}

/// The noise for judging outliers: offset and disturbance at most a fiftieth of the accelerations that the torque commands, so that a push,
/// which is a disturbance, does not explain itself.
pub(crate) fn calm(noise: &Noise, surface: &LatticeSurface) -> Noise {
    let most = (0.02 * surface.range_mps2()).max(0.01);
    Noise { disturbance_mps2: noise.disturbance_mps2.min(most), offset_mps2: noise.offset_mps2.min(most), ..*noise }
}

/// Finds the cuts in the whitened residuals of a segment, and whether a stretch was cut. `threshold` bounds the standardised windowed sums
/// (5; 6 in a first pass). Only the first window beyond it is cut: after a push the filter is off and all later readings look wrong. They
/// are judged in the next pass, from an unknown speed. With `whole`, every window beyond the threshold is cut.
fn find(segment: &Segment, white: &[f64], threshold: f64, whole: bool, cuts: &mut Cuts) -> bool {
    let n = white.len();
    // clip single spikes so that they do not cut a window
    let mut sums = vec![0.0; n + 1];
    for k in 0..n {
        sums[k + 1] = sums[k] + white[k].clamp(-4.0, 4.0);
    }
    let beyond = |end: usize| {
        WINDOWS.into_iter().filter(|window| end >= *window).find(|window| {
            let z = (sums[end] - sums[end - window]) / (*window as f64).sqrt();
            z.abs() > threshold
        })
    };
    let mut cut = false;
    for end in 1..=n {
        if let Some(window) = beyond(end) {
            let (from, to) = (segment.readings[end - window].t_s - MARGIN_S, segment.readings[end - 1].t_s + MARGIN_S);
            cuts.intervals.push((from, to, SampleVerdict::Push));
            cut = true;
            if !whole {
                break;
            }
        }
    }
    // spikes are judged only if no window was cut: the filter is then on track
    if !cut {
        for k in 0..n {
            let calm = |j: usize| white.get(j).is_none_or(|e| e.abs() < 3.0);
            if white[k].abs() > SPIKE && calm(k + 1) {
                let reading = segment.readings[k];
                cuts.readings.insert((reading.source, reading.sample));
            }
        }
    }
    cut
}

/// Joins cuts that overlap or that leave too little between them to be judged.
fn join(cuts: &mut Cuts) {
    cuts.intervals.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut joined: Vec<(f64, f64, SampleVerdict)> = Vec::new();
    for cut in cuts.intervals.drain(..) {
        match joined.last_mut() {
            Some(last) if cut.0 - last.1 < JOINED_S => last.1 = last.1.max(cut.1),
            _ => joined.push(cut),
        }
    }
    cuts.intervals = joined;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::noise::model::Reading;
    use crate::map::Gear;

    fn segment(n: u32) -> Segment {
        let readings = (0..n).map(|k| Reading::single(f64::from(k) * 0.01, 0.0, 1, k)).collect();
        Segment { log: 0, run: 0, gear: Gear::Forward, progress: [0.0; 2], start_s: 0.0, anchored: false, start_std_mps: 3.0, readings }
    }

    #[test]
    fn a_spike_is_one_reading_and_a_push_a_stretch() {
        let mut white: Vec<f64> = (0..200).map(|k| if k % 2 == 0 { 0.8 } else { -0.8 }).collect();
        white[50] = 9.0;
        let mut cuts = Cuts::default();
        assert!(!find(&segment(200), &white, 5.0, false, &mut cuts));
        assert_eq!(cuts.readings, [(1, 50)].into());
        for e in &mut white[100..120] {
            *e += 2.5;
        }
        // one window a pass, the first one; all of it when there are no passes left
        assert!(find(&segment(200), &white, 5.0, false, &mut cuts));
        assert!(cuts.intervals.len() == 1 && cuts.intervals[0].1 < 1.2);
        find(&segment(200), &white, 5.0, true, &mut cuts);
        join(&mut cuts);
        assert_eq!(cuts.intervals.len(), 1);
        let (from, to, verdict) = cuts.intervals[0];
        assert!(from < 1.0 && to > 1.19 && from > 0.6 && to < 1.6, "{from} {to}");
        assert_eq!(verdict, SampleVerdict::Push);
    }
}
