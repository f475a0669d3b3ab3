//! Robust measures of noise: median, noise of a slowly varying signal, quantum.

/// Median of finite values; the mean of the middle two for an even number, NaN for none.
pub fn median(values: &[f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) }
}

/// Which values stand out by Hampel's rule: farther from the median of the seven around than `mads` scaled median absolute deviations, or
/// than `mads` times `floor`, whichever is larger (Hampel 1974, *The influence curve and its role in robust estimation*).
pub fn hampel(values: &[f64], mads: f64, floor: f64) -> Vec<bool> {
    let n = values.len();
    let mut around = [0.0f64; 7];
    (0..n)
        .map(|i| {
            let window = &values[i.saturating_sub(3)..(i + 4).min(n)];
            let around = &mut around[..window.len()];
            around.copy_from_slice(window);
            let centre = median_in_place(around);
            around.iter_mut().zip(window).for_each(|(d, v)| *d = (v - centre).abs());
            (values[i] - centre).abs() > mads * (1.4826 * median_in_place(around)).max(floor)
        })
        .collect()
}

/// Median of a few values, which it sorts.
fn median_in_place(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

/// Standard deviation of white noise on a slowly varying signal, from the median absolute second difference:
/// a second difference of white noise has standard deviation √6·σ, and the median of its magnitude is 0.6745 of that.
/// 0 for fewer than three values.
pub fn noise_std(values: &[f64]) -> f64 {
    let second: Vec<f64> = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    if second.is_empty() { 0.0 } else { median(&second) / (0.674_489_750_196_082 * 6f64.sqrt()) }
}

/// Quantum of a digitised signal: the smallest step that explains nearly all differences between neighbouring values, 0 where the signal
/// takes ever new values.
pub fn quantum(values: &[f64]) -> f64 {
    let scale = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let mut steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > scale * 1e-9).collect();
    if steps.len() < 20 {
        return 0.0;
    }
    steps.sort_unstable_by(f64::total_cmp);
    let candidate = steps[steps.len() / 50];
    if candidate <= 0.0 {
        return 0.0;
    }
    let whole = steps.iter().filter(|d| (*d / candidate - (*d / candidate).round()).abs() < 0.05).count();
    if whole as f64 > 0.95 * steps.len() as f64 { candidate } else { 0.0 }
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
    fn the_quantum_of_counts_is_found_and_none_where_there_is_none() {
        let counts: Vec<f64> = (0..500).map(|k| (f64::from(k) * 0.37).sin() * 40.0).map(|v| v.round() * 0.0096).collect();
        assert!((quantum(&counts) - 0.0096).abs() < 1e-9);
        let smooth: Vec<f64> = (0..500).map(|k| (f64::from(k) * 0.37).sin()).collect();
        assert!(quantum(&smooth).abs() < 1e-12);
    }
}
