//! Detects rest of the wheel by a smoothed rule over all speed sources. A rule of three samples below half a quantum would find only a
//! part of the rest of a real encoder.

use crate::signal::{Series, noise_std, quantum};

/// Smallest number of readings at rest whose mean is more accurate than the median near zero.
const FEWEST_AT_REST: usize = 20;

/// Distinguishes rest from motion by the mean of each speed source over a short window.
#[derive(Debug, Clone)]
pub(crate) struct RestDetector {
    sources: Vec<RestingSource>,
    half_width_s: f64,
}

#[derive(Debug, Clone)]
struct RestingSource {
    series: Series,
    smooth: Vec<f64>,
    threshold_mps: f64,
    bias_mps: f64,
}

impl RestDetector {
    /// Half of the averaging window [s]: three to eleven samples at usual rates, short compared with a stop.
    pub(crate) const HALF_WIDTH_S: f64 = 0.06;
    /// Time at both ends of a rest that is not used for the bias [s].
    pub(crate) const MARGIN_S: f64 = 0.25;

    /// From the speed sources [m/s]. A source is at rest where its mean over ±[`Self::HALF_WIDTH_S`] is within 3 standard errors of its
    /// bias, or half a quantum, or 4 mm/s, whichever is largest. The bias (of a gyro, for example) is first the median of the smoothed
    /// signal near zero, then the mean over the rest detected with it, without [`Self::MARGIN_S`] at either end: a start is detected some
    /// 50 ms late, and its first few millimetres per second would otherwise count as bias in every rest.
    pub(crate) fn new<'a>(sources: impl IntoIterator<Item = &'a Series>) -> Self {
        let half_width_s = Self::HALF_WIDTH_S;
        let sources: Vec<RestingSource> = sources
            .into_iter()
            .filter(|s| s.len() > 2)
            .map(|series| {
                let smooth = series.smoothed(half_width_s);
                let step = quantum(&series.value);
                let noise = noise_std(&series.value).max(step / 12f64.sqrt());
                let in_window = (2.0 * half_width_s / series.median_period_s()).max(1.0);
                let threshold_mps = (3.5 * noise / in_window.sqrt()).max(0.5 * step).max(0.004);
                let bias_mps = resting_bias(&smooth, 2.0 * threshold_mps);
                RestingSource { series: series.clone(), smooth, threshold_mps, bias_mps }
            })
            .collect();
        let mut detector = Self { sources, half_width_s };
        let biases: Vec<Option<f64>> = detector.sources.iter().map(|w| detector.mean_at_rest(w)).collect();
        for (source, bias_mps) in detector.sources.iter_mut().zip(biases) {
            source.bias_mps = bias_mps.unwrap_or(source.bias_mps);
        }
        detector
    }

    /// Mean of a source well inside the rests; `None` if there are too few samples.
    fn mean_at_rest(&self, source: &RestingSource) -> Option<f64> {
        let series = &source.series;
        let (mut sum, mut count) = (0.0, 0usize);
        let mut rest_s: Option<(f64, f64)> = None;
        // often enough to find the end of a rest
        let stride = (0.25 * self.half_width_s / series.median_period_s()).max(1.0) as usize;
        let times_s = || series.t_s.iter().copied().step_by(stride).chain([f64::INFINITY]);
        for (t_s, at_rest) in times_s().zip(self.are_at_rest(times_s())) {
            if at_rest {
                rest_s = Some((rest_s.map_or(t_s, |r| r.0), t_s));
            } else if let Some((from_s, to_s)) = rest_s.take() {
                let inner = series.range(from_s + Self::MARGIN_S, to_s - Self::MARGIN_S);
                sum += series.value[inner.clone()].iter().sum::<f64>();
                count += inner.len();
            }
        }
        (count >= FEWEST_AT_REST).then(|| sum / count as f64)
    }

    /// Whether every source with a sample near `t_s` is at rest; `false` if there is no such sample.
    #[cfg(test)]
    pub(crate) fn is_at_rest(&self, t_s: f64) -> bool {
        let mut before: Vec<usize> = self.sources.iter().map(|w| w.series.t_s.partition_point(|t| *t < t_s)).collect();
        self.rests(t_s, &mut before)
    }

    /// The same at several ascending times.
    pub(crate) fn are_at_rest(&self, times_s: impl IntoIterator<Item = f64>) -> impl Iterator<Item = bool> {
        let mut before = vec![0; self.sources.len()];
        times_s.into_iter().map(move |t_s| self.rests(t_s, &mut before))
    }

    /// Whether all are at rest at `t_s`; `before` holds the number of samples of each source before the time of the last query, not later
    /// than `t_s`.
    fn rests(&self, t_s: f64, before: &mut [usize]) -> bool {
        let mut any = false;
        for (w, before) in self.sources.iter().zip(before) {
            let times = &w.series.t_s;
            while times.get(*before).is_some_and(|t| *t < t_s) {
                *before += 1;
            }
            let distance = |k: &usize| (times[*k] - t_s).abs();
            let near = [before.checked_sub(1), Some(*before)].into_iter().flatten();
            let near = near.filter(|k| times.get(*k).is_some_and(|t| *t >= t_s - self.half_width_s && *t <= t_s + self.half_width_s));
            let Some(nearest) = near.min_by(|a, b| distance(a).total_cmp(&distance(b))) else { continue };
            any = true;
            if (w.smooth[nearest] - w.bias_mps).abs() > w.threshold_mps {
                return false;
            }
        }
        any
    }

    /// Bias of each source at rest [m/s], in the given order.
    pub(crate) fn biases_mps(&self) -> Vec<f64> {
        self.sources.iter().map(|w| w.bias_mps).collect()
    }
}

/// Median of the smoothed values within ±`width` of zero: the bias at rest, because a vehicle passes zero quickly and rests are long.
fn resting_bias(smooth: &[f64], width: f64) -> f64 {
    let near: Vec<f64> = smooth.iter().copied().filter(|v| v.abs() < width).collect();
    if near.len() < 10 { 0.0 } else { crate::signal::median(&near) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rest_and_motion_are_distinguished_on_a_quantised_biased_signal() {
        let t_s: Vec<f64> = (0..500).map(|k| f64::from(k) * 0.02).collect();
        let value = t_s
            .iter()
            .enumerate()
            .map(|(k, t)| {
                let noise = [0.004, -0.006, 0.0, 0.007, -0.005][k % 5];
                (((if *t < 5.0 { 0.0 } else { 0.3 * (t - 5.0) }) + noise + 0.0015) / 0.0096).round() * 0.0096
            })
            .collect();
        let detector = RestDetector::new([&Series { t_s, value }]);
        assert!((0..48).all(|k| detector.is_at_rest(0.1 + f64::from(k) * 0.1)));
        assert!((0..40).all(|k| !detector.is_at_rest(5.2 + f64::from(k) * 0.1)));
    }
}
