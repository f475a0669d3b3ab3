//! The exported C: the arrays of `pivot_map.c`, of floating-point numbers or whole counts.

use crate::import::error::TextFault;
use crate::import::imported::ImportedTable;
use crate::import::number::WrittenNumber;
use crate::import::unit_names::{self, SI};
use crate::map::Gear;

pub(crate) fn read(text: &str) -> Result<Vec<ImportedTable>, TextFault> {
    let [speed_unit, torque_unit] = unit_names::of_header(text).unwrap_or([SI; 2]);
    let mut tables = Vec::new();
    for gear in Gear::ALL {
        let Some(speeds) = array(text, &format!("{gear}_speed_"))? else { continue };
        let absent = |what: &str| TextFault::whole(format!("{gear} gear has speeds and no {what}"));
        let accels = array(text, &format!("{gear}_accel_"))?.ok_or_else(|| absent("accelerations"))?;
        let torques = array(text, &format!("{gear}_torque_"))?.ok_or_else(|| absent("torques"))?;
        if torques.len() != speeds.len() * accels.len() {
            let what = format!("{gear} gear has {} torques for {} × {} breaks", torques.len(), speeds.len(), accels.len());
            return Err(TextFault::whole(what));
        }
        let speeds: Vec<f64> = speeds.iter().map(|v| speed_unit.0 * v.value + speed_unit.1).collect();
        let accels: Vec<f64> = accels.iter().map(|a| a.value).collect();
        let torques: Vec<WrittenNumber> = torques.iter().map(|t| t.scaled(torque_unit.0, torque_unit.1)).collect();
        tables.push(ImportedTable::of_matrix(gear, &speeds, &accels, &torques));
    }
    if tables.is_empty() { Err(TextFault::whole("it holds no array forward_speed_… as pivot_map.c does")) } else { Ok(tables) }
}

/// The numbers of the array whose name begins with `prefix`, counts converted by the scale and offset beside its name.
fn array(text: &str, prefix: &str) -> Result<Option<Vec<WrittenNumber>>, TextFault> {
    let declared = |line: &&str| line.contains("const") && line.contains(prefix) && line.contains('[');
    let Some(declaration) = text.lines().find(declared) else { return Ok(None) };
    let start = declaration.as_ptr() as usize - text.as_ptr() as usize;
    let number = 1 + text[..start].matches('\n').count() as u64;
    let body = text[start..].split_once('{').and_then(|(_, rest)| rest.split_once('}')).map(|(body, _)| body);
    let body = body.ok_or_else(|| TextFault::at(number, "the array has no numbers in braces"))?;
    let mut numbers = Vec::new();
    for word in body.split(',').map(str::trim).filter(|word| !word.is_empty()) {
        let parsed = WrittenNumber::parse(word.trim_end_matches(['f', 'F']));
        numbers.push(parsed.ok_or_else(|| TextFault::at(number, format!("{word:?} is not a finite number")))?);
    }
    // {forward_speed_mps, 23u, 0.00005, 0.0}
    let used = text.lines().find(|line| line.trim_start().starts_with(&format!("{{{prefix}")));
    let parts: Vec<&str> = used.map_or(Vec::new(), |line| line.trim().trim_matches(['{', '}', ',']).split(',').map(str::trim).collect());
    if let [_, _, scale, offset] = parts[..] {
        let factor = |text: &str| {
            text.trim_end_matches(['f', 'F', '}']).parse::<f64>().map_err(|_| TextFault::at(number, format!("{text:?} is no scale")))
        };
        let (scale, offset) = (factor(scale)?, factor(offset)?);
        for number in &mut numbers {
            *number = number.scaled(scale, offset);
        }
    }
    Ok(Some(numbers))
}
