//! The exported Rust: the `static` tables of `pivot_map.rs`, of floating-point numbers or whole counts.

use crate::import::error::TextFault;
use crate::import::imported::ImportedTable;
use crate::import::number::WrittenNumber;
use crate::import::unit_names::{self, SI};
use crate::map::Gear;

/// What a table begins with, after the gear's name.
pub(crate) const TABLE: &str = ": Table = Table {";

pub(crate) fn read(text: &str) -> Result<Vec<ImportedTable>, TextFault> {
    let [speed_unit, torque_unit] = unit_names::of_header(text).unwrap_or([SI; 2]);
    let mut tables = Vec::new();
    for gear in Gear::ALL {
        let start = format!("static {}{TABLE}", gear.to_string().to_ascii_uppercase());
        let Some(at) = text.find(&start) else { continue };
        let line = 1 + text[..at].matches('\n').count() as u64;
        let body = &text[at + start.len()..];
        let body = &body[..body.find("};").ok_or_else(|| TextFault::at(line, "the table is not closed by };"))?];
        // speeds, accelerations and torques, in this order
        let parts = body.split("Numbers {").skip(1).map(|part| numbers(part, line)).collect::<Result<Vec<_>, _>>()?;
        let [speeds, accels, torques] = <[Vec<WrittenNumber>; 3]>::try_from(parts)
            .map_err(|parts| TextFault::at(line, format!("the table of {gear} gear has {} lists of numbers instead of 3", parts.len())))?;
        if torques.len() != speeds.len() * accels.len() {
            let what = format!("{gear} gear has {} torques for {} × {} breaks", torques.len(), speeds.len(), accels.len());
            return Err(TextFault::at(line, what));
        }
        let speeds: Vec<f64> = speeds.iter().map(|v| speed_unit.0 * v.value + speed_unit.1).collect();
        let accels: Vec<f64> = accels.iter().map(|a| a.value).collect();
        let torques: Vec<WrittenNumber> = torques.iter().map(|t| t.scaled(torque_unit.0, torque_unit.1)).collect();
        tables.push(ImportedTable::of_matrix(gear, &speeds, &accels, &torques));
    }
    if tables.is_empty() { Err(TextFault::whole(format!("it holds no static FORWARD{TABLE} as pivot_map.rs does"))) } else { Ok(tables) }
}

/// The numbers between `&[` and `]`, counts converted by the scale and offset behind them.
fn numbers(part: &str, line: u64) -> Result<Vec<WrittenNumber>, TextFault> {
    let list = part.split_once("&[").and_then(|(_, rest)| rest.split_once(']'));
    let (list, behind) = list.ok_or_else(|| TextFault::at(line, "a list of numbers is not closed by ]"))?;
    let words = list.split(',').map(str::trim).filter(|word| !word.is_empty());
    let parse = |word: &str| WrittenNumber::parse(word).ok_or_else(|| TextFault::at(line, format!("{word:?} is not a finite number")));
    let found = words.map(parse).collect::<Result<Vec<_>, _>>()?;
    let behind = behind.split('}').next().unwrap_or_default();
    let field = |name: &str| behind.split_once(name).map(|(_, rest)| rest.split(',').next().unwrap_or_default().trim());
    let Some((scale, offset)) = field("scale:").zip(field("offset:")) else { return Ok(found) };
    let factor = |text: &str| text.parse::<f64>().map_err(|_| TextFault::at(line, format!("{text:?} is no scale")));
    let (scale, offset) = (factor(scale)?, factor(offset)?);
    Ok(found.into_iter().map(|number| number.scaled(scale, offset)).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const TEXT: &str = "static FORWARD: Table = Table {
    speed_mps: Numbers { numbers: &[
        0, 10,
    ], scale: 0.01, offset: 0.0 },
    accel_mps2: Numbers { numbers: &[
        -0.5, 0.5,
    ] },
    torque_nm: Numbers { numbers: &[
        -20, 20, -19, 22,
    ], scale: 0.5, offset: 1.0 },
    crc32: 0x00000000,
};
";

    #[test]
    fn counts_and_numbers_are_read() {
        let tables = read(TEXT).unwrap();
        let points: Vec<_> =
            tables[0].points.iter().map(|p| (p.speed_mps, p.accel_mps2, p.torque_nm.value, p.torque_nm.last_digit)).collect();
        assert_eq!(points, [(0.0, -0.5, -9.0, 0.5), (0.0, 0.5, 11.0, 0.5), (0.1, -0.5, -8.5, 0.5), (0.1, 0.5, 12.0, 0.5)]);
    }

    #[test]
    fn what_is_missing_is_said_with_its_line() {
        let said = |text: &str| read(text).unwrap_err();
        assert_eq!(said(&TEXT.replace(", 22", "")).what, "forward gear has 3 torques for 2 × 2 breaks");
        assert_eq!(said(&TEXT.replace("-19", "x")), TextFault::at(1, "\"x\" is not a finite number"));
        assert!(said("").what.contains("static FORWARD"));
    }
}
