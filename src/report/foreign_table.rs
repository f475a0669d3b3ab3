//! The page of a Table 2 that came back from a controller or a tool.

use crate::import::ImportedMap;
use crate::invert::described_tables;
use crate::map::ZeroRow;
use crate::report::{Error, ReportFiles, Result};
use std::path::Path;

impl ReportFiles {
    /// The same files with the tables of `imported`, read from `path`, as Table 2. The verdict and what was driven for it belong to the folder's
    /// own Table 2 and are left out.
    ///
    /// # Errors
    /// No `table2.json`, or a table that Table 1 cannot describe.
    pub(crate) fn with_table(mut self, path: &Path, imported: &ImportedMap) -> Result<Self> {
        let Some(table2) = &mut self.table2 else { return Err(Error::NoTable2) };
        let tables = imported.tables.iter().map(|table| Ok((table.gear, table.table()?))).collect::<Result<Vec<_>>>()?;
        let zero_row = table2.maps.first().map_or(ZeroRow::default(), |map| map.zero_row);
        let wrong = |source| Error::Described { path: path.to_owned(), source };
        table2.maps = described_tables(&self.table1, &tables, zero_row).map_err(wrong)?;
        let name = path.file_name().map(crate::text::shown).unwrap_or_default();
        self.files.push((name.clone(), imported.sha256.clone()));
        self.notes.retain(|note| !note.contains("verify.json"));
        self.notes.push(format!(
            "Table 2 is that of {name} ({}), not the folder's, and is not judged: `pivot-cal diff --edited` lists what was changed in it, `pivot-cal \
             verify --table` judges it",
            imported.format
        ));
        (self.verdict, self.closed_loop, self.manoeuvres, self.verdict_is_current) = (None, None, None, false);
        Ok(self)
    }
}
