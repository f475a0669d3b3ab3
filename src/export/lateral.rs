//! The lateral compensation: its table and its run-time law as C99 and Rust, its table and settings as DCM and CDFX.
//!
//! Slopes of the monotone cubic are exported with the points, so that the generated code has the library's own numbers.

use crate::control::{Accumulation, CompensationEntry, CompensationSettings, CompensationTable};
use crate::export::dcm::Constant;
use crate::export::file::File;
use crate::export::number::plain;
use crate::export::{MapSource, Precision, provenance};
use crate::map::LateralTableFile;

const HEADER: &str = include_str!("template/lateral_compensation.h.in");
const SOURCE: &str = include_str!("template/lateral_compensation.c.in");
const MODULE: &str = include_str!("template/lateral_compensation.rs.in");

/// The law to export.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LateralSource {
    /// The `lateral_table.json`.
    pub(crate) file: LateralTableFile,
    /// Settings of the run-time law.
    pub(crate) settings: CompensationSettings,
    /// The table as the law reads it.
    pub(crate) table: CompensationTable,
}

impl LateralSource {
    /// The law of a table with the default settings.
    ///
    /// # Errors
    /// A table that the law cannot read.
    pub(crate) fn new(file: LateralTableFile) -> Result<Self, crate::control::Error> {
        let entry = |error_m: f64, angle_rad: f64| CompensationEntry { error_m, angle_rad };
        let entries: Vec<_> = file.entries.iter().map(|e| entry(e.error_m, e.angle_rad)).collect();
        let points: Vec<_> = file.curve.error_m.iter().zip(&file.curve.angle_rad).map(|(e, a)| entry(*e, *a)).collect();
        let table = CompensationTable::new(&entries, &points)?;
        Ok(Self { file, settings: CompensationSettings::default(), table })
    }

    /// The settings of the law as numbers.
    pub(crate) fn constants(&self) -> Vec<Constant> {
        let s = &self.settings;
        let constant = |name: &str, what: &str, unit, value| Constant {
            name: format!("LATERAL_COMPENSATION_{name}"),
            what: what.to_owned(),
            unit,
            value,
        };
        let (by_periods, threshold, unit) = match s.accumulation {
            Accumulation::Distance(distance_m) => (0.0, distance_m, "m"),
            Accumulation::Periods(count) => (1.0, f64::from(count), "1"),
        };
        vec![
            constant("BY_PERIODS", "Whether the error is averaged over control periods instead of a distance", "1", by_periods),
            constant("THRESHOLD", "Distance or number of periods over which the error is averaged", unit, threshold),
            constant("EXACT", "Largest distance to an entry that is used exactly", "m", s.exact_m),
            constant("DEAD_ZONE", "Mean errors up to this are ignored", "m", s.dead_zone_m),
            constant("LIMIT", "Largest compensation in force", "rad", s.limit_rad),
            constant("RATE", "Fastest change of the added angle", "rad/s", s.rate_rad_s),
            constant("SETTLE", "Distance after a change before the accumulation begins again", "m", s.settle_m),
            constant("STRAIGHT", "Largest curvature at which the error is accumulated", "1/m", s.straight_per_m),
            constant("PLAUSIBLE", "An error beyond this is an event", "m", s.plausible_m),
            constant("PERIOD", "Control period", "s", s.period_s),
        ]
    }

    /// Error [m], angle [rad] and slope [rad/m] of each point of the curve.
    fn points(&self) -> Vec<[f64; 3]> {
        self.table.points().iter().zip(self.table.slopes()).map(|(p, slope)| [p.error_m, p.angle_rad, *slope]).collect()
    }

    fn filled(&self, template: &str, provenance: &str, precision: Precision, rust: bool) -> String {
        let suffix = if rust || precision == Precision::Double { "" } else { "f" };
        let (open, close) = if rust { ("[", "]") } else { ("{", "}") };
        let row = |row: &[f64]| {
            let numbers: Vec<String> = row.iter().map(|v| format!("{}{suffix}", precision.literal(*v))).collect();
            format!("    {open}{}{close},", numbers.join(", "))
        };
        let (entries, points) = (self.table.entries(), self.points());
        let entry_rows: Vec<String> = entries.iter().map(|e| row(&[e.error_m, e.angle_rad])).collect();
        let point_rows: Vec<String> = points.iter().map(|p| row(p)).collect();
        let numbers = entries.iter().flat_map(|e| [e.error_m, e.angle_rad]).chain(points.iter().flatten().copied());
        let bytes: Vec<u8> = numbers.flat_map(|v| precision.bytes(v)).collect();
        let constants: Vec<String> = self
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
        let threshold_unit = if matches!(self.settings.accumulation, Accumulation::Periods(_)) { "1" } else { "M" };
        template
            .replace("@PROVENANCE@", provenance)
            .replace("@REAL@", real)
            .replace("@BITS@", if precision == Precision::Double { "64" } else { "32" })
            .replace("@SHA256@", &self.file.csv.sha256)
            .replace("@CONSTANTS@", &constants.join("\n"))
            .replace("@ENTRIES@", &entries.len().to_string())
            .replace("@POINTS@", &points.len().to_string())
            .replace("@ENTRY_ROWS@", &entry_rows.join("\n"))
            .replace("@POINT_ROWS@", &point_rows.join("\n"))
            .replace("@THRESHOLD_UNIT@", threshold_unit)
            .replace("@CRC32@", &format!("{:08X}", crc32fast::hash(&bytes)))
    }
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
    let lines: Vec<String> = provenance::lateral_lines(&law.file).iter().map(|line| format!(" * {line}")).collect();
    let of = |template| law.filled(template, &lines.join("\n"), precision, false);
    vec![File::new("lateral_compensation.h", of(HEADER)), File::new("lateral_compensation.c", of(SOURCE))]
}

/// The law as a Rust module; none without a lateral table.
pub(crate) fn rust_files(source: &MapSource, precision: Precision) -> Vec<File> {
    let Some(law) = &source.lateral else { return Vec::new() };
    let lines: Vec<String> = provenance::lateral_lines(&law.file).iter().map(|line| format!("//! {line}\n//!")).collect();
    let text = law.filled(MODULE, &lines.join("\n"), precision, true);
    vec![File::new("lateral_compensation.rs", text.replace("//!\n//!\n", "//!\n"))]
}
