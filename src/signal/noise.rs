//! Robust measures of noise: median, noise of a slowly varying signal, quantum.

/// Median of finite values: the mean of the middle two for an even number, NaN without values.
pub(crate) fn median(values: &[f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    median_of(&mut values.to_vec())
}

/// Like [`median`], for at least one value; their order is lost.
pub(crate) fn median_of(values: &mut [f64]) -> f64 {
    let odd = values.len() % 2 == 1;
    let (below, upper, _) = values.select_nth_unstable_by(values.len() / 2, f64::total_cmp);
    let lower = below.iter().copied().max_by(f64::total_cmp);
    lower.filter(|_| !odd).map_or(*upper, |lower| 0.5 * (lower + *upper))
}

/// Outliers by Hampel's rule: the distance from the median of the seven values around exceeds `mads` scaled median absolute deviations and
/// `mads` times `floor` (Hampel 1974, *The influence curve and its role in robust estimation*).
pub(crate) fn hampel(values: &[f64], mads: f64, floor: f64) -> Vec<bool> {
    let n = values.len();
    let mut around = [0.0f64; 7];
    (0..n)
        .map(|i| {
            let window = &values[i.saturating_sub(3)..(i + 4).min(n)];
            let around = &mut around[..window.len()];
            around.copy_from_slice(window);
            let centre = median_of_few(around);
            let away = (values[i] - centre).abs();
            // few values are beyond the floor: only then are the deviations sorted
            away > mads * floor && {
                around.iter_mut().zip(window).for_each(|(d, v)| *d = (v - centre).abs());
                away > mads * (1.4826 * median_of_few(around))
            }
        })
        .collect()
}

/// Median of a few values, at least one; their order is lost.
pub(crate) fn median_of_few(values: &mut [f64]) -> f64 {
    // seven values by a fixed sequence of comparisons (Devillard 1998, *Fast median search*), because nearly all windows have seven
    const SWAPS: [(usize, usize); 13] =
        [(0, 5), (0, 3), (1, 6), (2, 4), (0, 1), (3, 5), (2, 6), (2, 3), (3, 6), (4, 5), (1, 4), (1, 3), (3, 4)];
    if let Ok(seven) = <&mut [f64; 7]>::try_from(&mut *values) {
        for (a, b) in SWAPS {
            let (x, y) = (seven[a], seven[b]);
            (seven[a], seven[b]) = if y < x { (y, x) } else { (x, y) };
        }
        return seven[3];
    }
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

/// Standard deviation of white noise on a slowly varying signal, from the median absolute second difference:
/// a second difference of white noise has standard deviation √6·σ, and the median of its magnitude is 0.6745 of that.
/// 0 for fewer than three values.
pub(crate) fn noise_std(values: &[f64]) -> f64 {
    let mut second: Vec<f64> = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    if second.is_empty() { 0.0 } else { median_of(&mut second) / (0.674_489_750_196_082 * 6f64.sqrt()) }
}

/// Quantum of a digitised signal: the smallest step that explains nearly all differences between neighbouring values; 0 if the values are
/// continuous.
pub(crate) fn quantum(values: &[f64]) -> f64 {
    let scale = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let mut steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > scale * 1e-9).collect();
    if steps.len() < 20 {
        return 0.0;
    }
    let number = steps.len() / 50;
    let candidate = *steps.select_nth_unstable_by(number, f64::total_cmp).1;
    if candidate <= 0.0 {
        return 0.0;
    }
    // a few steps are enough to recognise a signal without a quantum
    let most_broken = 0.05 * steps.len() as f64;
    let broken = steps.iter().filter(|d| (*d / candidate - (*d / candidate).round()).abs() >= 0.05);
    if broken.take(most_broken.ceil() as usize).count() as f64 >= most_broken { 0.0 } else { candidate }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    #[test]
    fn the_noise_of_a_noisy_parabola_is_found() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let normal = Normal::new(0.0, 0.02).expect("a finite deviation");
        let values: Vec<f64> = (0..4000).map(|k| 1e-7 * f64::from(k * k) + normal.sample(&mut rng)).collect();
        // the relative standard error of a median absolute deviation of 4000 (correlated) values is about 3 %
        assert!((noise_std(&values) / 0.02 - 1.0).abs() < 0.1);
    }

    #[test]
    fn a_median_is_that_of_the_sorted_values() {
        let values = [3.0, -1.0, 7.0, 2.0, 2.0, 9.0, 0.5, -4.0, 6.0, 1.0];
        for n in 1..=values.len() {
            let mut sorted = values[..n].to_vec();
            sorted.sort_unstable_by(f64::total_cmp);
            let wanted = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
            assert!(median(&values[..n]) == wanted && median_of_few(&mut values[..n].to_vec()) == wanted, "{n}");
        }
    }

    #[test]
    fn the_quantum_of_counts_is_found_and_none_where_there_is_none() {
        let counts: Vec<f64> = (0..500).map(|k| (f64::from(k) * 0.37).sin() * 40.0).map(|v| v.round() * 0.0096).collect();
        assert!((quantum(&counts) - 0.0096).abs() < 1e-9);
        let smooth: Vec<f64> = (0..500).map(|k| (f64::from(k) * 0.37).sin()).collect();
        assert!(quantum(&smooth).abs() < 1e-12);
    }
}
