//! Finds the significant p values among many.

use libm::erfc;

/// Two-sided p of a standard normal z.
pub(crate) fn two_sided_p(z: f64) -> f64 {
    erfc(z.abs() / std::f64::consts::SQRT_2)
}

/// The largest p that is significant at the false discovery rate `rate`: the largest p₍ₖ₎ ≤ rate·k/n, the p ascending. `None` when none is.
///
/// Source: Benjamini and Hochberg (1995), see the room's documentation.
pub(crate) fn threshold(p_values: &[f64], rate: f64) -> Option<f64> {
    let mut sorted = p_values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    sorted.iter().enumerate().rev().find(|(k, p)| **p <= rate * (*k as f64 + 1.0) / n).map(|(_, p)| *p)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn the_procedure_finds_what_its_authors_found() {
        // the fifteen p values of the 1995 paper's example: four are significant at 0.05
        let p = [0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.0000];
        assert_eq!(threshold(&p, 0.05), Some(0.0095));
    }

    #[test]
    fn p_of_z_is_the_tabulated_one() {
        assert!((two_sided_p(-1.959_963_985) - 0.05).abs() < 1e-9);
        assert!((two_sided_p(0.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn of_a_thousand_comparisons_of_equal_maps_about_fifty_find_something() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(6);
        let found = (0..1000).filter(|_| {
            let p: Vec<f64> = (0..500).map(|_| two_sided_p(StandardNormal.sample(&mut random))).collect();
            threshold(&p, 0.05).is_some()
        });
        // Simes' test is exact for independent cells: 50 of 1000 with a standard deviation of 6.9; four of them either way
        let found = found.count();
        assert!((22..=78).contains(&found), "{found}");
    }
}
