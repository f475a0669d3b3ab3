//! Readings and stretches that do not belong: spikes, slip that no second witness shows, pushes by hand.

use super::segment::{Cuts, Segment};
use crate::campaign::Verdict;

/// One innovation beyond this, with a normal successor, is a spike.
const SPIKE: f64 = 5.5;
/// Lengths of the windows over which innovations are summed.
const WINDOWS: [usize; 3] = [8, 15, 30];

/// Finds in the whitened residuals of a segment what to cut. `threshold` bounds the standardised windowed sums (5; 6 in a first pass).
pub(crate) fn find(segment: &Segment, white: &[f64], threshold: f64, cuts: &mut Cuts) {
    let n = white.len();
    for k in 0..n {
        let calm = |j: usize| white.get(j).is_none_or(|e| e.abs() < 3.0);
        if white[k].abs() > SPIKE && calm(k + 1) {
            let reading = segment.readings[k];
            cuts.readings.insert((reading.witness, reading.sample));
        }
    }
    // clip single spikes so that they do not condemn a window
    let clipped: Vec<f64> = white.iter().map(|e| e.clamp(-4.0, 4.0)).collect();
    let mut sums = vec![0.0; n + 1];
    for k in 0..n {
        sums[k + 1] = sums[k] + clipped[k];
    }
    let mut bad = vec![false; n];
    for window in WINDOWS {
        if n < window {
            continue;
        }
        for end in window..=n {
            let z = (sums[end] - sums[end - window]) / (window as f64).sqrt();
            if z.abs() > threshold {
                bad[end - window..end].fill(true);
            }
        }
    }
    let mut k = 0;
    while k < n {
        if !bad[k] {
            k += 1;
            continue;
        }
        let first = k;
        while k < n && bad[k] {
            k += 1;
        }
        let margin_s = 0.02;
        cuts.intervals.push((segment.readings[first].t_s - margin_s, segment.readings[k - 1].t_s + margin_s, Verdict::Push));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::kalman::Reading;
    use crate::map::Gear;

    fn segment(n: u32) -> Segment {
        let readings = (0..n).map(|k| Reading { t_s: f64::from(k) * 0.01, speed_mps: 0.0, witness: 1, sample: k }).collect();
        Segment { log: 0, run: 0, gear: Gear::Forward, start_s: 0.0, anchored: false, start_std_mps: 3.0, readings }
    }

    #[test]
    fn a_spike_is_one_reading_and_a_push_a_stretch() {
        let mut white: Vec<f64> = (0..200).map(|k| if k % 2 == 0 { 0.8 } else { -0.8 }).collect();
        white[50] = 9.0;
        for e in &mut white[100..120] {
            *e += 2.5;
        }
        let mut cuts = Cuts::default();
        find(&segment(200), &white, 5.0, &mut cuts);
        assert_eq!(cuts.readings, [(1, 50)].into());
        assert_eq!(cuts.intervals.len(), 1);
        let (from, to, verdict) = cuts.intervals[0];
        assert!(from < 1.0 && to > 1.19 && from > 0.6 && to < 1.6, "{from} {to}");
        assert_eq!(verdict, Verdict::Push);
    }
}
