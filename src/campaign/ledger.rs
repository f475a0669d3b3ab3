//! The ledger: number of samples and seconds per verdict.

use crate::campaign::SampleVerdict;
use crate::map::LedgerRow;
use crate::signal::Series;

/// The time that each sample represents [s]: half the distance to both neighbours, at most two periods where messages are missing.
pub(crate) fn sample_seconds(series: &Series) -> Vec<f64> {
    let period = series.median_period_s().min(1.0);
    let n = series.len();
    (0..n)
        .map(|i| {
            let before = if i > 0 { series.t_s[i] - series.t_s[i - 1] } else { period };
            let after = if i + 1 < n { series.t_s[i + 1] - series.t_s[i] } else { period };
            0.5 * (before.min(2.0 * period) + after.min(2.0 * period))
        })
        .collect()
}

/// Samples and seconds per verdict, in the order of [`SampleVerdict::ALL`], without verdicts that have no samples.
pub(crate) fn ledger(samples: impl IntoIterator<Item = (SampleVerdict, f64)>) -> Vec<LedgerRow> {
    let mut counts = [(0u64, 0.0f64); SampleVerdict::ALL.len()];
    for (verdict, seconds) in samples {
        let row = &mut counts[SampleVerdict::ALL.iter().position(|v| *v == verdict).unwrap_or(0)];
        row.0 += 1;
        row.1 += seconds;
    }
    SampleVerdict::ALL
        .iter()
        .zip(counts)
        .filter(|(_, (samples, _))| *samples > 0)
        .map(|(verdict, (samples, seconds))| LedgerRow { verdict: *verdict, samples, seconds: (seconds * 1e3).round() / 1e3 })
        .collect()
}
