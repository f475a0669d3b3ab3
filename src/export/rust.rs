//! A Rust module that needs `core` only: the same tables, look-up and checksum as the C source.

use crate::export::c::sha256;
use crate::export::crc::crc32;
use crate::export::dcm::constants;
use crate::export::file::File;
use crate::export::number::plain;
use crate::export::{MapSource, Precision, provenance};
use crate::map::{Gear, TorqueTable};

const MODULE: &str = include_str!("template/pivot_map.rs.in");

/// Numbers on a line.
const PER_LINE: usize = 8;

pub(crate) fn file(source: &MapSource, precision: Precision) -> File {
    let provenance: Vec<_> = provenance::lines(source).iter().map(|line| format!("//! {line}\n//!")).collect();
    let constants: Vec<_> = constants(source)
        .iter()
        .map(|c| {
            let name = c.name.trim_start_matches("PIVOT_MAP_");
            format!("/// {} [{}].\npub const {name}_{}: Real = {};", c.what, c.unit, c.unit.to_ascii_uppercase(), plain(c.value))
        })
        .collect();
    let tables: String = source.torque.iter().map(|(gear, table)| crate::export::rust::table(*gear, table, precision)).collect();
    let choice = Gear::ALL.map(|gear| {
        let found = source.torque.iter().any(|(g, _)| *g == gear);
        let found = if found { format!("Some(&{})", upper(gear)) } else { "None".to_owned() };
        format!("        Gear::{gear:?} => {found},\n")
    });
    let text = MODULE
        .replace("@PROVENANCE@", &provenance.join("\n"))
        .replace("@REAL@", if precision == Precision::Double { "f64" } else { "f32" })
        .replace("@SHA256@", &sha256(source))
        .replace("@GENERATION@", &source.table2.generation)
        .replace("@VERIFIED@", if source.proof.is_verified { "true" } else { "false" })
        .replace("@CONSTANTS@", &constants.join("\n"))
        .replace("@TABLES@", &tables)
        .replace("@CHOICE@", &choice.concat());
    // two empty comment lines in a row are one
    File::new("pivot_map.rs", text.replace("//!\n//!\n", "//!\n"))
}

fn upper(gear: Gear) -> String {
    gear.to_string().to_ascii_uppercase()
}

fn table(gear: Gear, table: &TorqueTable, precision: Precision) -> String {
    let array = |values: &[f64]| {
        let lines = values.chunks(PER_LINE).map(|line| line.iter().map(|v| precision.literal(*v)).collect::<Vec<_>>().join(", "));
        format!("&[\n        {},\n    ]", lines.collect::<Vec<_>>().join(",\n        "))
    };
    format!(
        "#[rustfmt::skip]\nstatic {}: Table = Table {{\n    speed_mps: {},\n    accel_mps2: {},\n    torque_nm: {},\n    crc32: 0x{:08X},\n}};\n\n",
        upper(gear),
        array(table.speed_mps().breaks()),
        array(table.accel_mps2().breaks()),
        array(table.values()),
        crc32(table, precision)
    )
}
