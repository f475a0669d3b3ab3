//! `lateral_table.json`: the mean lateral error that a compensation angle adds, with everything that is not in its CSV.

use crate::map::decimal;
use crate::map::files::format::{LATERAL_TABLE_FORMAT, parse_file};
use crate::map::{CsvRef, Error, LogRef, Result, Vehicle};
use serde::{Deserialize, Serialize};

/// `lateral_table.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LateralTableFile {
    /// Always `pivot-cal/lateral-table`.
    pub format: String,
    /// Version of this layout.
    pub format_version: u32,
    /// Version of the program that wrote the file.
    pub tool_version: String,
    /// The vehicle.
    pub vehicle: Vehicle,
    /// The logs, base first, then by angle.
    pub logs: Vec<LogRef>,
    /// The CSV with the entries.
    pub csv: CsvRef,
    /// Settings of the fit, as used.
    pub settings: serde_json::Value,
    /// The run without compensation.
    pub base: LateralMean,
    /// The entries, by error ascending; that of the base, 0 at 0, is among them.
    pub entries: Vec<LateralEntry>,
    /// Entries that were dropped, with the reason.
    pub dropped: Vec<LateralEntry>,
    /// The fitted monotone curve: a monotone cubic goes through its points.
    pub curve: LateralCurve,
}

/// A mean with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LateralMean {
    /// Mean lateral error [m].
    pub mean_error_m: f64,
    /// Its standard error [m], autocorrelation accounted for.
    pub std_err_m: f64,
    /// Way over which it was taken [m].
    pub way_m: f64,
}

/// One compensation angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LateralEntry {
    /// Compensation angle [rad], left positive.
    pub angle_rad: f64,
    /// Mean lateral error that it adds [m]: that of its run minus that of the base.
    pub error_m: f64,
    /// Standard error of that difference [m].
    pub std_err_m: f64,
    /// Way over which both were compared [m].
    pub way_m: f64,
    /// File name of the log.
    pub log: String,
    /// Why it was dropped; empty if it was not.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reason: String,
}

/// Points of the fitted curve, angle over error.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LateralCurve {
    /// Mean lateral error [m], strictly ascending.
    pub error_m: Vec<f64>,
    /// Angle [rad], monotone.
    pub angle_rad: Vec<f64>,
}

impl LateralTableFile {
    /// Reads the JSON text.
    ///
    /// # Errors
    /// Not JSON, another format, an unknown version, a missing field, or a curve that is not monotone.
    pub fn from_json(text: &str) -> Result<Self> {
        let file: Self = parse_file(text, LATERAL_TABLE_FORMAT)?;
        file.vehicle.checked()?;
        file.curve.check()?;
        if let Some((index, entry)) = file.entries.iter().enumerate().find(|(_, e)| !(e.angle_rad.is_finite() && e.error_m.is_finite())) {
            return Err(Error::Curve { field: "entry", index, value: entry.error_m, allowed: "finite numbers" });
        }
        Ok(file)
    }

    /// The JSON text, with a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_json(&self) -> Result<String> {
        crate::map::files::json_text::to_text(self)
    }

    /// The CSV text: one line per entry.
    pub fn to_csv(&self) -> String {
        let line = |e: &LateralEntry| format!("{},{},{}\n", decimal(e.error_m), decimal(e.angle_rad), decimal(e.std_err_m));
        let header = "mean_lateral_error_m,compensation_angle_rad,std_err_m\n".to_owned();
        self.entries.iter().map(line).fold(header, |text, line| text + &line)
    }
}

impl LateralCurve {
    /// Checks shape, order and monotony.
    ///
    /// # Errors
    /// The first place that breaks them.
    pub fn check(&self) -> Result<()> {
        let bad = |field, index, value, allowed| Err(Error::Curve { field, index, value, allowed });
        let (e, a) = (&self.error_m, &self.angle_rad);
        if e.len() != a.len() || e.len() < 2 {
            return bad("number of angles", a.len(), a.len() as f64, "as many as errors, at least 2");
        }
        if let Some(k) = (0..e.len()).find(|&k| !(e[k].is_finite() && a[k].is_finite())) {
            return bad("point", k, e[k], "finite numbers");
        }
        let way = a[a.len() - 1] - a[0];
        for k in 1..e.len() {
            if e[k] <= e[k - 1] {
                return bad("error_m", k, e[k], "strictly ascending");
            }
            if (a[k] - a[k - 1]) * way < 0.0 {
                return bad("angle_rad", k, a[k], "monotone");
            }
        }
        Ok(())
    }
}
