//! Long-form CSV: a header that names speed, acceleration and command, and a line per point.

use crate::import::foreign::{CommandPoint, CommandPoints, CsvLine, Misread, MisreadKind};

const SPEED: &[&str] = &["speed", "velocity", "vel", "v"];
const ACCEL: &[&str] = &["acceleration", "accel", "acc", "a"];
const COMMAND: &[&str] = &["torque", "command", "cmd", "throttle", "pedal", "tau"];

/// A column's name without its unit: `speed_mps`, `Speed [m/s]` and `speed` are one.
fn plain(name: &str) -> String {
    let name = name.trim().trim_matches('"').to_ascii_lowercase();
    name.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default().to_owned()
}

fn column(header: &CsvLine, names: &[&str]) -> Option<usize> {
    header.texts.iter().position(|text| names.contains(&plain(text).as_str()))
}

/// Whether the header names speed, acceleration and a command, each in a column of its own.
pub(crate) fn says_long_form(header: &CsvLine) -> bool {
    [SPEED, ACCEL, COMMAND].into_iter().all(|names| column(header, names).is_some())
}

/// The points, line by line: a line that cannot be read is reported and skipped.
pub(crate) fn points_of_long_csv(cells: &[CsvLine]) -> (CommandPoints, Vec<Misread>) {
    let mut misread = Vec::new();
    let Some((header, rows)) = cells.split_first() else { return (CommandPoints::default(), misread) };
    let columns = [SPEED, ACCEL, COMMAND].map(|names| column(header, names).unwrap_or(usize::MAX));
    let command = header.texts.get(columns[2]).cloned().unwrap_or_default();
    let mut points = CommandPoints { command, ..CommandPoints::default() };
    for row in rows {
        if row.texts.len() != header.texts.len() {
            let what = format!("{} cells; the first line has {}", row.texts.len(), header.texts.len());
            misread.push(Misread { kind: MisreadKind::Ragged, line: row.line, column: 0, what });
        }
        let numbers = columns.map(|k| {
            let text = row.texts.get(k)?;
            let number = text.parse::<f64>().ok().filter(|v| v.is_finite());
            if number.is_none() {
                let what = format!("{text:?} is not a finite number");
                misread.push(Misread { kind: MisreadKind::NotANumber, line: row.line, column: k + 1, what });
            }
            number
        });
        if let [Some(speed), Some(accel), Some(command)] = numbers {
            points.points.push(CommandPoint { line: row.line, speed, accel, command });
        }
    }
    if points.points.is_empty() {
        let what = "no line that can be read as a point".to_owned();
        misread.push(Misread { kind: MisreadKind::TooSmall, line: header.line, column: 0, what });
    }
    (points, misread)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::foreign::cells_of_csv;

    #[test]
    fn columns_are_found_by_name_whatever_their_order_and_unit() {
        let cells = cells_of_csv("torque_nm,Speed [m/s],accel_mps2\n4,0.1,0.5\n5,0.1\n");
        assert!(says_long_form(&cells[0]));
        let (points, misread) = points_of_long_csv(&cells);
        assert_eq!(points.points, [CommandPoint { line: 2, speed: 0.1, accel: 0.5, command: 4.0 }]);
        assert_eq!(misread.len(), 1);
        assert!(!says_long_form(&cells_of_csv("default,0,5\n")[0]));
    }
}
