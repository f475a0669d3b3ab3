//! Rules of our own maps: `table1.json`, `table2.json` and the CSV files beside them.
//!
//! The JSON is judged as raw values, not by [`crate::map::MapFolder`]: that reader refuses a damaged file at its first flaw, while the
//! check reports every flaw. The reader is used at the end for what only it checks (statuses, standard errors, and every other array).

use crate::check::grid_rules::{GridAxis, JudgedGrid, Meaning, misread};
use crate::check::{CheckReport, CheckSettings, Map, Rule, RuleBreach, Severity};
use crate::import::foreign::{CellGrid, CsvLine};
use crate::map::{
    ACCEL_AXIS, CellStatus, FORMAT_VERSION, SPEED_AXIS, TABLE1_FORMAT, TABLE2_FORMAT, TORQUE_AXIS, Table1File, Table2File, sha256_hex,
};
use serde_json::Value;

/// The table of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OwnTable {
    One,
    Two,
}

impl OwnTable {
    pub(crate) fn meaning(self) -> Meaning {
        let rising = true;
        match self {
            Self::One => Meaning { rows: "torque", columns: "speed", along: GridAxis::Rows, rising, plateau: Severity::Error },
            Self::Two => Meaning { rows: "speed", columns: "acceleration", along: GridAxis::Columns, rising, plateau: Severity::Warning },
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
    pub(crate) fn own_csv(&self, cells: &[CsvLine], corner: &str, settings: CheckSettings) -> CheckReport {
        let table = if corner == OwnTable::One.corner() || (corner != OwnTable::Two.corner() && self.name.starts_with("table1")) {
            OwnTable::One
        } else {
            OwnTable::Two
        };
        let (grid, unread) = CellGrid::of_cells(cells);
        let mut findings: Vec<_> = misread(&unread).collect();
        if corner != table.corner() {
            let what = format!("the corner cell is {corner:?}; it must be {:?} (rows\\columns)", table.corner());
            findings.push(RuleBreach::whole(Rule::Readable, Severity::Error, what).on(Some(1), 1));
        }
        let json = (self.beside)(table.json()).and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
        let maps = json.as_ref().and_then(|j| j["maps"].as_array());
        let described = maps.and_then(|maps| maps.iter().find(|m| m["csv"]["file"] == self.name.as_str()));
        if let Some(map) = described {
            if !has_hash(&map["csv"], self.bytes) {
                let what = format!("this is not the file that {} describes: it was edited, or belongs to another map", table.json());
                findings.push(RuleBreach::whole(Rule::HashMismatch, Severity::Error, what));
            }
            dead_band(table, map, "", &mut findings);
        } else {
            let what = format!("no {} beside it describes this file: dead band and hash are not judged", table.json());
            findings.push(RuleBreach::whole(Rule::HashMismatch, Severity::Note, what));
        }
        let limited = (table == OwnTable::Two).then(|| described.map_or_else(|| extremes(&grid), unreachable));
        let judged = JudgedGrid { grid: &grid, meaning: table.meaning(), of: String::new(), limited };
        let places = judge(table, &judged, settings, &mut findings);
        let (rows, columns) = grid.shape();
        let format = if table == OwnTable::One { "Table 1 (CSV)" } else { "Table 2 (CSV)" };
        let size = format!("{rows} × {columns} ({} × {})", judged.meaning.rows, judged.meaning.columns);
        CheckReport::new(self.path.clone(), format, size, findings, &places)
    }

    pub(crate) fn own_json(&self, text: &str, settings: CheckSettings) -> CheckReport {
        let unreadable = |what: String| {
            let finding = RuleBreach::whole(Rule::Readable, Severity::Error, what);
            CheckReport::new(self.path.clone(), "JSON", String::new(), vec![finding], &[])
        };
        let json: Value = match serde_json::from_str(text) {
            Ok(json) => json,
            Err(error) => return unreadable(format!("the JSON cannot be read: {error}")),
        };
        let table = match json["format"].as_str() {
            Some(TABLE1_FORMAT) => OwnTable::One,
            Some(TABLE2_FORMAT) => OwnTable::Two,
            other => return unreadable(format!("\"format\" is {other:?}; a map says {TABLE1_FORMAT:?} or {TABLE2_FORMAT:?}")),
        };
        if json["format_version"].as_u64() != Some(u64::from(FORMAT_VERSION)) {
            return unreadable(format!("format version {}; this program reads version {FORMAT_VERSION}", json["format_version"]));
        }
        let (mut findings, mut places, mut sizes) = (Vec::new(), Vec::<(Rule, usize, &'static str)>::new(), Vec::new());
        let none = Vec::new();
        let maps = json["maps"].as_array().unwrap_or(&none);
        if maps.is_empty() {
            findings.push(RuleBreach::whole(Rule::Size, Severity::Error, "the file holds no map"));
        }
        let several = maps.iter().any(|m| m["wheel_angle_deg"] != maps[0]["wheel_angle_deg"]);
        for map in maps {
            let at = if several { format!(" at {}°", map["wheel_angle_deg"]) } else { String::new() };
            let of = map["gear"].as_str().map_or(String::new(), |gear| format!("{gear} gear{at}, "));
            let grid = grid_of_json(map, table, &of, &mut findings);
            self.csv_beside(map, &of, &mut findings);
            dead_band(table, map, &of, &mut findings);
            let limited = (table == OwnTable::Two).then(|| unreachable(map));
            let judged = JudgedGrid { grid: &grid, meaning: table.meaning(), of, limited };
            for (rule, count, unit) in judge(table, &judged, settings, &mut findings) {
                match places.iter_mut().find(|p| p.0 == rule) {
                    Some(place) => place.1 += count,
                    None => places.push((rule, count, unit)),
                }
            }
            let (rows, columns) = grid.shape();
            sizes.push(format!("{}{at} {rows} × {columns}", map["gear"].as_str().unwrap_or("gear unknown")));
        }
        if table == OwnTable::Two {
            self.table1_beside(&json, &mut findings);
        }
        self.generations_beside(&json, &mut findings);
        let strict = match table {
            OwnTable::One => Table1File::from_json(text).err(),
            OwnTable::Two => Table2File::from_json(text).err(),
        };
        // a file of another run may be damaged as well: its hash says nothing about its arrays
        let is_explained = findings.iter().any(|f| f.severity == Severity::Error && f.rule != Rule::HashMismatch);
        if let Some(error) = strict.filter(|_| !is_explained) {
            findings.push(RuleBreach::whole(Rule::Readable, Severity::Error, error.to_string()));
        }
        let format = if table == OwnTable::One { "Table 1 (JSON)" } else { "Table 2 (JSON)" };
        let meaning = table.meaning();
        let size = format!("{} ({} × {})", sizes.join(", "), meaning.rows, meaning.columns);
        CheckReport::new(self.path.clone(), format, size, findings, &places)
    }

    /// The CSV that a JSON file describes.
    fn csv_beside(&self, map: &Value, of: &str, findings: &mut Vec<RuleBreach>) {
        let wrong = "is not the file that is described here: it was edited, or belongs to another map";
        let absent = "which is described here, is not beside this file: not judged";
        findings.extend(self.beside(&map["csv"], of.trim_end_matches(", "), wrong, absent));
    }

    /// The `table1.json` that a `table2.json` was made from.
    fn table1_beside(&self, json: &Value, findings: &mut Vec<RuleBreach>) {
        let wrong = "beside it is not the one that this table was inverted from";
        let absent = "from which this table was inverted, is not beside it: not judged";
        findings.extend(self.beside(&json["table1"], "", wrong, absent));
    }

    /// The files beside this one that are of another generation.
    fn generations_beside(&self, json: &Value, findings: &mut Vec<RuleBreach>) {
        for file in ["table1.json", "table2.json", "verify.json"].into_iter().filter(|file| *file != self.name) {
            let Some(bytes) = (self.beside)(file) else { continue };
            let beside = serde_json::from_slice::<Value>(&bytes).unwrap_or_default();
            let of = |json: &Value| json["generation"].as_str().unwrap_or("none").to_owned();
            let is_reported = findings.iter().any(|f| f.rule == Rule::HashMismatch && f.what.starts_with(file));
            if of(&beside) != of(json) && !is_reported {
                let what =
                    format!("{file} beside it is of generation {}, this file of {}: they are of different runs", of(&beside), of(json));
                findings.push(RuleBreach::whole(Rule::HashMismatch, Severity::Error, what));
            }
        }
    }

    /// The fault of a file that `reference` names with its hash.
    fn beside(&self, reference: &Value, at: &str, wrong: &str, absent: &str) -> Option<RuleBreach> {
        let file = reference["file"].as_str().unwrap_or_default();
        match (self.beside)(file) {
            Some(bytes) if has_hash(reference, &bytes) => None,
            Some(_) => Some(RuleBreach::at(Rule::HashMismatch, Severity::Error, at, format!("{file} {wrong}"))),
            None => Some(RuleBreach::at(Rule::HashMismatch, Severity::Note, at, format!("{file:?}, {absent}"))),
        }
    }
}

/// Whether `reference`, an object with the fields of a [`crate::map::CsvRef`], names the hash of `bytes`.
fn has_hash(reference: &Value, bytes: &[u8]) -> bool {
    reference["sha256"] == sha256_hex(bytes).as_str()
}

/// The rules of a matrix, and the number of places judged.
pub(crate) fn judge(
    table: OwnTable,
    judged: &JudgedGrid,
    settings: CheckSettings,
    findings: &mut Vec<RuleBreach>,
) -> Vec<(Rule, usize, &'static str)> {
    let grid = judged.grid;
    judged.axes(findings);
    // the row at speed 0 may hold the wheel: torque 0 for every a ≤ 0
    let held = |i: usize, j: usize| {
        table == OwnTable::Two
            && grid.row_breaks.get(i).copied().flatten() == Some(0.0)
            && grid.at(i, j) == Some(0.0)
            && grid.column_breaks[j].is_some_and(|a| a <= 0.0)
    };
    let steps = judged.monotone(held, findings);
    judged.jumps(settings, findings);
    let (command, speed) = match table {
        OwnTable::One => (&grid.row_breaks, GridAxis::Columns),
        OwnTable::Two => (&grid.column_breaks, GridAxis::Rows),
    };
    judged.speed_from_zero(speed, Severity::Warning, findings);
    let known: Vec<f64> = command.iter().copied().flatten().collect();
    let (least, most) = (known.iter().copied().fold(f64::INFINITY, f64::min), known.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    if !known.is_empty() && (least > 0.0 || most < 0.0) {
        let name = if table == OwnTable::One { judged.meaning.rows } else { judged.meaning.columns };
        let what = format!("{name} reaches from {least} to {most}, without 0: coasting and holding a speed are outside");
        findings.push(RuleBreach::at(Rule::RangeGap, Severity::Warning, judged.of.trim_end_matches(", "), what));
    }
    signs(table, judged, findings);
    let (rows, columns) = grid.shape();
    vec![(Rule::NotMonotone, steps, "steps"), (Rule::Plateau, steps, "steps"), (Rule::Sign, rows * columns, "cells")]
}

/// Friction opposes motion: without torque, and even more with a braking one, the wheel never speeds up.
fn signs(table: OwnTable, judged: &JudgedGrid, findings: &mut Vec<RuleBreach>) {
    let grid = judged.grid;
    let (rows, columns) = grid.shape();
    for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        let (axis, value) = match table {
            OwnTable::One => (grid.row_breaks[i], grid.at(i, j)),
            OwnTable::Two => (grid.column_breaks[j], grid.at(i, j)),
        };
        let (Some(axis), Some(value)) = (axis, value) else { continue };
        let (torque, accel) = if table == OwnTable::One { (axis, value) } else { (value, axis) };
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
fn dead_band(table: OwnTable, map: &Value, of: &str, findings: &mut Vec<RuleBreach>) {
    let (band, sound) = match table {
        OwnTable::One => {
            let torque = map["breakaway"]["torque_nm"].as_f64();
            (torque.map(|t| format!("breakaway torque {t} N·m")), torque.is_some_and(|t| t > 0.0))
        }
        OwnTable::Two => {
            let (low, high) = (map["dead_band"]["low_nm"].as_f64(), map["dead_band"]["high_nm"].as_f64());
            (low.zip(high).map(|(l, h)| format!("dead band {l} to {h} N·m")), low.zip(high).is_some_and(|(l, h)| l < 0.0 && h > 0.0))
        }
    };
    if !sound {
        let what = band.map_or("no dead band is given".to_owned(), |t| format!("{t}: a resting wheel has friction both ways"));
        findings.push(RuleBreach::at(Rule::DeadBand, Severity::Error, of.trim_end_matches(", "), what));
    }
}

/// Cells whose status is `unreachable`.
fn unreachable(map: &Value) -> Vec<Vec<bool>> {
    let unreachable = Value::String(CellStatus::Unreachable.to_string());
    let rows = map["status"].as_array().map_or(&[][..], Vec::as_slice);
    rows.iter().map(|row| row.as_array().map_or(Vec::new(), |row| row.iter().map(|s| *s == unreachable).collect())).collect()
}

/// Without the JSON: cells at the table's largest or smallest value count as the torque limit.
pub(crate) fn extremes(grid: &CellGrid) -> Vec<Vec<bool>> {
    let values = || grid.values.iter().flatten().copied().flatten();
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    grid.values.iter().map(|row| row.iter().map(|v| v.is_some_and(|v| v == least || v == most)).collect()).collect()
}

/// The matrix of a map in JSON; items that are no numbers, and rows of a wrong length, are findings.
fn grid_of_json(map: &Value, table: OwnTable, of: &str, findings: &mut Vec<RuleBreach>) -> CellGrid {
    let [rows, columns, values] = table.fields();
    let gear = of.trim_end_matches(", ");
    let mut numbers = |array: &Value, what: &str| -> Vec<Option<f64>> {
        let items = array.as_array().map_or(&[][..], Vec::as_slice);
        let number = |(k, item): (usize, &Value)| {
            let number = item.as_f64();
            if number.is_none() {
                let what = format!("{what}[{k}] is {item}, not a number");
                findings.push(RuleBreach::at(Rule::NotANumber, Severity::Error, gear, what));
            }
            number
        };
        items.iter().enumerate().map(number).collect()
    };
    let mut grid =
        CellGrid { row_breaks: numbers(&map[rows], rows), column_breaks: numbers(&map[columns], columns), ..CellGrid::default() };
    for (i, row) in map[values].as_array().map_or(&[][..], Vec::as_slice).iter().enumerate() {
        grid.values.push(numbers(row, &format!("{values}[{i}]")));
    }
    let width = grid.column_breaks.len();
    for (i, row) in grid.values.iter_mut().enumerate() {
        if row.len() != width {
            let what = format!("{values}[{i}] has {} values; {columns} has {width}", row.len());
            findings.push(RuleBreach::at(Rule::RaggedRow, Severity::Error, gear, what));
            row.resize(width, None);
        }
    }
    if grid.values.len() != grid.row_breaks.len() {
        let what = format!("{} rows of values; {rows} has {} breaks", grid.values.len(), grid.row_breaks.len());
        findings.push(RuleBreach::at(Rule::RaggedRow, Severity::Error, gear, what));
        grid.values.resize(grid.row_breaks.len(), vec![None; width]);
    }
    if grid.row_breaks.len() < 2 || width < 2 {
        let what = format!("{} × {width} cells; interpolation needs at least 2 × 2", grid.row_breaks.len());
        findings.push(RuleBreach::at(Rule::Size, Severity::Error, gear, what));
    }
    grid
}
