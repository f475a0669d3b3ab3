//! The lateral compensation: its table and its run-time law as C99 and Rust.
//!
//! Slopes of the monotone cubic are exported with the points, so that the generated code has the library's own numbers.

use crate::control::Accumulation;
use crate::export::file::File;
use crate::export::lateral_source::LateralSource;
use crate::export::number::plain;
use crate::export::{MapSource, Precision, provenance};

const HEADER: &str = include_str!("template/lateral_compensation.h.in");
const SOURCE: &str = include_str!("template/lateral_compensation.c.in");
const MODULE: &str = include_str!("template/lateral_compensation.rs.in");

/// A template with the law's numbers.
fn filled(law: &LateralSource, template: &str, provenance: &str, precision: Precision, rust: bool) -> String {
    let suffix = if rust || precision == Precision::Double { "" } else { "f" };
    let (open, close) = if rust { ("[", "]") } else { ("{", "}") };
    let row = |row: &[f64]| {
        let numbers: Vec<String> = row.iter().map(|v| format!("{}{suffix}", precision.literal(*v))).collect();
        format!("    {open}{}{close},", numbers.join(", "))
    };
    let (entries, points) = (law.table.entries(), law.points());
    let entry_rows: Vec<String> = entries.iter().map(|e| row(&[e.error_m, e.angle_rad])).collect();
    let point_rows: Vec<String> = points.iter().map(|p| row(p)).collect();
    let numbers = entries.iter().flat_map(|e| [e.error_m, e.angle_rad]).chain(points.iter().flatten().copied());
    let bytes: Vec<u8> = numbers.flat_map(|v| precision.bytes(v)).collect();
    let constants: Vec<String> = law
        .constants()
        .iter()
        .map(|c| {
            let unit = suffix_of(c.unit);
            if rust {
                let name = c.name.trim_start_matches("LATERAL_COMPENSATION_");
                format!("/// {} [{}].\npub const {name}_{unit}: Real = {};", c.what, c.unit, plain(c.value))
            } else {
                format!("#define {}_{unit} ((lateral_real)({})) /* {} */", c.name, plain(c.value), c.what)
            }
        })
        .collect();
    let real = match (rust, precision) {
        (true, Precision::Double) => "f64",
        (true, Precision::Float) => "f32",
        (false, Precision::Double) => "double",
        (false, Precision::Float) => "float",
    };
    let threshold_unit = if matches!(law.settings.accumulation, Accumulation::Periods(_)) { "1" } else { "M" };
    template
        .replace("@PROVENANCE@", provenance)
        .replace("@REAL@", real)
        .replace("@BITS@", if precision == Precision::Double { "64" } else { "32" })
        .replace("@SHA256@", &law.file.csv.sha256)
        .replace("@CONSTANTS@", &constants.join("\n"))
        .replace("@ENTRIES@", &entries.len().to_string())
        .replace("@POINTS@", &points.len().to_string())
        .replace("@ENTRY_ROWS@", &entry_rows.join("\n"))
        .replace("@POINT_ROWS@", &point_rows.join("\n"))
        .replace("@THRESHOLD_UNIT@", threshold_unit)
        .replace("@CRC32@", &format!("{:08X}", crc32fast::hash(&bytes)))
}

/// A unit as the end of a name.
fn suffix_of(unit: &str) -> String {
    match unit {
        "1/m" => "PER_M".to_owned(),
        "rad/s" => "RAD_S".to_owned(),
        unit => unit.to_ascii_uppercase(),
    }
}

/// The law as C; none without a lateral table.
pub(crate) fn c_files(source: &MapSource, precision: Precision) -> Vec<File> {
    let Some(law) = &source.lateral else { return Vec::new() };
    let lines: Vec<String> = provenance::lateral_lines(&law.file, &source.proof).iter().map(|line| format!(" * {line}")).collect();
    let of = |template| filled(law, template, &lines.join("\n"), precision, false);
    vec![File::new("lateral_compensation.h", of(HEADER)), File::new("lateral_compensation.c", of(SOURCE))]
}

/// The law as a Rust module; none without a lateral table.
pub(crate) fn rust_files(source: &MapSource, precision: Precision) -> Vec<File> {
    let Some(law) = &source.lateral else { return Vec::new() };
    let lines: Vec<String> = provenance::lateral_lines(&law.file, &source.proof).iter().map(|line| format!("//! {line}\n//!")).collect();
    let text = filled(law, MODULE, &lines.join("\n"), precision, true);
    vec![File::new("lateral_compensation.rs", text.replace("//!\n//!\n", "//!\n"))]
}
