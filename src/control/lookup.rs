//! Two-dimensional linear interpolation in a table, as a controller does it: no allocation, no panic, no transcendental function.
//!
//! Between breaks x₀ ≤ x ≤ x₁ and y₀ ≤ y ≤ y₁ with p = (x − x₀)/(x₁ − x₀), q = (y − y₀)/(y₁ − y₀):
//! z = (1−p)·((1−q)·z₀₀ + q·z₀₁) + p·((1−q)·z₁₀ + q·z₁₁).
//!
//! This file uses `core` only and can be carried to a microcontroller as it is.

/// Value at (`row`, `col`), or `None` where either lies outside its breaks or is not a number.
///
/// `values` is row-major: `row_breaks.len()` × `col_breaks.len()`. Slices that do not fit together give `None`.
pub fn bilinear(row_breaks: &[f64], col_breaks: &[f64], values: &[f64], row: f64, col: f64) -> Option<f64> {
    let (first_row, last_row) = (*row_breaks.first()?, *row_breaks.last()?);
    let (first_col, last_col) = (*col_breaks.first()?, *col_breaks.last()?);
    let inside = row >= first_row && row <= last_row && col >= first_col && col <= last_col;
    if inside { bilinear_clamped(row_breaks, col_breaks, values, row, col) } else { None }
}

/// Value at (`row`, `col`), each first clamped to its breaks; infinities clamp to an edge. `None` only when either is NaN or the slices
/// do not fit together.
pub fn bilinear_clamped(row_breaks: &[f64], col_breaks: &[f64], values: &[f64], row: f64, col: f64) -> Option<f64> {
    if values.len() != row_breaks.len().checked_mul(col_breaks.len())? {
        return None;
    }
    let (i, p) = bracket(row_breaks, row)?;
    let (j, q) = bracket(col_breaks, col)?;
    let columns = col_breaks.len();
    let near = i * columns + j;
    let far = near + columns;
    let low = (1.0 - q) * values.get(near)? + q * values.get(near + 1)?;
    let high = (1.0 - q) * values.get(far)? + q * values.get(far + 1)?;
    Some((1.0 - p) * low + p * high)
}

/// Interval of `breaks` that holds `x` (clamped), and the fraction of the way through it, 0 to 1. `None` for NaN or fewer than two breaks.
pub fn bracket(breaks: &[f64], x: f64) -> Option<(usize, f64)> {
    let last = breaks.len().checked_sub(1)?;
    if last == 0 || x.is_nan() {
        return None;
    }
    // The number of breaks at or below x, by bisection.
    let (mut low, mut high) = (0, breaks.len());
    while low < high {
        let middle = low + (high - low) / 2;
        if *breaks.get(middle)? <= x {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    let i = low.saturating_sub(1).min(last - 1);
    let (lower, upper) = (*breaks.get(i)?, *breaks.get(i + 1)?);
    let fraction = if x <= lower {
        0.0
    } else if x >= upper {
        1.0
    } else {
        (x - lower) / (upper - lower)
    };
    Some((i, fraction))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    const ROWS: [f64; 3] = [0.0, 1.0, 3.0];
    const COLS: [f64; 2] = [-1.0, 1.0];
    const VALUES: [f64; 6] = [0.0, 2.0, 1.0, 3.0, 5.0, 7.0];

    #[test]
    fn nodes_are_met_exactly_and_the_plane_between_them_is_linear() {
        assert_eq!(bilinear(&ROWS, &COLS, &VALUES, 3.0, 1.0), Some(7.0));
        assert_eq!(bilinear(&ROWS, &COLS, &VALUES, 0.0, -1.0), Some(0.0));
        assert_eq!(bilinear(&ROWS, &COLS, &VALUES, 2.0, 0.0), Some(4.0));
    }

    #[test]
    fn outside_is_none_or_the_edge_as_the_name_says() {
        assert_eq!(bilinear(&ROWS, &COLS, &VALUES, 3.1, 0.0), None);
        assert_eq!(bilinear_clamped(&ROWS, &COLS, &VALUES, f64::INFINITY, 9.0), Some(7.0));
        assert_eq!(bilinear_clamped(&ROWS, &COLS, &VALUES, f64::NAN, 0.0), None);
    }

    proptest! {
        #[test]
        fn no_input_panics_and_a_clamped_value_stays_within_the_table(row in any::<f64>(), col in any::<f64>()) {
            if let Some(z) = bilinear_clamped(&ROWS, &COLS, &VALUES, row, col) {
                prop_assert!((-1e-12..=7.0 + 1e-12).contains(&z));
            } else {
                prop_assert!(row.is_nan() || col.is_nan());
            }
            let _ = bilinear(&ROWS, &[], &[], row, col);
            let _ = bilinear(&ROWS, &COLS, &VALUES[..5], row, col);
        }
    }
}
