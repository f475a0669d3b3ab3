//! One pass over the rows of a table: values, times, and what could not be used.

use crate::log::columns::cell::TableCell;
use crate::log::columns::choose::ColumnChoices;
use crate::log::columns::head::Head;
use crate::log::columns::layout::TableForm;
use crate::log::columns::row::Row;
use crate::log::columns::table::SignalTable;
use crate::log::columns::time::TimeForm;
use crate::log::extract::column::Column;
use crate::log::extract::convert::Convert;
use crate::log::limits::MOST_VALUES;
use crate::log::loss::{Damage, Loss, Why};
use crate::log::timing::log_clock::{ClockStep, LEAST_STEP_NS};
use crate::log::timing::message_times::MessageTimes;
use crate::log::value::Raw;
use crate::log::{Error, Result};
use crate::map::Vehicle;
use std::collections::{BTreeMap, HashMap};

/// Damaged places that are listed; the others are only counted.
const MOST_PLACES: usize = 100;
/// Places where the time goes back that are kept: more are not caused by a clock.
const MOST_STEPS: usize = 100;

/// What a pass has found.
#[derive(Debug, Default)]
pub(crate) struct GatheredRows {
    /// One per choice.
    pub columns: Vec<Column>,
    /// Number of values of each head.
    pub counts: Vec<u64>,
    pub loss: Loss,
    /// The first and the latest time, and where it goes back.
    pub span_ns: Option<(i64, i64)>,
    pub clock_steps: Vec<ClockStep>,
    pub notes: Vec<String>,
    /// Checksum of the bytes that were read, if all of them were.
    pub crc: Option<u32>,
}

/// Reads the chosen columns of every row.
///
/// # Errors
/// The file cannot be read, or holds more values than are kept.
pub(crate) fn gather(
    (table, layout, heads): (&SignalTable, &TableForm, &[Head]),
    chosen: &ColumnChoices,
    vehicle: &Vehicle,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<GatheredRows> {
    let converts = chosen.choices.found.iter().map(|choice| Convert::new(choice.signal, &choice.spec, &[], vehicle)).collect();
    let mut pass = RowPass::new((table, layout, heads), chosen, converts);
    let read = match layout.long {
        None => {
            let wanted: Vec<usize> = std::iter::once(layout.time).chain(chosen.columns.iter().copied()).collect();
            table.rows(&wanted, progress, &mut |row| pass.wide(row))?
        }
        Some(long) => table.rows(&[layout.time, long.name, long.value], progress, &mut |row| pass.long(row))?,
    };
    Ok(pass.finish(read.damage, read.crc))
}

struct RowPass<'p> {
    heads: &'p [Head],
    form: TimeForm,
    row_name: &'static str,
    chosen: &'p ColumnChoices,
    converts: Vec<Convert>,
    /// In long form, the heads by their names.
    by_name: HashMap<&'p str, usize>,
    /// In long form, the latest time of each head.
    latest_ns: Vec<Option<i64>>,
    /// The rows of one signal follow those of another: their times say nothing about a clock.
    is_grouped: bool,
    columns_of_table: usize,
    /// Rows with a time, and rows that were lost.
    rows: u64,
    lost: u64,
    values: u64,
    /// For each choice, cells that are not numbers, with the first of them.
    misread: Vec<(u64, String)>,
    found: GatheredRows,
}

impl<'p> RowPass<'p> {
    fn new((table, layout, heads): (&'p SignalTable, &TableForm, &'p [Head]), chosen: &'p ColumnChoices, converts: Vec<Convert>) -> Self {
        Self {
            heads,
            form: layout.form,
            row_name: table.row_name(),
            chosen,
            by_name: heads.iter().enumerate().map(|(k, head)| (head.name.as_str(), k)).collect(),
            latest_ns: vec![None; heads.len()],
            is_grouped: false,
            columns_of_table: table.heads().len(),
            rows: 0,
            lost: 0,
            values: 0,
            misread: vec![(0, String::new()); converts.len()],
            found: GatheredRows {
                columns: vec![Column::default(); converts.len()],
                counts: vec![0; heads.len()],
                ..GatheredRows::default()
            },
            converts,
        }
    }

    fn wide(&mut self, row: &Row<'_>) -> Result<bool> {
        let Some((time_ns, cells)) = self.timed(row) else { return Ok(true) };
        self.log_time(time_ns);
        for choice in 0..self.converts.len() {
            self.value(choice, time_ns, &cells[1 + choice], row)?;
        }
        Ok(true)
    }

    fn long(&mut self, row: &Row<'_>) -> Result<bool> {
        let Some((time_ns, cells)) = self.timed(row) else { return Ok(true) };
        let head = self.by_name.get(name_of(&cells[1]).as_ref()).copied();
        if let Some(head) = head {
            // a signal that begins earlier than another ended is not a clock that was set back
            if self.latest_ns[head].is_none()
                && self.found.span_ns.is_some_and(|(_, latest)| time_ns < latest.saturating_sub(LEAST_STEP_NS))
            {
                self.is_grouped = true;
            }
            self.latest_ns[head] = Some(time_ns);
        }
        self.log_time(time_ns);
        for choice in 0..self.converts.len() {
            if Some(self.chosen.columns[choice]) == head {
                self.value(choice, time_ns, &cells[2], row)?;
            }
        }
        Ok(true)
    }

    /// The time and the cells of a row, which is counted as lost if it has none.
    fn timed<'r>(&mut self, row: &Row<'r>) -> Option<(i64, &'r [TableCell<'r>])> {
        let why = match row.cells {
            Ok(cells) => {
                if let Some(time_ns) = self.form.time_ns(&cells[0]) {
                    self.rows += 1;
                    return Some((time_ns, cells));
                }
                Why::BadTime { place: format!("{} {}", self.row_name, row.number).into(), found: cells[0].shown().into() }
            }
            Err(found) => Why::RaggedRow { line: row.number, found, expected: self.columns_of_table },
        };
        self.lost += 1;
        self.found.loss.bytes_lost += row.bytes;
        if self.found.loss.places.len() < MOST_PLACES {
            self.found.loss.places.push(Damage { messages: Some(1), ..Damage::new(row.offset, row.bytes, why) });
        }
        None
    }

    fn value(&mut self, choice: usize, time_ns: i64, cell: &TableCell<'_>, row: &Row<'_>) -> Result<()> {
        if cell.is_hole() {
            return Ok(());
        }
        self.found.counts[self.chosen.columns[choice]] += 1;
        let raw = match (cell, cell.number()) {
            (_, Some(number)) => Raw::Number(number),
            (TableCell::Text(text), None) => Raw::Text(text.as_ref().into()),
            _ => Raw::Missing,
        };
        let Some(value) = self.converts[choice].apply(&raw) else {
            let (count, first) = &mut self.misread[choice];
            if *count == 0 {
                *first = format!("{:?} in {} {}", cell.shown(), self.row_name, row.number);
            }
            *count += 1;
            return Ok(());
        };
        let column = &mut self.found.columns[choice];
        if !value.is_finite() {
            column.not_finite += 1;
            return Ok(());
        }
        self.values += 1;
        if self.values > MOST_VALUES {
            return Err(Error::TooManyValues { allowed: MOST_VALUES });
        }
        column.push(MessageTimes { log_ns: time_ns, ..MessageTimes::default() }, value);
        Ok(())
    }

    /// Notes the time of the next row.
    fn log_time(&mut self, time_ns: i64) {
        let (first, latest) = self.found.span_ns.unwrap_or((time_ns, time_ns));
        if time_ns < latest.saturating_sub(LEAST_STEP_NS) {
            if self.found.clock_steps.len() < MOST_STEPS {
                let values = self.found.columns.iter().map(|column| column.value.len()).collect();
                self.found.clock_steps.push(ClockStep { before_ns: latest, after_ns: time_ns, values });
            }
            self.found.span_ns = Some((first, time_ns));
        } else {
            self.found.span_ns = Some((first, latest.max(time_ns)));
        }
    }

    fn finish(mut self, damage: Vec<Damage>, crc: Option<u32>) -> GatheredRows {
        let found = &mut self.found;
        if self.is_grouped {
            found.clock_steps.clear();
        }
        self.lost += damage.iter().filter_map(|damage| damage.messages).sum::<u64>();
        found.loss.bytes_lost += damage.iter().map(|damage| damage.bytes).sum::<u64>();
        found.loss.places.extend(damage);
        found.loss.messages_read = self.rows;
        found.loss.messages_lost = Some(self.lost);
        let mut misread: BTreeMap<String, u64> = BTreeMap::new();
        for (choice, (count, first)) in self.misread.into_iter().enumerate().filter(|(_, (count, _))| *count > 0) {
            let name = &self.heads[self.chosen.columns[choice]].name;
            found.notes.push(format!("column {name}: {count} cell(s) are no number, the first is {first}: left out"));
            misread.insert(name.clone(), count);
        }
        found.loss.broken_messages = misread;
        found.crc = crc;
        self.found
    }
}

/// The name of a signal in a row of the long form, as heads have it.
pub(crate) fn name_of<'c>(cell: &'c TableCell<'c>) -> std::borrow::Cow<'c, str> {
    match cell {
        TableCell::Text(text) => crate::text::name_from_outside(text.trim()),
        other => other.shown().into(),
    }
}
