//! One row of a table, wherever it comes from.

use crate::log::columns::cell::TableCell;

/// A row, with the cells of the wanted columns.
#[derive(Debug)]
pub(crate) struct Row<'r> {
    /// Number of its line, from 1, or of its row in a file without lines.
    pub number: u64,
    /// Its position in the file and its length [bytes]; 0 in a file without lines.
    pub offset: u64,
    pub bytes: u64,
    /// The cells, or the number of cells if it is not that of the header.
    pub cells: Result<&'r [TableCell<'r>], usize>,
}

/// What is done with each row; `false` ends the reading.
pub(crate) type EachRow<'f> = dyn FnMut(&Row<'_>) -> crate::log::Result<bool> + 'f;
