//! One header and one source in C99: const tables, look-up with the library's policy, checksum, provenance.

use crate::export::crc::crc32;
use crate::export::dcm::constants;
use crate::export::file::File;
use crate::export::number::plain;
use crate::export::{MapSource, Precision, provenance};
use crate::map::{Gear, TorqueTable, sha256_hex};
use std::fmt::Write as _;

const HEADER: &str = include_str!("template/pivot_map.h.in");
const SOURCE: &str = include_str!("template/pivot_map.c.in");

/// Numbers on a line.
const PER_LINE: usize = 8;

pub(crate) fn files(source: &MapSource, precision: Precision) -> Vec<File> {
    let provenance: Vec<_> = provenance::lines(source).iter().map(|line| format!(" * {line}")).collect();
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
            .replace("@BITS@", if precision == Precision::Double { "64" } else { "32" })
            .replace("@SHA256@", &sha256(source))
            .replace("@GENERATION@", &source.table2.generation)
            .replace("@EXPORT_ID@", &export_id(source, precision))
            .replace("@VERIFIED@", if source.proof.is_verified { "1" } else { "0" })
            .replace("@HAS_FORWARD@", has(Gear::Forward))
            .replace("@HAS_REVERSE@", has(Gear::Reverse))
            .replace("@CONSTANTS@", &constants.join("\n"))
    };
    let tables: String = source.torque.iter().map(|(gear, table)| crate::export::c::table(*gear, table, precision)).collect();
    let choice: String = source.torque.iter().map(|(gear, _)| choice(*gear)).collect();
    let body = fill(SOURCE).replace("@TABLES@", &tables).replace("@CHOICE@", &choice);
    vec![File::new("pivot_map.h", fill(HEADER)), File::new("pivot_map.c", body)]
}

/// SHA-256 in hexadecimal of the forward gear's CSV, or of the only gear's; [`MapSource::read`] has compared it.
pub(crate) fn sha256(source: &MapSource) -> String {
    source.torque.first().and_then(|(gear, _)| source.map(*gear)).map(|map| map.csv.sha256.clone()).unwrap_or_default()
}

/// Identifier of the export: header and source of one export have the same. The first 8 hexadecimal digits of the SHA-256 of `table2.json`, the
/// wheel angle and the precision.
fn export_id(source: &MapSource, precision: Precision) -> String {
    let what = format!("{}{}{precision:?}", source.table2_json, source.table2.vehicle.test_angle_deg);
    sha256_hex(what.as_bytes())[..8].to_uppercase()
}

fn choice(gear: Gear) -> String {
    format!("    if (gear == PIVOT_MAP_{}) {{\n        return &{gear};\n    }}\n", gear.to_string().to_ascii_uppercase())
}

fn table(gear: Gear, table: &TorqueTable, precision: Precision) -> String {
    let suffix = if precision == Precision::Double { "" } else { "f" };
    let literal = |v: &f64| format!("{}{suffix}", precision.literal(*v));
    let array = |name: &str, values: &[f64], per_line: usize| {
        let lines = values.chunks(per_line).map(|line| format!("    {}", line.iter().map(literal).collect::<Vec<_>>().join(", ")));
        format!("static const pivot_map_real {gear}_{name}[{}] = {{\n{}\n}};\n\n", values.len(), lines.collect::<Vec<_>>().join(",\n"))
    };
    let (speeds, accels) = (table.speed_mps().breaks(), table.accel_mps2().breaks());
    let mut text = array("speed_mps", speeds, PER_LINE) + &array("accel_mps2", accels, PER_LINE);
    text.push_str(&array("torque_nm", table.values(), PER_LINE.min(accels.len())));
    let _ = write!(
        text,
        "static const pivot_map_table {gear} = {{\n    {}u, {}u, {gear}_speed_mps, {gear}_accel_mps2, {gear}_torque_nm, (uint32_t)0x{:08X}u\n}};\n\n",
        speeds.len(),
        accels.len(),
        crc32(table, precision)
    );
    text
}
