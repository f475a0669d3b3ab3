//! The signals of a table in long form: one pass over all rows finds their names, units and kinds.

use crate::log::columns::gather::name_of;
use crate::log::columns::head::Head;
use crate::log::columns::layout::{LongColumns, look};
use crate::log::columns::table::SignalTable;
use crate::log::limits::MOST_DESCRIPTION;
use crate::log::{Error, Result};
use std::collections::HashMap;

/// The signals, in the order of their first rows.
///
/// # Errors
/// The file cannot be read, or the names take more memory than those of any vehicle.
pub(crate) fn series(table: &SignalTable, long: LongColumns) -> Result<Vec<Head>> {
    let mut heads: Vec<(Head, bool)> = Vec::new();
    let mut by_name: HashMap<String, usize> = HashMap::new();
    let mut size = 0;
    let wanted: Vec<usize> = [long.name, long.value].into_iter().chain(long.unit).collect();
    table.rows(&wanted, &|_| {}, &mut |row| {
        let Ok(cells) = row.cells else { return Ok(true) };
        let name = name_of(&cells[0]);
        let place = if let Some(place) = by_name.get(name.as_ref()) {
            *place
        } else {
            size += 2 * name.len() as u64 + 200;
            if size > MOST_DESCRIPTION {
                return Err(Error::TooMuchDescription { allowed: MOST_DESCRIPTION });
            }
            let unit = cells.get(2).map(crate::log::columns::cell::TableCell::shown);
            heads.push((Head::new(&name, unit.as_deref()), true));
            by_name.insert(name.into_owned(), heads.len() - 1);
            heads.len() - 1
        };
        let (head, whole) = &mut heads[place];
        if !cells[1].is_hole() {
            look(head, whole, &cells[1]);
        }
        Ok(true)
    })?;
    Ok(heads.into_iter().map(|(head, _)| head).collect())
}
