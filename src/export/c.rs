//! One header and one source in C99: const tables, look-up with the library's policy, checksum, provenance.

use crate::export::dcm::constants;
use crate::export::file::File;
use crate::export::number::plain;
use crate::export::stored::{StoredNumbers, StoredTable};
use crate::export::{ExportSettings, MapSource, Precision, Result, provenance};
use crate::map::{Gear, sha256_hex};
use std::fmt::Write as _;

const HEADER: &str = include_str!("template/pivot_map.h.in");
const SOURCE: &str = include_str!("template/pivot_map.c.in");

/// Fields of an axis that is stored in counts, and the value of a count.
const SCALE_FIELDS: &str = "    pivot_map_real scale;\n    pivot_map_real offset;\n";
const SCALED: &str = "axis->scale * (pivot_map_real)axis->numbers[k] + axis->offset";

/// Numbers on a line.
const PER_LINE: usize = 8;

pub(crate) fn files(source: &MapSource, settings: &ExportSettings) -> Result<Vec<File>> {
    let precision = settings.precision;
    let stored: Result<Vec<_>> =
        source.torque.iter().map(|(gear, table)| Ok((*gear, StoredTable::new(source, table, settings)?))).collect();
    let stored = stored?;
    let bytes: usize = stored.iter().map(|(_, table)| table.bytes()).sum();
    let bits = if precision == Precision::Double { "64" } else { "32" };
    let provenance: Vec<_> = provenance::lines(source).into_iter().chain(settings.units.line()).map(|line| format!(" * {line}")).collect();
    let has = |gear| if source.torque.iter().any(|(g, _)| *g == gear) { "1" } else { "0" };
    let real = if precision == Precision::Double { "double" } else { "float" };
    let constants: Vec<_> = constants(source)
        .iter()
        .map(|c| format!("#define {}_{} ((pivot_map_real)({})) /* {} */", c.name, c.unit.to_ascii_uppercase(), plain(c.value), c.what))
        .collect();
    let fill = |template: &str| {
        template
            .replace("@PROVENANCE@", &provenance.join("\n"))
            .replace("@REAL@", real)
            .replace("@BITS@", bits)
            .replace("@STORED@", if settings.int16 { "int16_t" } else { "pivot_map_real" })
            .replace("@STORED_BITS@", if settings.int16 { "16" } else { bits })
            .replace("@SCALE_FIELDS@", if settings.int16 { SCALE_FIELDS } else { "" })
            .replace("@VALUE@", if settings.int16 { SCALED } else { "axis->numbers[k]" })
            .replace("@TABLE_BYTES@", &bytes.to_string())
            .replace("@SHA256@", &sha256(source))
            .replace("@GENERATION@", &source.table2.generation)
            .replace("@EXPORT_ID@", &export_id(source, settings))
            .replace("@VERIFIED@", if source.proof.is_verified { "1" } else { "0" })
            .replace("@HAS_FORWARD@", has(Gear::Forward))
            .replace("@HAS_REVERSE@", has(Gear::Reverse))
            .replace("@CONSTANTS@", &constants.join("\n"))
    };
    let tables: String = stored.iter().map(|(gear, table)| crate::export::c::table(*gear, table, precision)).collect();
    let choice: String = source.torque.iter().map(|(gear, _)| choice(*gear)).collect();
    let body = fill(SOURCE).replace("@TABLES@", &tables).replace("@CHOICE@", &choice);
    let note = Some(format!("{bytes} bytes of tables"));
    let of = |name: &str, text: &str| File::new(name, settings.units.in_code(text));
    Ok(vec![of("pivot_map.h", &fill(HEADER)), File { note, ..of("pivot_map.c", &body) }])
}

/// SHA-256 in hexadecimal of the forward gear's CSV, or of the only gear's; [`MapSource::read`] has compared it.
pub(crate) fn sha256(source: &MapSource) -> String {
    source.torque.first().and_then(|(gear, _)| source.map(*gear)).map(|map| map.csv.sha256.clone()).unwrap_or_default()
}

/// Identifier of the export: header and source of one export have the same. The first 8 hexadecimal digits of the SHA-256 of `table2.json`, the
/// wheel angle and the settings.
fn export_id(source: &MapSource, settings: &ExportSettings) -> String {
    let what = format!("{}{}{settings:?}", source.table2_json, source.table2.vehicle.test_angle_deg);
    sha256_hex(what.as_bytes())[..8].to_uppercase()
}

fn choice(gear: Gear) -> String {
    format!("    if (gear == PIVOT_MAP_{}) {{\n        return &{gear};\n    }}\n", gear.to_string().to_ascii_uppercase())
}

fn table(gear: Gear, table: &StoredTable, precision: Precision) -> String {
    let suffix = if precision == Precision::Double { "" } else { "f" };
    let of_type = |numbers: &StoredNumbers| if numbers.unit.is_some() { "" } else { suffix };
    let array = |name: &str, numbers: &StoredNumbers, per_line: usize| {
        let literal = |text: &String| format!("{text}{}", of_type(numbers));
        let lines =
            numbers.literals.chunks(per_line).map(|line| format!("    {}", line.iter().map(literal).collect::<Vec<_>>().join(", ")));
        let count = numbers.literals.len();
        format!("static const pivot_map_stored {gear}_{name}[{count}] = {{\n{}\n}};\n\n", lines.collect::<Vec<_>>().join(",\n"))
    };
    let axis = |name: &str, numbers: &StoredNumbers| {
        let unit = numbers.unit.map_or(String::new(), |(scale, offset)| {
            format!(", {}{suffix}, {}{suffix}", precision.literal(scale), precision.literal(offset))
        });
        format!("    {{{gear}_{name}, {}u{unit}}},\n", numbers.literals.len())
    };
    let parts = [("speed_mps", &table.speed), ("accel_mps2", &table.accel), ("torque_nm", &table.torque)];
    let per_row = PER_LINE.min(table.accel.literals.len());
    let mut text: String =
        parts.iter().zip([PER_LINE, PER_LINE, per_row]).map(|((name, numbers), per_line)| array(name, numbers, per_line)).collect();
    let axes: String = parts.iter().map(|(name, numbers)| axis(name, numbers)).collect();
    let _ = write!(text, "static const pivot_map_table {gear} = {{\n{axes}    (uint32_t)0x{:08X}u\n}};\n\n", table.crc32);
    text
}
