//! Autoware's `accel_map.csv` and `brake_map.csv`: acceleration [m/s²] over pedal (rows, 0 to 1) and speed (columns, [m/s]).
//!
//! Pedal = |torque| / full torque. The full torque is the vehicle's torque limit, or without one the largest torque of Table 2: one factor
//! for both pedals, named in the corner cell. The rows are Table 1's torques: from 0 up for the accel map, from 0 down for the brake map.
//! Row 0, no torque, is shared.
//!
//! Source of the rules: `raw_vehicle_cmd_converter` of Autoware Universe. All rows have one length, of at least two cells; in every column
//! acceleration rises strictly with the accel pedal and falls strictly with the brake pedal. A speed outside is clamped by the loader.

use crate::export::file::File;
use crate::export::number::plain;
use crate::export::{Error, ExportSettings, MapSource, Result};
use crate::map::{AccelTable, Gear};

const FORMAT: &str = "autoware";

pub(crate) fn files(source: &MapSource, settings: &ExportSettings) -> Result<Vec<File>> {
    let full_nm = settings.full_scale_nm.unwrap_or_else(|| source.full_torque_nm());
    let mut files = Vec::new();
    for (gear, table) in &source.accel {
        // a corner cell has no line of its own for a verdict
        let corner = format!("pivot-cal torque_nm/{full_nm}{}", if source.proof.is_verified { "" } else { " UNVERIFIED" });
        for (name, sign, what) in [("accel_map", 1.0, "torques above 0"), ("brake_map", -1.0, "braking torques, below 0")] {
            let text = corner.clone() + &map(table, *gear, sign, what, full_nm)?;
            let name = format!("{name}{}.csv", gear.file_infix());
            let note = Some(format!("pedal = torque / {full_nm} N·m"));
            files.push(File { note, ..File::new(name, text) });
        }
    }
    Ok(files)
}

/// One map behind its corner cell; `sign` is +1 for the accel pedal and −1 for the brake pedal.
fn map(table: &AccelTable, gear: Gear, sign: f64, what: &'static str, full_nm: f64) -> Result<String> {
    let (low, high) = (table.torque_nm().first(), table.torque_nm().last());
    let mut torques: Vec<f64> = table.torque_nm().breaks().iter().map(|t| sign * t).filter(|t| *t > 0.0).collect();
    if torques.is_empty() || !table.torque_nm().contains(0.0) {
        return Err(Error::Torques { format: FORMAT, what, gear, low, high });
    }
    torques.push(0.0);
    torques.sort_by(f64::total_cmp);
    let speeds = table.speed_mps().breaks();
    let mut text = String::new();
    push_row(&mut text, speeds);
    let mut before: Option<Vec<f64>> = None;
    for torque in torques {
        // nine decimals, as Table 1 has them
        let accel: Vec<f64> = speeds.iter().filter_map(|v| table.accel_from_torque(*v, sign * torque)).map(|a| rounded(a, 1e-9)).collect();
        let falls = |before: &Vec<f64>| (0..accel.len()).find(|j| sign * (accel[*j] - before[*j]) <= 0.0);
        if let Some(j) = before.as_ref().and_then(falls) {
            let place = format!("speed {} m/s, torque {} N·m", speeds[j], sign * torque);
            return Err(Error::NotMonotone { format: FORMAT, gear, place });
        }
        text.push_str(&plain(rounded(torque / full_nm, 1e-9)));
        push_row(&mut text, &accel);
        before = Some(accel);
    }
    Ok(text)
}

/// The values of a row, and its end.
fn push_row(text: &mut String, values: &[f64]) {
    for value in values {
        text.push(',');
        text.push_str(&plain(*value));
    }
    text.push('\n');
}

/// To a multiple of `step`, as the decimal that a person would write.
pub(crate) fn rounded(value: f64, step: f64) -> f64 {
    (value / step).round() / (1.0 / step).round()
}
