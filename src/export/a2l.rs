//! A2L (ASAP2 1.71): where the tables of the exported C lie, for measurement and calibration tools. Addresses are open: a tool takes them from
//! the program's ELF file by the symbols of `pivot_map.c`, which every object names.
//!
//! X is the desired acceleration, Y the speed: in memory there is one row per speed, with the acceleration running fastest (`ROW_DIR`).
//!
//! Source: ASAM MCD-2 MC (ASAP2) V1.7.1, keywords `AXIS_PTS`, `CHARACTERISTIC`, `RECORD_LAYOUT`, `COMPU_METHOD`, `SYMBOL_LINK`.

use crate::export::dcm::{name, what};
use crate::export::file::File;
use crate::export::number::{Precision, plain};
use crate::export::stored::{StoredNumbers, StoredTable};
use crate::export::{ExportSettings, MapSource, Result, provenance};
use crate::map::{Gear, TorqueTable};
use std::fmt::Write as _;

/// One kind of number: what its objects are called, its unit, and the end of its symbol.
struct A2lQuantity {
    compu_method: &'static str,
    unit: String,
    symbol: String,
}

pub(crate) fn file(source: &MapSource, settings: &ExportSettings) -> Result<File> {
    let units = &settings.units;
    let symbol = |si: &str| units.in_code(si);
    let [speed, accel, torque] = [
        A2lQuantity { compu_method: "PIVOT_MAP_SPEED", unit: units.speed_name().to_owned(), symbol: symbol("speed_mps") },
        A2lQuantity { compu_method: "PIVOT_MAP_ACCELERATION", unit: "m/s^2".to_owned(), symbol: "accel_mps2".to_owned() },
        A2lQuantity { compu_method: "PIVOT_MAP_TORQUE", unit: units.torque_name().to_owned(), symbol: symbol("torque_nm") },
    ];
    let data_type = match (settings.int16, settings.precision) {
        (true, _) => "SWORD",
        (false, Precision::Double) => "FLOAT64_IEEE",
        (false, Precision::Float) => "FLOAT32_IEEE",
    };
    let mut text = String::from("ASAP2_VERSION 1 71\n/*\n");
    for line in provenance::lines(source).into_iter().chain(units.line()) {
        let _ = writeln!(text, " * {line}");
    }
    text.push_str(" * Addresses are open: take them from the ELF file of the program by the symbols that are named.\n */\n");
    text.push_str("/begin PROJECT PIVOT_MAP_PROJECT \"Torque map for turning on the spot\"\n\n");
    let _ = writeln!(
        text,
        "  /begin HEADER \"Generation {}\"\n    VERSION \"{}\"\n  /end HEADER\n",
        source.table2.generation,
        env!("CARGO_PKG_VERSION")
    );
    text.push_str("  /begin MODULE PIVOT_MAP \"Torque map for turning on the spot\"\n\n");
    text.push_str("    /begin MOD_COMMON \"\"\n      BYTE_ORDER MSB_LAST\n    /end MOD_COMMON\n");
    let stored = source.torque.iter().map(|(gear, table)| Ok((*gear, table, StoredTable::new(source, table, settings)?)));
    let stored = stored.collect::<Result<Vec<_>>>()?;
    if let Some((_, _, first)) = stored.first() {
        for (quantity, numbers) in [(&speed, &first.speed), (&accel, &first.accel), (&torque, &first.torque)] {
            compu_method(&mut text, quantity, numbers);
        }
    }
    let layout = |text: &mut String, name: &str, entry: &str| {
        let _ = writeln!(text, "\n    /begin RECORD_LAYOUT {name}\n      {entry}\n    /end RECORD_LAYOUT");
    };
    layout(&mut text, "PIVOT_MAP_AXIS", &format!("AXIS_PTS_X 1 {data_type} INDEX_INCR DIRECT"));
    layout(&mut text, "PIVOT_MAP_VALUES", &format!("FNC_VALUES 1 {data_type} ROW_DIR DIRECT"));
    for (gear, table, _) in &stored {
        objects(&mut text, *gear, table, settings, [&speed, &accel, &torque]);
    }
    text.push_str("\n  /end MODULE\n/end PROJECT\n");
    let note = Some("addresses are open; the tool takes them from the ELF file".to_owned());
    Ok(File { note, ..File::new("pivot_map.a2l", text) })
}

fn compu_method(text: &mut String, quantity: &A2lQuantity, numbers: &StoredNumbers) {
    let A2lQuantity { compu_method, unit, .. } = quantity;
    let (kind, coefficients) = match numbers.unit {
        Some((scale, offset)) => ("LINEAR", format!("\n      COEFFS_LINEAR {} {}", plain(scale), plain(offset))),
        None => ("IDENTICAL", String::new()),
    };
    let _ =
        writeln!(text, "\n    /begin COMPU_METHOD {compu_method} \"\" {kind} \"%12.6\" \"{unit}\"{coefficients}\n    /end COMPU_METHOD");
}

/// The axes and the map of a gear.
fn objects(text: &mut String, gear: Gear, table: &TorqueTable, settings: &ExportSettings, [speed, accel, torque]: [&A2lQuantity; 3]) {
    let units = &settings.units;
    let upper = gear.to_string().to_ascii_uppercase();
    let speeds: Vec<f64> = table.speed_mps().breaks().iter().map(|v| units.speed(*v)).collect();
    let accels = table.accel_mps2().breaks();
    let mut axes = String::new();
    // X first
    for (quantity, breaks) in [(accel, accels), (speed, speeds.as_slice())] {
        let (axis, count, limits) = (format!("{}_{upper}", quantity.compu_method), breaks.len(), limits(breaks));
        let _ = write!(
            text,
            "\n    /begin AXIS_PTS {axis} \"Breaks of the map of {gear} gear\" 0x0 NO_INPUT_QUANTITY PIVOT_MAP_AXIS 0 {} {count} {limits}\n      \
             SYMBOL_LINK \"{gear}_{}\" 0\n    /end AXIS_PTS\n",
            quantity.compu_method, quantity.symbol
        );
        let _ = write!(
            axes,
            "      /begin AXIS_DESCR COM_AXIS NO_INPUT_QUANTITY {} {count} {limits}\n        AXIS_PTS_REF {axis}\n      /end AXIS_DESCR\n",
            quantity.compu_method
        );
    }
    let values: Vec<f64> = table.values().iter().map(|t| units.torque(*t)).collect();
    let _ = write!(
        text,
        "\n    /begin CHARACTERISTIC {} \"{}\" MAP 0x0 PIVOT_MAP_VALUES 0 {} {}\n{axes}      SYMBOL_LINK \"{gear}_{}\" 0\n    /end CHARACTERISTIC\n",
        name(gear),
        what(gear),
        torque.compu_method,
        limits(&values),
        torque.symbol
    );
}

/// Least and largest of the numbers.
fn limits(numbers: &[f64]) -> String {
    let least = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{} {}", plain(least), plain(largest))
}
