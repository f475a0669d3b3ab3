//! A Rust module that needs `core` only: the same tables, look-up and checksum as the C source.

use crate::export::c::sha256;
use crate::export::dcm::constants;
use crate::export::file::File;
use crate::export::number::plain;
use crate::export::stored::{StoredNumbers, StoredTable};
use crate::export::{ExportSettings, MapSource, Precision, Result, provenance};
use crate::map::Gear;

const MODULE: &str = include_str!("template/pivot_map.rs.in");

/// Value of a count.
const SCALED: &str = "self.numbers.get(k).map(|count| self.scale * Real::from(*count) + self.offset)";

/// Numbers on a line.
const PER_LINE: usize = 8;

pub(crate) fn file(source: &MapSource, settings: &ExportSettings) -> Result<File> {
    let precision = settings.precision;
    let stored: Result<Vec<_>> =
        source.torque.iter().map(|(gear, table)| Ok((*gear, StoredTable::new(source, table, settings)?))).collect();
    let stored = stored?;
    let bytes: usize = stored.iter().map(|(_, table)| table.bytes()).sum();
    let real = if precision == Precision::Double { "f64" } else { "f32" };
    let provenance: Vec<_> =
        provenance::lines(source).into_iter().chain(settings.units.line()).map(|line| format!("//! {line}\n//!")).collect();
    let constants: Vec<_> = constants(source)
        .iter()
        .map(|c| {
            let name = c.name.trim_start_matches("PIVOT_MAP_");
            format!("/// {} [{}].\npub const {name}_{}: Real = {};", c.what, c.unit, c.unit.to_ascii_uppercase(), plain(c.value))
        })
        .collect();
    let tables: String = stored.iter().map(|(gear, table)| crate::export::rust::table(*gear, table, precision)).collect();
    let choice = Gear::ALL.map(|gear| {
        let found = source.torque.iter().any(|(g, _)| *g == gear);
        let found = if found { format!("Some(&{})", upper(gear)) } else { "None".to_owned() };
        format!("        Gear::{gear:?} => {found},\n")
    });
    let text = MODULE
        .replace("@PROVENANCE@", &provenance.join("\n"))
        .replace("@REAL@", real)
        .replace("@STORED@", if settings.int16 { "i16" } else { real })
        .replace("@SCALE_FIELDS@", if settings.int16 { "    scale: Real,\n    offset: Real,\n" } else { "" })
        .replace("@VALUE@", if settings.int16 { SCALED } else { "self.numbers.get(k).copied()" })
        .replace("@TO_BYTES@", if settings.int16 { "to_le_bytes()" } else { "to_bits().to_le_bytes()" })
        .replace("@TABLE_BYTES@", &bytes.to_string())
        .replace("@SHA256@", &sha256(source))
        .replace("@GENERATION@", &source.table2.generation)
        .replace("@VERIFIED@", if source.proof.is_verified { "true" } else { "false" })
        .replace("@CONSTANTS@", &constants.join("\n"))
        .replace("@TABLES@", &tables)
        .replace("@CHOICE@", &choice.concat());
    // two empty comment lines in a row are one
    let text = settings.units.in_code(&text.replace("//!\n//!\n", "//!\n"));
    Ok(File { note: Some(format!("{bytes} bytes of tables")), ..File::new("pivot_map.rs", text) })
}

fn upper(gear: Gear) -> String {
    gear.to_string().to_ascii_uppercase()
}

fn table(gear: Gear, table: &StoredTable, precision: Precision) -> String {
    let axis = |numbers: &StoredNumbers| {
        let lines = numbers.literals.chunks(PER_LINE).map(|line| line.join(", "));
        let unit = numbers.unit.map_or(String::new(), |(scale, offset)| {
            format!(", scale: {}, offset: {}", precision.literal(scale), precision.literal(offset))
        });
        format!("Numbers {{ numbers: &[\n        {},\n    ]{unit} }}", lines.collect::<Vec<_>>().join(",\n        "))
    };
    format!(
        "#[rustfmt::skip]\nstatic {}: Table = Table {{\n    speed_mps: {},\n    accel_mps2: {},\n    torque_nm: {},\n    crc32: 0x{:08X},\n}};\n\n",
        upper(gear),
        axis(&table.speed),
        axis(&table.accel),
        axis(&table.torque),
        table.crc32
    )
}
