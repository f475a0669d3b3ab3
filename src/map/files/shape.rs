//! Checks that an array has the size of its axes, and only finite numbers.

use crate::map::{Error, Result};

/// The place of an array, for an error: the map and the field.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ArrayField<'a> {
    /// The map, as `maps[0]`.
    pub(crate) map: &'a str,
    /// The field within it.
    pub(crate) name: &'static str,
}

impl ArrayField<'_> {
    /// Checks that a matrix has `rows` rows of `columns` cells.
    pub(crate) fn expect_cells<T>(self, rows: usize, columns: usize, cells: &[Vec<T>]) -> Result<()> {
        self.expect_len("", rows, cells.len())?;
        cells.iter().enumerate().try_for_each(|(i, row)| self.expect_len(&format!("[{i}]"), columns, row.len()))
    }

    /// The same for numbers, which must be finite.
    pub(crate) fn expect_numbers(self, rows: usize, columns: usize, cells: &[Vec<f64>]) -> Result<()> {
        self.expect_cells(rows, columns, cells)?;
        for (i, row) in cells.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                self.expect_finite(&format!("[{i}][{j}]"), *value)?;
            }
        }
        Ok(())
    }

    /// Checks the length of an array; `at` is its place within the field.
    pub(crate) fn expect_len(self, at: &str, expected: usize, found: usize) -> Result<()> {
        if found == expected { Ok(()) } else { Err(Error::WrongLength { place: self.place(at), expected, found }) }
    }

    /// Checks a number; `at` is its place within the field.
    pub(crate) fn expect_finite(self, at: &str, value: f64) -> Result<()> {
        if value.is_finite() { Ok(()) } else { Err(Error::NoNumber { place: self.place(at), value }) }
    }

    fn place(self, at: &str) -> String {
        format!("{}.{}{at}", self.map, self.name)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const STD_ERR: ArrayField = ArrayField { map: "maps[1]", name: "std_err_mps2" };

    #[test]
    fn a_short_row_is_named_with_its_place() {
        assert_eq!(
            STD_ERR.expect_cells(2, 3, &[vec![1, 2, 3], vec![4, 5]]).unwrap_err().to_string(),
            "maps[1].std_err_mps2[1] has 2 entries; its axis needs 3"
        );
        let short = STD_ERR.expect_cells(3, 3, &[vec![1, 2, 3], vec![4, 5, 6]]).unwrap_err();
        assert_eq!(short.to_string(), "maps[1].std_err_mps2 has 2 entries; its axis needs 3");
    }

    #[test]
    fn rows_of_other_lengths_are_refused_even_if_their_total_is_right() {
        assert!(STD_ERR.expect_cells(2, 3, &[vec![1, 2, 3, 4], vec![5, 6]]).is_err());
    }

    #[test]
    fn a_cell_that_is_no_number_is_named_with_its_place() {
        let error = STD_ERR.expect_numbers(2, 1, &[vec![1.0], vec![f64::INFINITY]]).unwrap_err();
        assert_eq!(error.to_string(), "maps[1].std_err_mps2[1][0] is inf; it must be a finite number");
    }
}
