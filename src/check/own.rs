//! Rules of our own maps: `table1.json`, `table2.json` and the CSV files beside them.

use crate::check::foreign::{CsvLine, Grid};
use crate::check::grid_rules::{Along, Judged, Meaning, misread};
use crate::check::{Finding, Map, Report, Rule, Settings, Severity};
use crate::map::accel_table::{SPEED_AXIS, TORQUE_AXIS};
use crate::map::torque_table::ACCEL_AXIS;
use crate::map::{FORMAT_VERSION, TABLE1_FORMAT, TABLE2_FORMAT, Table1File, Table2File, sha256_hex};
use serde_json::Value;

/// Which table a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Table {
    One,
    Two,
}

impl Table {
    fn meaning(self) -> Meaning {
        let rising = true;
        match self {
            Self::One => Meaning { rows: "torque", columns: "speed", along: Along::Rows, rising, plateau: Severity::Error },
            Self::Two => Meaning { rows: "speed", columns: "acceleration", along: Along::Columns, rising, plateau: Severity::Warning },
        }
    }

    fn json(self) -> &'static str {
        if self == Self::One { "table1.json" } else { "table2.json" }
    }

    fn corner(self) -> String {
        match self {
            Self::One => format!("{TORQUE_AXIS}\\{SPEED_AXIS}"),
            Self::Two => format!("{SPEED_AXIS}\\{ACCEL_AXIS}"),
        }
    }

    /// JSON fields of row breaks, column breaks and values.
    fn fields(self) -> [&'static str; 3] {
        match self {
            Self::One => [TORQUE_AXIS, SPEED_AXIS, ACCEL_AXIS],
            Self::Two => [SPEED_AXIS, ACCEL_AXIS, TORQUE_AXIS],
        }
    }
}

impl Map<'_> {
    pub(crate) fn own_csv(&self, cells: &[CsvLine], corner: &str, settings: Settings) -> Report {
        let table = if corner == Table::One.corner() || (corner != Table::Two.corner() && self.name.starts_with("table1")) {
            Table::One
        } else {
            Table::Two
        };
        let (grid, unread) = Grid::of_cells(cells);
        let mut findings: Vec<_> = misread(&unread).collect();
        if corner != table.corner() {
            let what = format!("the corner cell says {corner:?}; it must be {:?} (rows\\columns)", table.corner());
            findings.push(Finding::whole(Rule::Readable, Severity::Error, what).on(Some(1), 1));
        }
        let json = (self.beside)(table.json()).and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
        let maps = json.as_ref().and_then(|j| j["maps"].as_array());
        let described = maps.and_then(|maps| maps.iter().find(|m| m["csv"]["file"] == self.name.as_str()));
        if let Some(map) = described {
            if map["csv"]["sha256"] != sha256_hex(self.bytes).as_str() {
                let what = format!("this is not the file that {} describes: it was edited, or belongs to another map", table.json());
                findings.push(Finding::whole(Rule::HashMismatch, Severity::Error, what));
            }
            dead_band(table, map, "", &mut findings);
        } else {
            let what = format!("no {} beside it describes this file: dead band and hash are not judged", table.json());
            findings.push(Finding::whole(Rule::HashMismatch, Severity::Note, what));
        }
        let limited = (table == Table::Two).then(|| described.map_or_else(|| extremes(&grid), unreachable));
        let judged = Judged { grid: &grid, meaning: table.meaning(), of: String::new(), limited };
        let places = judge(table, &judged, settings, &mut findings);
        let (rows, columns) = grid.shape();
        let format = if table == Table::One { "Table 1 (CSV)" } else { "Table 2 (CSV)" };
        let size = format!("{rows} × {columns} ({} × {})", judged.meaning.rows, judged.meaning.columns);
        Report::new(self.path.clone(), format, size, findings, &places)
    }

    pub(crate) fn own_json(&self, text: &str, settings: Settings) -> Report {
        let unreadable = |what: String| {
            let finding = Finding::whole(Rule::Readable, Severity::Error, what);
            Report::new(self.path.clone(), "JSON", String::new(), vec![finding], &[])
        };
        let json: Value = match serde_json::from_str(text) {
            Ok(json) => json,
            Err(error) => return unreadable(format!("the JSON cannot be read: {error}")),
        };
        let table = match json["format"].as_str() {
            Some(TABLE1_FORMAT) => Table::One,
            Some(TABLE2_FORMAT) => Table::Two,
            other => return unreadable(format!("\"format\" is {other:?}; a map says {TABLE1_FORMAT:?} or {TABLE2_FORMAT:?}")),
        };
        if json["format_version"].as_u64() != Some(u64::from(FORMAT_VERSION)) {
            return unreadable(format!("format version {}; this program reads version {FORMAT_VERSION}", json["format_version"]));
        }
        let (mut findings, mut places, mut sizes) = (Vec::new(), Vec::<(Rule, usize, &'static str)>::new(), Vec::new());
        let none = Vec::new();
        let maps = json["maps"].as_array().unwrap_or(&none);
        if maps.is_empty() {
            findings.push(Finding::whole(Rule::Size, Severity::Error, "the file holds no map"));
        }
        let several = maps.iter().any(|m| m["wheel_angle_deg"] != maps[0]["wheel_angle_deg"]);
        for map in maps {
            let at = if several { format!(" at {}°", map["wheel_angle_deg"]) } else { String::new() };
            let of = map["gear"].as_str().map_or(String::new(), |gear| format!("{gear} gear{at}, "));
            let grid = grid_of_json(map, table, &of, &mut findings);
            self.csv_beside(map, &of, &mut findings);
            dead_band(table, map, &of, &mut findings);
            let limited = (table == Table::Two).then(|| unreachable(map));
            let judged = Judged { grid: &grid, meaning: table.meaning(), of, limited };
            for (rule, count, unit) in judge(table, &judged, settings, &mut findings) {
                match places.iter_mut().find(|p| p.0 == rule) {
                    Some(place) => place.1 += count,
                    None => places.push((rule, count, unit)),
                }
            }
            let (rows, columns) = grid.shape();
            sizes.push(format!("{}{at} {rows} × {columns}", map["gear"].as_str().unwrap_or("gear unknown")));
        }
        if table == Table::Two {
            self.table1_beside(&json, &mut findings);
        }
        let strict = match table {
            Table::One => Table1File::from_json(text).err(),
            Table::Two => Table2File::from_json(text).err(),
        };
        if let Some(error) = strict.filter(|_| findings.iter().all(|f| f.severity != Severity::Error)) {
            findings.push(Finding::whole(Rule::Readable, Severity::Error, error.to_string()));
        }
        let format = if table == Table::One { "Table 1 (JSON)" } else { "Table 2 (JSON)" };
        let meaning = table.meaning();
        let size = format!("{} ({} × {})", sizes.join(", "), meaning.rows, meaning.columns);
        Report::new(self.path.clone(), format, size, findings, &places)
    }

    /// The CSV that a JSON file describes.
    fn csv_beside(&self, map: &Value, of: &str, findings: &mut Vec<Finding>) {
        let file = map["csv"]["file"].as_str().unwrap_or_default();
        match (self.beside)(file) {
            Some(bytes) if map["csv"]["sha256"] != sha256_hex(&bytes).as_str() => {
                let what = format!("{file} is not the file that is described here: it was edited, or belongs to another map");
                findings.push(Finding::at(Rule::HashMismatch, Severity::Error, of.trim_end_matches(", "), what));
            }
            Some(_) => {}
            None => {
                let what = format!("{file:?}, which is described here, is not beside this file: not judged");
                findings.push(Finding::at(Rule::HashMismatch, Severity::Note, of.trim_end_matches(", "), what));
            }
        }
    }

    /// The `table1.json` that a `table2.json` was made from.
    fn table1_beside(&self, json: &Value, findings: &mut Vec<Finding>) {
        let file = json["table1"]["file"].as_str().unwrap_or_default();
        match (self.beside)(file) {
            Some(bytes) if json["table1"]["sha256"] != sha256_hex(&bytes).as_str() => {
                let what = format!("{file} beside it is not the one that this table was inverted from");
                findings.push(Finding::whole(Rule::HashMismatch, Severity::Error, what));
            }
            Some(_) => {}
            None => {
                let what = format!("{file:?}, from which this table was inverted, is not beside it: not judged");
                findings.push(Finding::whole(Rule::HashMismatch, Severity::Note, what));
            }
        }
    }
}

/// The rules of a matrix, and how many places were judged.
fn judge(table: Table, judged: &Judged, settings: Settings, findings: &mut Vec<Finding>) -> Vec<(Rule, usize, &'static str)> {
    let grid = judged.grid;
    judged.axes(findings);
    // the row at speed 0 may hold the wheel: torque 0 for every a ≤ 0
    let held = |i: usize, j: usize| {
        table == Table::Two
            && grid.row_breaks.get(i).copied().flatten() == Some(0.0)
            && grid.at(i, j) == Some(0.0)
            && grid.column_breaks[j].is_some_and(|a| a <= 0.0)
    };
    let steps = judged.monotone(held, findings);
    judged.jumps(settings, findings);
    let (command, speed) = match table {
        Table::One => (&grid.row_breaks, Along::Columns),
        Table::Two => (&grid.column_breaks, Along::Rows),
    };
    judged.speed_from_zero(speed, Severity::Warning, findings);
    let known: Vec<f64> = command.iter().copied().flatten().collect();
    let (least, most) = (known.iter().copied().fold(f64::INFINITY, f64::min), known.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    if !known.is_empty() && (least > 0.0 || most < 0.0) {
        let name = if table == Table::One { judged.meaning.rows } else { judged.meaning.columns };
        let what = format!("{name} reaches from {least} to {most}, without 0: coasting and holding a speed are outside");
        findings.push(Finding::at(Rule::RangeGap, Severity::Warning, judged.of.trim_end_matches(", "), what));
    }
    signs(table, judged, findings);
    let (rows, columns) = grid.shape();
    vec![(Rule::NotMonotone, steps, "steps"), (Rule::Plateau, steps, "steps"), (Rule::Sign, rows * columns, "cells")]
}

/// Friction opposes motion: without torque, and all the more with a braking one, the wheel never speeds up.
fn signs(table: Table, judged: &Judged, findings: &mut Vec<Finding>) {
    let grid = judged.grid;
    let (rows, columns) = grid.shape();
    for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        let (axis, value) = match table {
            Table::One => (grid.row_breaks[i], grid.at(i, j)),
            Table::Two => (grid.column_breaks[j], grid.at(i, j)),
        };
        let (Some(axis), Some(value)) = (axis, value) else { continue };
        let (torque, accel) = if table == Table::One { (axis, value) } else { (value, axis) };
        if torque == 0.0 && accel > 0.0 || torque < 0.0 && accel == 0.0 {
            let what = if torque == 0.0 {
                format!("{accel} m/s² without torque: the wheel speeds up by itself")
            } else {
                format!("{torque} N·m to hold a speed: the wheel speeds up by itself")
            };
            findings.push(judged.cell(Rule::CoastPositive, Severity::Error, i, j, what));
        } else if torque < 0.0 && accel > 0.0 {
            findings.push(judged.cell(
                Rule::Sign,
                Severity::Error,
                i,
                j,
                format!("{torque} N·m for {accel} m/s²: a braking torque drives"),
            ));
        }
    }
}

/// The dead band of a map: `breakaway` in Table 1, `dead_band` in Table 2.
fn dead_band(table: Table, map: &Value, of: &str, findings: &mut Vec<Finding>) {
    let (told, sound) = match table {
        Table::One => {
            let torque = map["breakaway"]["torque_nm"].as_f64();
            (torque.map(|t| format!("breakaway torque {t} N·m")), torque.is_some_and(|t| t > 0.0))
        }
        Table::Two => {
            let (low, high) = (map["dead_band"]["low_nm"].as_f64(), map["dead_band"]["high_nm"].as_f64());
            (low.zip(high).map(|(l, h)| format!("dead band {l} to {h} N·m")), low.zip(high).is_some_and(|(l, h)| l < 0.0 && h > 0.0))
        }
    };
    if !sound {
        let what = told.map_or("no dead band is told".to_owned(), |t| format!("{t}: a resting wheel has friction both ways"));
        findings.push(Finding::at(Rule::DeadBand, Severity::Error, of.trim_end_matches(", "), what));
    }
}

/// Cells whose status is `unreachable`.
fn unreachable(map: &Value) -> Vec<Vec<bool>> {
    let rows = map["status"].as_array().map_or(&[][..], Vec::as_slice);
    rows.iter().map(|row| row.as_array().map_or(Vec::new(), |row| row.iter().map(|s| s == "unreachable").collect())).collect()
}

/// Without the JSON: cells at the table's largest or smallest value are taken for the torque limit.
fn extremes(grid: &Grid) -> Vec<Vec<bool>> {
    let values = || grid.values.iter().flatten().copied().flatten();
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    grid.values.iter().map(|row| row.iter().map(|v| v.is_some_and(|v| v == least || v == most)).collect()).collect()
}

/// The matrix of a map in JSON; what is no number, and rows of a wrong length, are told.
fn grid_of_json(map: &Value, table: Table, of: &str, findings: &mut Vec<Finding>) -> Grid {
    let [rows, columns, values] = table.fields();
    let gear = of.trim_end_matches(", ");
    let mut numbers = |array: &Value, what: &str| -> Vec<Option<f64>> {
        let items = array.as_array().map_or(&[][..], Vec::as_slice);
        let number = |(k, item): (usize, &Value)| {
            let number = item.as_f64();
            if number.is_none() {
                let what = format!("{what}[{k}] is {item}, not a number");
                findings.push(Finding::at(Rule::NotANumber, Severity::Error, gear, what));
            }
            number
        };
        items.iter().enumerate().map(number).collect()
    };
    let mut grid = Grid { row_breaks: numbers(&map[rows], rows), column_breaks: numbers(&map[columns], columns), ..Grid::default() };
    for (i, row) in map[values].as_array().map_or(&[][..], Vec::as_slice).iter().enumerate() {
        grid.values.push(numbers(row, &format!("{values}[{i}]")));
    }
    let width = grid.column_breaks.len();
    for (i, row) in grid.values.iter_mut().enumerate() {
        if row.len() != width {
            let what = format!("{values}[{i}] has {} values; {columns} has {width}", row.len());
            findings.push(Finding::at(Rule::RaggedRow, Severity::Error, gear, what));
            row.resize(width, None);
        }
    }
    if grid.values.len() != grid.row_breaks.len() {
        let what = format!("{} rows of values; {rows} has {} breaks", grid.values.len(), grid.row_breaks.len());
        findings.push(Finding::at(Rule::RaggedRow, Severity::Error, gear, what));
        grid.values.resize(grid.row_breaks.len(), vec![None; width]);
    }
    if grid.row_breaks.len() < 2 || width < 2 {
        let what = format!("{} × {width} cells; interpolation needs at least 2 × 2", grid.row_breaks.len());
        findings.push(Finding::at(Rule::Size, Severity::Error, gear, what));
    }
    grid
}
