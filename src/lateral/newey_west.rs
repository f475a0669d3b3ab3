//! The mean of a correlated series and its standard error.
//!
//! Var(mean) = [γ₀ + 2 Σ_{l≤L} (1 − l/(L+1)) γ_l]/n, γ_l the autocovariances, with L = ⌊4 (n/100)^{2/9}⌋. Sources: Newey & West (1987), *A
//! Simple, Positive Semi-Definite, Heteroskedasticity and Autocorrelation Consistent Covariance Matrix*, Econometrica 55(3), for the
//! weights; (1994), *Automatic Lag Selection in Covariance Matrix Estimation*, Rev. Econ. Stud. 61(4), for L.

/// A mean and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Mean {
    /// Mean.
    pub mean: f64,
    /// Standard error; infinite for fewer than two values.
    pub std_err: f64,
}

/// Weighted mean of `values` in their order, with its standard error. A weight is the number of readings of a value.
pub(crate) fn newey_west(values: &[f64], weights: &[f64]) -> Mean {
    let n = values.len().min(weights.len());
    let total: f64 = weights[..n].iter().sum();
    if n == 0 || total <= 0.0 {
        return Mean { mean: 0.0, std_err: f64::INFINITY };
    }
    let mean = values[..n].iter().zip(weights).map(|(v, w)| v * w).sum::<f64>() / total;
    if n < 2 {
        return Mean { mean, std_err: f64::INFINITY };
    }
    // u_i: contribution to the mean, times n
    let scores: Vec<f64> = (0..n).map(|i| weights[i] / total * n as f64 * (values[i] - mean)).collect();
    let products: f64 = scores.windows(2).map(|w| w[0] * w[1]).sum();
    let squares: f64 = scores[..n - 1].iter().map(|s| s * s).sum();
    let rho = if squares > 0.0 { (products / squares).clamp(-MOST_MEMORY, MOST_MEMORY) } else { 0.0 };
    let white: Vec<f64> = scores.windows(2).map(|w| w[1] - rho * w[0]).collect();
    let m = white.len();
    let covariance = |lag: usize| white[lag..].iter().zip(&white).map(|(a, b)| a * b).sum::<f64>() / m as f64;
    let lags = ((4.0 * (m as f64 / 100.0).powf(2.0 / 9.0)).floor() as usize).min(m - 1);
    let long_run = covariance(0) + 2.0 * (1..=lags).map(|l| (1.0 - l as f64 / (lags + 1) as f64) * covariance(l)).sum::<f64>();
    Mean { mean, std_err: (long_run.max(0.0) / n as f64).sqrt() / (1.0 - rho) }
}

/// Largest accepted AR(1) coefficient.
const MOST_MEMORY: f64 = 0.97;

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    /// An AR(1) series of standard deviation 1.
    fn series(rho: f64, n: usize, random: &mut Pcg64) -> Vec<f64> {
        let mut x: f64 = StandardNormal.sample(random);
        let fresh = (1.0 - rho * rho).sqrt();
        (0..n)
            .map(|_| {
                let e: f64 = StandardNormal.sample(random);
                x = rho * x + fresh * e;
                x
            })
            .collect()
    }

    #[test]
    fn the_standard_error_covers_the_scatter_of_means_of_a_correlated_series() {
        let (n, rho, trials) = (200, 0.5, 2000);
        let mut random = Pcg64::new(7, 1);
        let means: Vec<Mean> = (0..trials).map(|_| newey_west(&series(rho, n, &mut random), &vec![1.0; n])).collect();
        let scatter = (means.iter().map(|m| m.mean * m.mean).sum::<f64>() / f64::from(trials)).sqrt();
        let estimated = (means.iter().map(|m| m.std_err * m.std_err).sum::<f64>() / f64::from(trials)).sqrt();
        let naive = (1.0 / n as f64).sqrt();
        // the true value is √3 times the naive one; 2000 trials give the scatter to 1.6 %, and the estimated mean biases ρ by −3/n
        assert!((scatter / naive - 3.0_f64.sqrt()).abs() < 0.1, "{}", scatter / naive);
        assert!((0.93..1.04).contains(&(estimated / scatter)), "{}", estimated / scatter);
    }

    #[test]
    fn weights_and_short_series() {
        let mean = newey_west(&[1.0, 4.0], &[3.0, 1.0]);
        assert!((mean.mean - 1.75).abs() < 1e-12);
        assert_eq!(newey_west(&[1.0], &[1.0]).std_err, f64::INFINITY);
        assert_eq!(newey_west(&[], &[]).mean, 0.0);
    }
}
