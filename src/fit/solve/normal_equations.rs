//! Normal equations, added up segment by segment in a fixed order, so that the sums are the same bits for any number of threads.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use std::ops::Range;

/// Columns of a symmetric product that are computed at once, from the diagonal down: narrow, so that little above the diagonal is computed
/// as well, and wide enough for the kernel (for these sizes faster by half than a triangular product).
const STRIP: usize = 24;

/// XᵀX over a gear's columns, with the speed as last column.
#[derive(Debug, Clone)]
pub(crate) struct Gram {
    /// Number of columns, the speed included.
    pub(crate) size: usize,
    /// Row by row; the product of two different columns is the sum of the two values where they meet.
    values: Vec<f64>,
}

/// The same over the columns that one segment touches.
#[derive(Debug, Clone)]
pub(crate) struct LocalGram {
    /// Global columns; `u32::MAX` is the speed.
    pub(crate) columns: Vec<u32>,
    /// The lower triangle of a symmetric matrix; the part above is not used.
    pub(crate) values: Mat<f64>,
}

impl LocalGram {
    /// Zeros over the given global columns.
    pub(crate) fn new(columns: Vec<u32>) -> Self {
        let width = columns.len();
        Self { columns, values: Mat::zeros(width, width) }
    }

    /// Adds rows of the first `width` columns, row-major; their other columns are zero.
    pub(crate) fn add(&mut self, rows: &[f64], width: usize) {
        let x = faer::MatRef::from_row_major_slice(rows, rows.len() / width, width);
        for from in (0..width).step_by(STRIP) {
            let columns = STRIP.min(width - from);
            matmul(
                self.values.submatrix_mut(from, from, width - from, columns),
                Accum::Add,
                x.subcols(from, width - from).transpose(),
                x.subcols(from, columns),
                1.0,
                Par::Seq,
            );
        }
    }
}

impl Gram {
    /// Zeros over `size` columns, the speed included.
    pub(crate) fn new(size: usize) -> Self {
        Self { size, values: vec![0.0; size * size] }
    }

    /// Adds another sum over the same columns.
    pub(crate) fn add_all(&mut self, other: &Self) {
        self.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a += b);
    }

    /// The whole matrix.
    pub(crate) fn whole(&self) -> Mat<f64> {
        let at = |a: usize, b: usize| self.values[a * self.size + b];
        Mat::from_fn(self.size, self.size, |a, b| if a == b { at(a, a) } else { at(a.max(b), a.min(b)) + at(a.min(b), a.max(b)) })
    }

    /// Adds one segment's.
    pub(crate) fn add(&mut self, local: &LocalGram) {
        let places: Vec<usize> = local.columns.iter().map(|c| if *c == u32::MAX { self.size - 1 } else { *c as usize }).collect();
        // columns that are adjacent here are added at once
        let mut runs: Vec<Range<usize>> = Vec::new();
        for (k, place) in places.iter().enumerate() {
            match runs.last_mut() {
                Some(run) if places[run.end - 1] + 1 == *place => run.end = k + 1,
                _ => runs.push(k..k + 1),
            }
        }
        for (k, place) in places.iter().enumerate() {
            let column = local.values.col_as_slice(k);
            for run in runs.iter().filter(|run| run.end > k) {
                let from = run.start.max(k);
                let to = place * self.size + places[from];
                self.values[to..to + run.end - from].iter_mut().zip(&column[from..run.end]).for_each(|(sum, value)| *sum += value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows over the columns 2, 3, 0 and the speed: not in order, and with one left out.
    const ROWS: [[f64; 4]; 3] = [[1.0, 2.0, -1.0, 0.5], [0.0, 1.0, 3.0, -2.0], [4.0, -1.0, 0.0, 1.0]];

    fn local() -> LocalGram {
        LocalGram::new(vec![2, 3, 0, u32::MAX])
    }

    #[test]
    fn the_sum_over_segments_is_the_product_of_all_rows() {
        let mut gram = Gram::new(5);
        for rows in [&ROWS[..1], &ROWS[1..]] {
            let mut segment = local();
            segment.add(&rows.concat(), 4);
            gram.add(&segment);
        }
        let dense = |row: &[f64; 4]| [row[2], 0.0, row[0], row[1], row[3]];
        let whole = gram.whole();
        for a in 0..5 {
            for b in 0..5 {
                let expected: f64 = ROWS.iter().map(dense).map(|x| x[a] * x[b]).sum();
                assert!((whole[(a, b)] - expected).abs() < 1e-12, "{a} {b}");
            }
        }
    }

    #[test]
    fn rows_may_end_before_the_last_columns() {
        let (mut short, mut long) = (local(), local());
        short.add(&[1.0, 2.0, 3.0, -1.0], 2);
        long.add(&[1.0, 2.0, 0.0, 0.0, 3.0, -1.0, 0.0, 0.0], 4);
        let whole = |segment: &LocalGram| {
            let mut gram = Gram::new(5);
            gram.add(segment);
            gram.whole()
        };
        assert_eq!(whole(&short), whole(&long));
    }

    #[test]
    fn sums_add_up() {
        let mut segment = local();
        segment.add(&ROWS.concat(), 4);
        let mut gram = Gram::new(5);
        gram.add(&segment);
        let once = gram.clone();
        gram.add_all(&once);
        assert_eq!(gram.whole(), once.whole() * faer::Scale(2.0));
    }
}
