//! DCM 2.0: each `KENNFELD` is a table; X is the desired acceleration, Y the speed. A name with REVERSE is that of reverse gear.

use crate::import::error::TextFault;
use crate::import::full_scale::FullScale;
use crate::import::imported::ImportedTable;
use crate::import::number::WrittenNumber;
use crate::import::unit_names;
use crate::map::Gear;

/// A `KENNFELD` being read.
struct Kennfeld {
    line: u64,
    gear: Gear,
    shape: [usize; 2],
    x: Vec<f64>,
    y: Vec<f64>,
    values: Vec<WrittenNumber>,
    units: [String; 2],
}

pub(crate) fn read(text: &str, full: FullScale) -> Result<Vec<ImportedTable>, TextFault> {
    let (mut tables, mut field) = (Vec::new(), None::<Kennfeld>);
    let header = unit_names::of_header(text);
    for (k, line) in text.lines().enumerate() {
        let number = k as u64 + 1;
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { continue };
        if keyword == "KENNFELD" || keyword == "GRUPPENKENNFELD" {
            let name = words.next().unwrap_or_default().to_ascii_uppercase();
            let mut size = || {
                words.next().and_then(|w| w.parse().ok()).ok_or_else(|| TextFault::at(number, "a KENNFELD needs its name and two sizes"))
            };
            let shape = [size()?, size()?];
            let gear = if name.contains("REVERSE") { Gear::Reverse } else { Gear::Forward };
            field =
                Some(Kennfeld { line: number, gear, shape, x: Vec::new(), y: Vec::new(), values: Vec::new(), units: Default::default() });
            continue;
        }
        let Some(open) = &mut field else { continue };
        let unit = || line.split('"').nth(1).unwrap_or_default().to_owned();
        match keyword {
            "ST/X" => open.x.extend(numbers(words, number)?.iter().map(|n| n.value)),
            "ST/Y" => open.y.extend(numbers(words, number)?.iter().map(|n| n.value)),
            "WERT" => open.values.extend(numbers(words, number)?),
            "EINHEIT_Y" => open.units[0] = unit(),
            "EINHEIT_W" => open.units[1] = unit(),
            "END" => {
                tables.extend(field.take().map(|field| field.table(header, full)).transpose()?);
            }
            _ => {}
        }
    }
    if let Some(open) = field {
        return Err(TextFault::at(open.line, "the KENNFELD is not closed by END"));
    }
    if tables.is_empty() { Err(TextFault::whole("it holds no KENNFELD")) } else { Ok(tables) }
}

fn numbers<'a>(words: impl Iterator<Item = &'a str>, line: u64) -> Result<Vec<WrittenNumber>, TextFault> {
    words.map(|word| WrittenNumber::parse(word).ok_or_else(|| TextFault::at(line, format!("{word:?} is not a finite number")))).collect()
}

impl Kennfeld {
    fn table(self, header: Option<[unit_names::Conversion; 2]>, full: FullScale) -> Result<ImportedTable, TextFault> {
        let [columns, rows] = self.shape;
        if (self.x.len(), self.y.len(), self.values.len()) != (columns, rows, columns * rows) {
            let what = format!(
                "the KENNFELD of {columns} × {rows} has {} ST/X, {} ST/Y and {} WERT",
                self.x.len(),
                self.y.len(),
                self.values.len()
            );
            return Err(TextFault::at(self.line, what));
        }
        let named = |fault: String| TextFault::at(self.line, fault);
        let [speed, torque] = match header {
            Some(conversions) => conversions,
            None => [unit_names::speed(&self.units[0], full).map_err(named)?, unit_names::torque(&self.units[1], full).map_err(named)?],
        };
        let speeds: Vec<f64> = self.y.iter().map(|v| speed.0 * v + speed.1).collect();
        let values: Vec<WrittenNumber> = self.values.iter().map(|t| t.scaled(torque.0, torque.1)).collect();
        Ok(ImportedTable::of_matrix(self.gear, &speeds, &self.x, &values))
    }
}
