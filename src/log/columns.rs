//! Logs that are tables: CSV and Parquet, with a column per signal or with a row per value.
//!
//! In: a file whose name or first bytes say that it is a table, and a [`Source`] that names columns where it names message paths of MCAP. Out:
//! the chosen columns with their values and times, for the reader and the survey of logs. A table has one time per row, taken as the time of the
//! log. An empty cell means that the signal has no new value.

pub(crate) mod cell;
pub(crate) mod choose;
pub(crate) mod csv;
pub(crate) mod foreign_panics;
pub(crate) mod gather;
pub(crate) mod head;
pub(crate) mod layout;
pub(crate) mod lines;
pub(crate) mod parquet_table;
pub(crate) mod row;
pub(crate) mod series;
pub(crate) mod table;
pub(crate) mod time;

use crate::log::columns::choose::{ColumnChoices, choose, nearest};
use crate::log::columns::gather::{GatheredRows, gather};
use crate::log::columns::head::Head;
use crate::log::columns::layout::TableForm;
use crate::log::columns::table::{SignalTable, TableFormat};
use crate::log::file::input::LogInput;
use crate::log::find::resolve::expect_full_scale;
use crate::log::signal_map::{SignalMap, SignalName, VehicleOverrides};
use crate::log::{Error, Result, Source};
use crate::map::Vehicle;
use std::sync::Arc;

/// A table whose header is read and whose form is known.
pub(crate) struct OpenTable {
    pub table: SignalTable,
    pub layout: TableForm,
    /// The columns; of a table in long form, its signals.
    pub heads: Vec<Head>,
    pub notes: Vec<String>,
}

impl OpenTable {
    /// Finds the form of a table.
    ///
    /// # Errors
    /// It has no header, or no column of times.
    pub(crate) fn open(format: TableFormat, input: &Arc<LogInput>, source: &Source) -> Result<Self> {
        if input.length() == 0 {
            return Err(Error::Empty);
        }
        let table = SignalTable::open(format, input)?;
        let mut heads = table.heads().to_vec();
        let given = map_of(source).map(|map| map.columns.clone()).unwrap_or_default();
        let layout = TableForm::of(&table, &mut heads, &given)?;
        let notes = layout.note(&heads).into_iter().collect();
        if let Some(long) = layout.long {
            heads = series::series(&table, long)?;
        } else {
            // nobody's signal
            heads[layout.time].sample = None;
        }
        Ok(Self { table, layout, heads, notes })
    }

    /// Format and form in one line.
    pub(crate) fn text(&self) -> String {
        let columns = self.table.heads().len();
        let time = &self.table.heads()[self.layout.time].name;
        let form = match self.layout.long {
            None => format!("{columns} columns"),
            Some(_) => format!("long form, {} signals", self.heads.len()),
        };
        format!("{}, {form}, times in {time} [{}]", self.table.text(), self.layout.form.name())
    }

    /// Chooses a column for each signal.
    ///
    /// # Errors
    /// As [`choose`].
    pub(crate) fn choose(&self, source: &Source, wanted: &[SignalName]) -> Result<ColumnChoices> {
        choose(source, wanted, &self.heads)
    }

    /// The columns that are nearest to a signal.
    pub(crate) fn nearest(&self, signal: SignalName) -> Vec<String> {
        nearest(signal, &self.heads)
    }

    /// Reads the chosen columns.
    ///
    /// # Errors
    /// The table cannot be read, holds too many values, or no row.
    pub(crate) fn gather(&self, chosen: &ColumnChoices, vehicle: &Vehicle, progress: &(dyn Fn(u64) + Sync)) -> Result<GatheredRows> {
        let found = gather((&self.table, &self.layout, &self.heads), chosen, vehicle, progress)?;
        if found.loss.messages_read == 0 {
            return Err(Error::NoMessages { damage: found.loss.summary() });
        }
        Ok(found)
    }
}

/// What was read of a table.
pub(crate) struct TablePass {
    pub chosen: ColumnChoices,
    pub gathered: GatheredRows,
    pub vehicle: Vehicle,
    pub notes: Vec<String>,
}

/// Reads the signals `wanted` of a table.
///
/// # Errors
/// It is no table of signals, a required signal is missing, or the vehicle is not known.
pub(crate) fn read(
    format: TableFormat,
    input: &Arc<LogInput>,
    wanted: &[SignalName],
    source: &Source,
    overrides: &VehicleOverrides,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<TablePass> {
    let open = OpenTable::open(format, input, source)?;
    let chosen = open.choose(source, wanted)?;
    if let Some(signal) = chosen.choices.missing.iter().find(|signal| signal.is_required()) {
        let topics = layout::names(&open.heads);
        return Err(Error::MissingSignal { signal: signal.key(), candidates: open.nearest(*signal), topics });
    }
    let vehicle = overrides.or(map_of(source).map(|map| map.vehicle).unwrap_or_default()).vehicle()?;
    expect_full_scale(&chosen.choices, &vehicle)?;
    let gathered = open.gather(&chosen, &vehicle, progress)?;
    Ok(TablePass { chosen, gathered, vehicle, notes: open.notes })
}

fn map_of(source: &Source) -> Option<&SignalMap> {
    match source {
        Source::Map(map) => Some(map),
        Source::Preset(_) | Source::Detect => None,
    }
}
