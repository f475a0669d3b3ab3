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
pub fn ledger(samples: impl IntoIterator<Item = (SampleVerdict, f64)>) -> Vec<LedgerRow> {
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

/// The ledger of a whole log: time without any sample counts as a gap, so that the seconds add up to the length of the log.
pub fn with_missing(mut rows: Vec<LedgerRow>, missing_s: f64) -> Vec<LedgerRow> {
    let missing_s = (missing_s * 1e3).round() / 1e3;
    if missing_s <= 0.0 {
        return rows;
    }
    match rows.iter_mut().find(|row| row.verdict == SampleVerdict::Gap) {
        Some(gap) => gap.seconds = ((gap.seconds + missing_s) * 1e3).round() / 1e3,
        None => rows.push(LedgerRow { verdict: SampleVerdict::Gap, samples: 0, seconds: missing_s }),
    }
    rows.sort_by_key(|row| SampleVerdict::ALL.iter().position(|verdict| *verdict == row.verdict));
    rows
}

/// Time of a series that its samples do not represent [s].
pub(crate) fn missing_seconds(series: &Series, seconds: &[f64]) -> f64 {
    let span_s = series.t_s.last().zip(series.t_s.first()).map_or(0.0, |(last, first)| last - first);
    let ends_s = series.median_period_s().min(1.0);
    (span_s + ends_s - seconds.iter().sum::<f64>()).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seconds_of_a_ledger_add_up_to_the_length_of_the_log() {
        let t_s: Vec<f64> = (0..500).map(|k| f64::from(k) * 0.02).filter(|t| !(3.0..3.5).contains(t)).collect();
        let series = Series { value: vec![0.0; t_s.len()], t_s };
        let seconds = sample_seconds(&series);
        let rows = ledger(seconds.iter().map(|s| (SampleVerdict::Used, *s)));
        let rows = with_missing(rows, missing_seconds(&series, &seconds));
        let sum: f64 = rows.iter().map(|row| row.seconds).sum();
        assert!((sum - 10.0).abs() < 0.002 && rows.len() == 2, "{rows:?}");
    }
}
