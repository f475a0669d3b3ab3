//! One signal over time.

/// Values over time, times not decreasing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Times [s] since the log's first sample.
    pub t_s: Vec<f64>,
    /// Values, in SI.
    pub value: Vec<f64>,
}

impl Series {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether it has no samples.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// Number of samples at or before `t_s`.
    pub fn count_until(&self, t_s: f64) -> usize {
        self.t_s.partition_point(|&t| t <= t_s)
    }

    /// The last value at or before `t_s`, for a held signal (a command, a gear); before the first sample, the first value.
    /// `None` for an empty series.
    pub fn held(&self, t_s: f64) -> Option<f64> {
        self.held_after(self.count_until(t_s))
    }

    /// Linear interpolation; the first and last values are held beyond the ends. `None` for an empty series.
    pub fn interpolated(&self, t_s: f64) -> Option<f64> {
        self.interpolated_after(self.count_until(t_s), t_s)
    }

    /// The value held after `upper` samples.
    fn held_after(&self, count: usize) -> Option<f64> {
        self.value.get(count.saturating_sub(1)).copied()
    }

    /// Linear interpolation at a time with `upper` samples at or before it.
    fn interpolated_after(&self, upper: usize, t_s: f64) -> Option<f64> {
        if upper == 0 || upper == self.len() {
            return self.held_after(upper);
        }
        let (t0, t1) = (self.t_s[upper - 1], self.t_s[upper]);
        let fraction = if t1 > t0 { (t_s - t0) / (t1 - t0) } else { 0.0 };
        Some(self.value[upper - 1] + fraction * (self.value[upper] - self.value[upper - 1]))
    }

    /// A cursor at the start.
    pub fn cursor(&self) -> SeriesCursor<'_> {
        SeriesCursor { series: self, passed: 0 }
    }

    /// Indices of the samples with `from_s` ≤ t ≤ `to_s`.
    pub fn range(&self, from_s: f64, to_s: f64) -> std::ops::Range<usize> {
        let start = self.t_s.partition_point(|&t| t < from_s);
        start..self.count_until(to_s).max(start)
    }

    /// Median time between samples [s]; infinite for fewer than two samples.
    pub fn median_period_s(&self) -> f64 {
        let steps: Vec<f64> = self.t_s.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
        if steps.is_empty() { f64::INFINITY } else { crate::signal::median(&steps) }
    }

    /// The samples within ±`half_width_s` of each sample.
    fn around(&self, half_width_s: f64) -> impl Iterator<Item = std::ops::Range<usize>> {
        let (mut from, mut to) = (0, 0);
        self.t_s.iter().map(move |&t| {
            while self.t_s[from] < t - half_width_s {
                from += 1;
            }
            while to < self.len() && self.t_s[to] <= t + half_width_s {
                to += 1;
            }
            from..to
        })
    }

    /// Mean of the samples within ±`half_width_s` of each sample: a centred moving average.
    pub fn smoothed(&self, half_width_s: f64) -> Vec<f64> {
        let mut sums = Vec::with_capacity(self.len() + 1);
        sums.push(0.0);
        for v in &self.value {
            sums.push(sums[sums.len() - 1] + v);
        }
        self.around(half_width_s).map(|near| (sums[near.end] - sums[near.start]) / near.len() as f64).collect()
    }

    /// Slope of the least-squares line through the samples within ±`half_width_s` of each sample [1/s]; 0 for fewer than three samples.
    pub fn slopes(&self, half_width_s: f64) -> Vec<f64> {
        self.around(half_width_s)
            .map(|range| {
                let n = range.len() as f64;
                if n < 3.0 {
                    return 0.0;
                }
                let mean_t = self.t_s[range.clone()].iter().sum::<f64>() / n;
                let mean_v = self.value[range.clone()].iter().sum::<f64>() / n;
                let (mut stt, mut stv) = (0.0, 0.0);
                for k in range {
                    let dt = self.t_s[k] - mean_t;
                    stt += dt * dt;
                    stv += dt * (self.value[k] - mean_v);
                }
                if stt > 0.0 { stv / stt } else { 0.0 }
            })
            .collect()
    }
}

/// A position in a series that moves with time: a query near the last one needs no search.
#[derive(Debug, Clone)]
pub struct SeriesCursor<'a> {
    series: &'a Series,
    /// Number of samples at or before the time of the last query.
    passed: usize,
}

impl SeriesCursor<'_> {
    /// Like [`Series::held`].
    pub fn held(&mut self, t_s: f64) -> Option<f64> {
        self.move_to(t_s);
        self.series.held_after(self.passed)
    }

    /// Like [`Series::interpolated`].
    pub fn interpolated(&mut self, t_s: f64) -> Option<f64> {
        self.move_to(t_s);
        self.series.interpolated_after(self.passed, t_s)
    }

    fn move_to(&mut self, t_s: f64) {
        let times = &self.series.t_s;
        while times.get(self.passed).is_some_and(|&t| t <= t_s) {
            self.passed += 1;
        }
        while self.passed > 0 && times[self.passed - 1] > t_s {
            self.passed -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn ramp() -> Series {
        Series { t_s: vec![0.0, 0.1, 0.2, 0.3], value: vec![0.0, 1.0, 2.0, 3.0] }
    }

    #[test]
    fn a_held_signal_keeps_its_last_value_and_an_interpolated_one_does_not() {
        assert_eq!(ramp().held(0.19), Some(1.0));
        assert!((ramp().interpolated(0.15).unwrap() - 1.5).abs() < 1e-12);
        assert_eq!(ramp().held(-1.0), Some(0.0));
        assert_eq!(ramp().interpolated(9.0), Some(3.0));
    }

    #[test]
    fn a_cursor_gives_the_same_values_as_the_series_in_both_directions() {
        let ramp = ramp();
        let mut cursor = ramp.cursor();
        for t_s in [-1.0, 0.05, 0.1, 0.29, 9.0, 0.15, -0.1, 0.3] {
            assert_eq!((cursor.held(t_s), cursor.interpolated(t_s)), (ramp.held(t_s), ramp.interpolated(t_s)));
        }
    }

    #[test]
    fn slopes_and_means_of_a_ramp_are_exact() {
        assert!(ramp().slopes(0.11).iter().skip(1).take(2).all(|s| (s - 10.0).abs() < 1e-9));
        assert!((ramp().smoothed(0.11)[1] - 1.0).abs() < 1e-12);
    }
}
