//! Normal equations, added up segment by segment in a fixed order, so that the sums are the same bits for any number of threads.

use faer::Mat;
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Par};

/// XᵀX over a gear's columns, with the speed as last column.
#[derive(Debug, Clone)]
pub(crate) struct Gram {
    /// Number of columns, the speed included.
    pub(crate) size: usize,
    /// The lower triangle of a symmetric matrix, row-major; above it zeros.
    pub(crate) values: Vec<f64>,
}

/// The same over the columns that one segment touches.
#[derive(Debug, Clone)]
pub(crate) struct LocalGram {
    /// Global columns; `u32::MAX` is the speed.
    pub(crate) columns: Vec<u32>,
    /// The lower triangle of a symmetric matrix; above it zeros.
    pub(crate) values: Mat<f64>,
}

impl LocalGram {
    /// From whitened rows.
    pub(crate) fn new(columns: Vec<u32>, white: &[f64]) -> Self {
        let width = columns.len();
        let rows = white.len() / width;
        let x = faer::MatRef::from_row_major_slice(white, rows, width);
        let mut values = Mat::zeros(width, width);
        matmul(
            values.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Replace,
            x.transpose(),
            BlockStructure::Rectangular,
            x,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        Self { columns, values }
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

    /// The whole matrix, row by row.
    pub(crate) fn whole(&self) -> Mat<f64> {
        Mat::from_fn(self.size, self.size, |a, b| self.values[a.max(b) * self.size + a.min(b)])
    }

    /// Adds one segment's.
    pub(crate) fn add(&mut self, local: &LocalGram) {
        let global = |c: u32| if c == u32::MAX { self.size - 1 } else { c as usize };
        let places: Vec<usize> = local.columns.iter().map(|c| global(*c)).collect();
        for (k, column) in local.values.col_iter().enumerate() {
            for (l, value) in column.iter().enumerate().skip(k) {
                let (a, b) = (places[k].max(places[l]), places[k].min(places[l]));
                self.values[a * self.size + b] += value;
            }
        }
    }
}
