//! Judges a map: ours, or one of another system. The check does not stop at the first flaw; it reports every broken rule with its place.
//!
//! In: a file. Out: a [`CheckReport`] of findings. The format follows from the content: JSON by its `format` field; a corner cell
//! `rows\columns` is one of our CSVs; `KENNFELD`, `<MSRSW`, `static const` and `static FORWARD: Table` are DCM, CDFX, C and Rust;
//! `calibration {` is Apollo's text; a header that names speed, acceleration and a command is long-form
//! CSV; any other CSV is an Autoware map. Coast sign, dead band and hashes are rules of our own maps; on foreign ones they are notes.

pub(crate) mod campaign_checks;
pub(crate) mod change_checks;
mod finding;
mod foreign_rules;
mod grid_rules;
mod loss_check;
mod own;
mod point_rules;
mod tool_rules;

pub use finding::{CheckReport, Count, Rule, RuleBreach, Severity};

use crate::import::MapFormat;
use crate::import::foreign::{cells_of_csv, says_long_form};
use crate::map::{Error, Result, read_whole};
use crate::text::shown;
use std::path::Path;

/// Settings of a check.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckSettings {
    /// A step is a jump when its slope is more than this many times the slope that bounds nine in ten steps along the same axis. Default
    /// 10: the steepest correct step in the published Autoware maps is 4 times that slope, and one wrong cell of a finely stepped map is
    /// far above it.
    pub slope_bound: f64,
}

impl Default for CheckSettings {
    fn default() -> Self {
        Self { slope_bound: 10.0 }
    }
}

/// Judges the map in `path`. Files beside it are read if it refers to them.
///
/// # Errors
/// The file cannot be opened or read at all. Faults in its content are findings.
pub fn check(path: &Path, settings: CheckSettings) -> Result<CheckReport> {
    let bytes = read_whole(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    let name = path.file_name().map(shown).unwrap_or_default();
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    let beside = |name: &str| read_whole(&folder.join(name)).ok();
    Ok(Map { path: shown(path), name, bytes: &bytes, beside: &beside }.report(settings))
}

/// A map and its surroundings.
struct Map<'a> {
    path: String,
    name: String,
    bytes: &'a [u8],
    /// Contents of the file of that name in the same folder.
    beside: &'a dyn Fn(&str) -> Option<Vec<u8>>,
}

impl Map<'_> {
    fn report(&self, settings: CheckSettings) -> CheckReport {
        let Ok(text) = std::str::from_utf8(self.bytes) else {
            let finding = RuleBreach::whole(Rule::Readable, Severity::Error, "the file is not text (UTF-8)");
            return CheckReport::new(self.path.clone(), "unknown", String::new(), vec![finding], &[]);
        };
        let extension = Path::new(&self.name).extension().map(std::ffi::OsStr::to_ascii_lowercase).unwrap_or_default();
        if text.trim_start().starts_with('{') || extension == "json" {
            return self.own_json(text, settings);
        }
        let format = MapFormat::of(&self.name, text);
        if matches!(format, MapFormat::Dcm | MapFormat::Cdfx | MapFormat::C | MapFormat::Rust) {
            return self.tool_file(format, text, settings);
        }
        let words = || text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        if extension == "txt" || extension == "pb" || (text.contains('{') && words().any(|w| w == "calibration")) {
            return self.apollo(text);
        }
        let cells = cells_of_csv(text);
        let corner = cells.first().and_then(|line| line.texts.first()).map_or("", String::as_str);
        if corner.contains('\\') || self.name.starts_with("table1") || self.name.starts_with("table2") {
            return self.own_csv(&cells, corner, settings);
        }
        match cells.first() {
            Some(header) if says_long_form(header) => self.long_form(&cells),
            _ => self.autoware(&cells, settings),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of_text(name: &str, bytes: &[u8]) -> CheckReport {
        let beside = |_: &str| None;
        Map { path: name.to_owned(), name: name.to_owned(), bytes, beside: &beside }.report(CheckSettings::default())
    }

    /// Pieces of all formats, whole and broken.
    fn piece() -> impl Strategy<Value = String> {
        let fixed = [
            "torque_nm\\speed_mps",
            "speed_mps\\accel_mps2",
            "calibration",
            "{",
            "}",
            ":",
            "speed",
            "acceleration",
            "command",
            ",",
            "\n",
            "0",
            "-1",
            "1e400",
            "nan",
            "default",
            "\"maps\"",
            "\"format\":\"pivot-cal/table1\"",
            "\"format_version\":1",
            "[",
            "]",
            "null",
            "\u{feff}",
            "KENNFELD M 2 2",
            "ST/X",
            "ST/Y",
            "WERT",
            "END",
            "<MSRSW>",
            "<SW-INSTANCE>",
            "</SW-INSTANCE>",
            "static const double forward_speed_mps[2] = {",
            "static FORWARD: Table = Table {",
            "Numbers { numbers: &[",
        ];
        prop_oneof![prop::sample::select(fixed.to_vec()).prop_map(str::to_owned), any::<i8>().prop_map(|v| v.to_string()), ".{0,3}"]
    }

    proptest! {
        #[test]
        fn no_text_panics_and_every_report_is_consistent(pieces in prop::collection::vec(piece(), 0..60)) {
            for name in ["a.csv", "table2.csv", "a.json", "a.pb.txt"] {
                let report = of_text(name, pieces.concat().as_bytes());
                let counted: usize = report.counts.iter().map(|c| c.findings).sum();
                prop_assert_eq!(counted, report.findings.len());
                prop_assert_eq!(report.sound, report.findings.iter().all(|f| f.severity == Severity::Note));
            }
        }
    }

    #[test]
    fn a_spreadsheets_decimal_commas_are_read() {
        let text = "speed_mps\\accel_mps2;-0,1;0;0,1\n0;-1,25;0,5;2,125\n0,1;-1,5;0,75;2,5\n";
        let plain = "speed_mps\\accel_mps2,-0.1,0,0.1\n0,-1.25,0.5,2.125\n0.1,-1.5,0.75,2.5\n";
        assert_eq!(of_text("table2.csv", text.as_bytes()).findings, of_text("table2.csv", plain.as_bytes()).findings);
    }

    #[test]
    fn a_json_of_any_shape_is_judged() {
        for maps in [
            "{}",
            "[null]",
            "[{}]",
            "[{\"gear\": 3, \"torque_nm\": [[1]], \"accel_mps2\": 4, \"csv\": []}]",
            "[{\"speed_mps\": [0, 1], \"accel_mps2\": [0, 1], \"torque_nm\": [[1, 2, 3], [4]]}]",
        ] {
            for table in ["table1", "table2"] {
                let text = format!("{{\"format\": \"pivot-cal/{table}\", \"format_version\": 1, \"maps\": {maps}}}");
                assert!(!of_text("a.json", text.as_bytes()).sound, "{text}");
            }
        }
    }
}
