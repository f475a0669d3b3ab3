//! The form of a table: which column holds the times, in which unit, and whether a row holds one value of many signals or of one.

use crate::log::columns::cell::TableCell;
use crate::log::columns::head::{Head, HeadUnit};
use crate::log::columns::table::SignalTable;
use crate::log::columns::time::TimeForm;
use crate::log::schema::LeafKind;
use crate::log::table_columns::{TableColumns, ns_per_unit};
use crate::log::{Error, Result};
use crate::units::Unit;

/// Rows that are looked at before the signals are chosen.
const LOOKED_AT: u64 = 1000;

/// Names of a time column, without a unit, written together.
const TIMES: [&str; 26] = [
    "time",
    "times",
    "t",
    "timestamp",
    "timestamps",
    "stamp",
    "logtime",
    "rectime",
    "recordtime",
    "elapsed",
    "elapsedtime",
    "reltime",
    "relativetime",
    "abstime",
    "absolutetime",
    "systime",
    "unixtime",
    "epoch",
    "utc",
    "utctime",
    "datetime",
    "date",
    "rostime",
    "rosbagtimestamp",
    "zeit",
    "zeitstempel",
];
/// Names of the column of the signals' names in long form, and of that of their values and units.
const NAMES: [&str; 12] =
    ["signal", "signalname", "name", "channel", "channelname", "topic", "series", "variable", "path", "key", "parameter", "measurement"];
const VALUES: [&str; 5] = ["value", "val", "reading", "physvalue", "wert"];
const UNITS: [&str; 3] = ["unit", "units", "einheit"];

/// The form of a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TableForm {
    /// The column of the times.
    pub time: usize,
    pub form: TimeForm,
    /// Whether the file or the signal map says how the times are to be read.
    pub is_form_given: bool,
    pub long: Option<LongColumns>,
}

/// The columns of a table in long form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct LongColumns {
    pub name: usize,
    pub value: usize,
    pub unit: Option<usize>,
}

impl TableForm {
    /// Finds the form of `table`; `given` is what the signal map says. Fills in what the values of `heads` look like.
    ///
    /// # Errors
    /// No column holds times, a column that the signal map names is not there, or the first time is none.
    pub(crate) fn of(table: &SignalTable, heads: &mut [Head], given: &TableColumns) -> Result<Self> {
        let mut first: Vec<Option<String>> = vec![None; heads.len()];
        let mut typed: Vec<Option<TimeForm>> = vec![None; heads.len()];
        let mut whole = vec![true; heads.len()];
        let wanted: Vec<usize> = (0..heads.len()).collect();
        let mut rows = 0;
        table.rows(&wanted, &|_| {}, &mut |row| {
            for (k, cell) in row.cells.unwrap_or_default().iter().enumerate().filter(|(_, cell)| !cell.is_hole()) {
                look(&mut heads[k], &mut whole[k], cell);
                if first[k].is_none() {
                    first[k] = Some(cell.shown());
                    typed[k] = TimeForm::of(cell);
                }
            }
            rows += 1;
            Ok(rows < LOOKED_AT)
        })?;
        if rows == 0 {
            return Err(Error::NoMessages { damage: None });
        }
        let column = |key: &'static str, name: &Option<String>| match name {
            None => Ok(None),
            Some(name) => {
                find(heads, name).map(Some).ok_or_else(|| Error::NoSuchColumn { key, column: name.clone(), columns: names(heads) })
            }
        };
        let time = match column("time", &given.time)? {
            Some(time) => time,
            None => time_column(heads, &typed).ok_or_else(|| Error::NoTimeColumn { columns: names(heads) })?,
        };
        let is_name = |k: &usize| NAMES.contains(&key(&heads[*k].bare).as_str()) && matches!(heads[*k].kind, LeafKind::Text);
        let others = |k: &usize| *k != time;
        let (name, value) = match (column("name", &given.name)?, column("value", &given.value)?) {
            (Some(name), Some(value)) => (Some(name), Some(value)),
            (None, None) => {
                let of = |known: &[&str]| (0..heads.len()).filter(others).find(|k| known.contains(&key(&heads[*k].bare).as_str()));
                ((0..heads.len()).filter(others).find(is_name), of(&VALUES))
            }
            _ => return Err(Error::HalfLong),
        };
        let unit = (0..heads.len()).find(|k| UNITS.contains(&key(&heads[*k].bare).as_str()));
        let long = name.zip(value).map(|(name, value)| LongColumns { name, value, unit });
        let named = given.time_scale()?.or_else(|| unit_of_head(&heads[time])).map(|ns_per_unit| TimeForm::Count { ns_per_unit });
        // a type or a date says what it is, whatever the header names
        let seen = typed[time].filter(|form| named.is_none() || !matches!(form, TimeForm::Count { .. }));
        let form = seen.or(named.filter(|_| typed[time].is_some()));
        let is_form_given = named.is_some() || !matches!(form, Some(TimeForm::Count { .. }));
        match (form, &first[time]) {
            (Some(form), _) => Ok(Self { time, form, is_form_given, long }),
            (None, found) => Err(Error::BadTimeColumn { column: heads[time].name.clone(), found: found.clone().unwrap_or_default() }),
        }
    }

    /// The note on a unit that nobody has given.
    pub(crate) fn note(&self, heads: &[Head]) -> Option<String> {
        (!self.is_form_given).then(|| {
            format!(
                "the times in column {} have no unit: read as {} (time_unit in [columns] of the signal map gives another)",
                heads[self.time].name,
                self.form.name()
            )
        })
    }
}

/// Notes what a value looks like: all of them whole, all of them truth values, or texts.
pub(crate) fn look(head: &mut Head, whole: &mut bool, cell: &TableCell<'_>) {
    let value = cell.number();
    *whole &= value.is_some_and(|value| value.fract() == 0.0);
    head.kind = match (cell, value) {
        (TableCell::Text(text), None) if ["true", "false"].iter().any(|word| text.eq_ignore_ascii_case(word)) => LeafKind::Bool,
        (_, None) => LeafKind::Text,
        _ if *whole => LeafKind::Integer,
        _ => LeafKind::Float,
    };
    head.sample = head.sample.or(value);
}

/// The column of this name, with or without its unit.
pub(crate) fn find(heads: &[Head], name: &str) -> Option<usize> {
    heads.iter().position(|head| head.name == name).or_else(|| heads.iter().position(|head| head.bare == name))
}

/// Names of the columns, for an error.
pub(crate) fn names(heads: &[Head]) -> Vec<String> {
    const MOST: usize = 30;
    let mut names: Vec<String> = heads.iter().take(MOST).map(|head| format!("{:?}", head.name)).collect();
    if heads.len() > MOST {
        names.push(format!("and {} more", heads.len() - MOST));
    }
    names
}

/// A name as its letters and digits, in lower case.
fn key(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The name of a time column without the unit at its end, and that unit: `t_ms`, `time`.
fn time_name(bare: &str) -> (String, Option<Unit>) {
    let last = bare.rsplit(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    let unit = last.parse::<Unit>().ok().filter(|unit| ns_per_unit(*unit).is_some());
    match unit {
        Some(unit) if last.len() < bare.len() => (key(&bare[..bare.len() - last.len()]), Some(unit)),
        _ => (key(bare), None),
    }
}

fn unit_of_head(head: &Head) -> Option<i64> {
    match head.unit {
        HeadUnit::Known(unit) => ns_per_unit(unit),
        _ => time_name(&head.bare).1.and_then(ns_per_unit),
    }
}

/// The column of the times: PlotJuggler's, the first whose name says so, the only one whose type says so, or an index of dates without a name.
fn time_column(heads: &[Head], typed: &[Option<TimeForm>]) -> Option<usize> {
    let is_named = |head: &&Head| TIMES.contains(&time_name(&head.bare).0.as_str());
    let plotjuggler = heads.iter().position(|head| head.name == "__time");
    let named = || heads.iter().position(|head| is_named(&head));
    let by_type = || {
        let mut found = (0..heads.len()).filter(|k| typed[*k] == Some(TimeForm::Typed));
        found.next().filter(|_| found.next().is_none())
    };
    let index = || (typed.first() == Some(&Some(TimeForm::Date))).then_some(0);
    plotjuggler.or_else(named).or_else(by_type).or_else(index)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::log::columns::table::TableFormat;
    use crate::log::file::input::LogInput;
    use std::sync::Arc;

    fn layout(text: &str, given: &TableColumns) -> Result<(TableForm, Vec<Head>)> {
        let table = SignalTable::open(TableFormat::Csv, &Arc::new(LogInput::Memory(text.as_bytes().to_vec())))?;
        let mut heads = table.heads().to_vec();
        TableForm::of(&table, &mut heads, given).map(|layout| (layout, heads))
    }

    /// Column and unit of the times.
    fn time(text: &str) -> (usize, &'static str, bool) {
        let (layout, _) = layout(text, &TableColumns::default()).unwrap();
        (layout.time, layout.form.name(), layout.is_form_given)
    }

    #[test]
    fn the_time_column_and_its_unit_are_found_by_name_size_or_form() {
        assert_eq!(time("a,time [ms]\n1,2\n"), (1, "ms", true));
        assert_eq!(time("t_us,a\n1,2\n"), (0, "us", true));
        assert_eq!(time("time,__time\n1,1700000000.5\n"), (1, "s", false));
        assert_eq!(time("rosbagTimestamp,a\n1700000000123456789,2\n"), (0, "ns", false));
        assert_eq!(time(",a\n2024-05-01 10:00:00.1,2\n"), (0, "ISO 8601", true));
        assert_eq!(time("Zeit;a\n;1\n1,5;2\n"), (0, "s", false));
        // a date is one, whatever the header says
        assert_eq!(time("time [s],a\n2024-05-01T10:00:00Z,2\n"), (0, "ISO 8601", true));
    }

    #[test]
    fn a_table_without_times_says_which_columns_it_has() {
        let error = |text: &str| layout(text, &TableColumns::default()).unwrap_err().to_string();
        let text = error("speed,torque\n1,2\n");
        assert!(text.contains(r#""speed", "torque""#) && text.contains("[columns]"), "{text}");
        let text = error("time,torque\n10:15:00,2\n");
        assert!(text.contains("10:15:00") && text.contains("ISO 8601"), "{text}");
    }

    #[test]
    fn the_signal_map_names_the_columns_and_the_unit() {
        let given = |time: &str, unit: Option<&str>| TableColumns {
            time: Some(time.to_owned()),
            time_unit: unit.map(str::to_owned),
            ..TableColumns::default()
        };
        let (found, _) = layout("time,clock [x]\n1,2\n", &given("clock", Some("ms"))).unwrap();
        assert_eq!((found.time, found.form.name()), (1, "ms"));
        let error = layout("time,a\n1,2\n", &given("clock", None)).unwrap_err().to_string();
        assert!(error.contains("\"clock\"") && error.contains("\"time\""), "{error}");
    }

    #[test]
    fn a_row_per_value_is_the_long_form_and_a_number_called_channel_is_not() {
        let long = |text: &str| layout(text, &TableColumns::default()).unwrap().0.long;
        assert_eq!(long("t,Signal,Value,Unit\n0,v,1,m/s\n"), Some(LongColumns { name: 1, value: 2, unit: Some(3) }));
        assert_eq!(long("t,channel,value\n0,7,1\n"), None);
    }

    #[test]
    fn the_kind_of_a_column_is_that_of_its_values() {
        let (_, heads) = layout("t,gear,stop,v,name,later\n0,1.0,False,1.0,x,\n1,2.0,True,1.5,y,\n", &TableColumns::default()).unwrap();
        let kinds: Vec<LeafKind> = heads[1..].iter().map(|head| head.kind).collect();
        assert_eq!(kinds, [LeafKind::Integer, LeafKind::Bool, LeafKind::Float, LeafKind::Text, LeafKind::Integer]);
    }
}
