//! Weighted isotonic regression: the ascending series closest to the values in the least-squares sense.
//!
//! Pool adjacent violators. Source: Barlow, Bartholomew, Bremner & Brunk (1972), *Statistical Inference under Order Restrictions*, §1.2.

/// The fitted values, as many as `values`; weights positive.
pub(crate) fn isotonic(values: &[f64], weights: &[f64]) -> Vec<f64> {
    // (mean, weight, count)
    let mut blocks: Vec<(f64, f64, usize)> = Vec::new();
    for (&value, &weight) in values.iter().zip(weights) {
        blocks.push((value, weight, 1));
        while let [.., (low, w0, n0), (high, w1, n1)] = blocks[..] {
            if low <= high {
                break;
            }
            blocks.pop();
            if let Some(last) = blocks.last_mut() {
                *last = ((low * w0 + high * w1) / (w0 + w1), w0 + w1, n0 + n1);
            }
        }
    }
    blocks.into_iter().flat_map(|(mean, _, n)| std::iter::repeat_n(mean, n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn violators_are_pooled_by_weight_and_the_others_are_unchanged() {
        assert_eq!(isotonic(&[1.0, 3.0, 2.0, 4.0], &[1.0, 1.0, 1.0, 1.0]), [1.0, 2.5, 2.5, 4.0]);
        assert_eq!(isotonic(&[3.0, 0.0], &[1.0, 2.0]), [1.0, 1.0]);
        assert_eq!(isotonic(&[4.0, 3.0, 2.0, 1.0], &[1.0; 4]), [2.5; 4]);
        assert!(isotonic(&[], &[]).is_empty());
    }
}
