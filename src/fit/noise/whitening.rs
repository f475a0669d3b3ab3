//! Whitening: the innovations of the filter divided by √S.
//!
//! The filter is linear and its gains do not depend on the data. So running the speed and every regressor through the same gains turns
//! generalised least squares into ordinary least squares (Ljung, *System Identification*, prediction error methods).

use crate::fit::noise::kalman::{Gains, Recursion};
use crate::fit::noise::model::{Noise, Reading};
use faer::traits::pulp::{Arch, Simd, WithSimd};

/// What whitening needs of one reading.
#[derive(Debug, Clone, Copy)]
struct WhiteningStep {
    gains: Gains,
    /// 1/√S.
    inverse_root: f64,
}

/// The filter over one stretch: its gains do not depend on the data.
#[derive(Debug, Clone)]
pub(crate) struct Filter {
    steps: Vec<WhiteningStep>,
}

impl Filter {
    /// Over readings, from `start_s` on.
    pub(crate) fn over(readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) -> Self {
        let mut recursion = Recursion::new(start_s, noise, start_std_mps);
        let step = |reading| {
            let gains = recursion.next(reading);
            WhiteningStep { inverse_root: gains.over_s.sqrt(), gains }
        };
        let steps = readings.iter().map(step).collect();
        Self { steps }
    }

    /// Replaces each column of `matrix` (row-major, one row per measurement, `columns` wide) by its whitened innovations.
    pub(crate) fn whiten(&self, matrix: &mut [f64], columns: usize) {
        self.whiten_from(0, matrix, columns, &mut States::new(columns));
    }

    /// The same for the rows from measurement `from` on, `states` being what the rows before have left: zero for a column that was zero there.
    pub(crate) fn whiten_from(&self, from: usize, matrix: &mut [f64], columns: usize, states: &mut States) {
        Arch::new().dispatch(Rows { steps: &self.steps[from..], matrix, columns, states });
    }

    /// The transpose of whitening one column, applied to `white`: its inner product with any column is that of `white` with the whitened column.
    pub(crate) fn whiten_transposed(&self, white: &[f64]) -> Vec<f64> {
        let mut transposed = vec![0.0; white.len()];
        let (mut v, mut d, mut b) = (0.0, 0.0, 0.0);
        for ((step, white), out) in self.steps.iter().zip(white).zip(&mut transposed).rev() {
            let Gains { drift, dt, decay, gain: [kv, kd, kb], .. } = step.gains;
            *out = step.inverse_root * white + kv * v + kd * d + kb * b;
            v -= *out;
            d = drift * v + decay * d;
            b += dt * v;
        }
        transposed
    }
}

/// The filter's states between two rows, for each column.
pub(crate) struct States {
    v: Vec<f64>,
    d: Vec<f64>,
    b: Vec<f64>,
}

impl States {
    /// Zeros for at most so many columns.
    pub(crate) fn new(columns: usize) -> Self {
        Self { v: vec![0.0; columns], d: vec![0.0; columns], b: vec![0.0; columns] }
    }
}

/// The loop over rows and columns, compiled for the vectors of the machine. Columns do not mix, so their width does not change a bit.
struct Rows<'a> {
    steps: &'a [WhiteningStep],
    matrix: &'a mut [f64],
    columns: usize,
    states: &'a mut States,
}

impl WithSimd for Rows<'_> {
    type Output = ();

    #[allow(clippy::inline_always)] // only what is inlined is compiled for those vectors
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let States { v, d, b } = self.states;
        for (step, row) in self.steps.iter().zip(self.matrix.chunks_exact_mut(self.columns)) {
            let Gains { drift, dt, decay, gain: [kv, kd, kb], .. } = step.gains;
            for (((z, v), d), b) in row.iter_mut().zip(&mut *v).zip(&mut *d).zip(&mut *b) {
                let ahead = *v + drift * *d + dt * *b;
                let faded = decay * *d;
                let innovation = *z - ahead;
                *v = ahead + kv * innovation;
                *d = faded + kd * innovation;
                *b += kb * innovation;
                *z = innovation * step.inverse_root;
            }
        }
    }
}

/// [`Filter::whiten`] over readings.
pub(crate) fn whiten(matrix: &mut [f64], columns: usize, readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) {
    Filter::over(readings, start_s, noise, start_std_mps).whiten(matrix, columns);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::noise::kalman::filter;
    use crate::fit::noise::simulated::{NOISE, simulated};

    #[test]
    fn innovations_of_the_true_model_are_white_with_unit_variance() {
        let (readings, mut values) = simulated(6000, 3);
        whiten(&mut values, 1, &readings, 0.0, &NOISE, 3e-3);
        let n = values.len() as f64;
        let variance = values.iter().map(|e| e * e).sum::<f64>() / n;
        let lag_one = values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
        // standard errors are √(2/n) = 0.018 and 1/√n = 0.013: four of each
        assert!((variance - 1.0).abs() < 0.073, "{variance}");
        assert!(lag_one.abs() < 0.052, "{lag_one}");
    }

    #[test]
    fn whitening_in_parts_and_transposed_is_the_same_map() {
        let (readings, values) = simulated(200, 13);
        let filter = Filter::over(&readings, 0.0, &NOISE, 3e-3);
        let mut whole: Vec<f64> = values.iter().flat_map(|v| [*v, v * v]).collect();
        let mut parts = whole.clone();
        filter.whiten(&mut whole, 2);
        let mut states = States::new(2);
        let (first, second) = parts.split_at_mut(2 * 70);
        filter.whiten_from(0, first, 2, &mut states);
        filter.whiten_from(70, second, 2, &mut states);
        assert_eq!(whole, parts);
        let transposed = filter.whiten_transposed(&values);
        let one: f64 = values.iter().zip(whole.chunks_exact(2)).map(|(v, row)| v * row[1]).sum();
        let other: f64 = transposed.iter().zip(&values).map(|(t, v)| t * v * v).sum();
        assert!((one - other).abs() < 1e-9 * one.abs(), "{one} {other}");
    }

    #[test]
    fn whitening_gives_the_innovations_of_the_filter() {
        let (readings, values) = simulated(500, 11);
        let filtered = filter(&values, &readings, 0.0, &NOISE, 3e-3);
        let mut columns = values;
        whiten(&mut columns, 1, &readings, 0.0, &NOISE, 3e-3);
        assert!(columns.iter().zip(&filtered.white).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}
