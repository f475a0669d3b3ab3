//! The comparison itself.

use crate::diff::sheet::{DiffSide, Sheet, Table};
use crate::diff::significance::{threshold, two_sided_p};
use crate::map::{Gear, WheelAngle};
use serde::Serialize;

/// Lengths of a vehicle that differ by less, as a share, are the same one.
const SAME_LENGTH: f64 = 1e-3;
/// Least standard error of a difference, in the values' unit: files hold six decimals, so that less is rounding.
const LEAST_STD_ERR: f64 = 1e-6;

/// How a comparison judges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DiffSettings {
    /// Expected share of false ones among the cells called significant; the probability of finding anything when nothing changed.
    /// Default 0.05.
    pub false_discovery_rate: f64,
    /// A significant change matters when it is worth more than this acceleration [m/s²]. Default 0.15: what the speed loop removes with a
    /// speed error of 0.05 m/s, the limit of the closed-loop verdict's round trip.
    pub matters_mps2: f64,
}

impl Default for DiffSettings {
    fn default() -> Self {
        Self { false_discovery_rate: 0.05, matters_mps2: 0.15 }
    }
}

/// The outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DiffVerdict {
    /// No cell differs by more than chance explains.
    Same,
    /// Cells differ by more than chance explains.
    Changed,
    /// The maps cannot be compared.
    Incompatible,
}

/// What a comparison found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapComparison {
    /// The first file.
    pub a: String,
    /// The second file.
    pub b: String,
    /// Which table was compared.
    pub table: Table,
    /// The verdict.
    pub verdict: DiffVerdict,
    /// Significant cells whose change matters.
    pub matters: usize,
    /// Why the maps are incompatible; empty otherwise.
    pub reasons: Vec<String>,
    /// What a reader should know.
    pub notes: Vec<String>,
    /// Settings, as used.
    pub settings: DiffSettings,
    /// Largest p that is significant; absent when none is.
    pub threshold_p: Option<f64>,
    /// Per gear.
    pub maps: Vec<MapDiff>,
}

/// The comparison of one gear. Changes are b − a, at the breaks of a within the range of both.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapDiff {
    /// Gear.
    pub gear: Gear,
    /// Wheel angle [°].
    pub wheel_angle_deg: f64,
    /// Whether b was interpolated at the breaks of a.
    pub interpolated: bool,
    /// Cells that were compared.
    pub compared: usize,
    /// Cells of a that were not: outside b, extrapolated or unreachable in one of them.
    pub left_out: usize,
    /// Significant cells.
    pub significant: usize,
    /// Significant cells whose change matters.
    pub matters: usize,
    /// Root mean square of the change, over the compared cells.
    pub rms_change: f64,
    /// Root mean square of z; 1 is what chance gives.
    pub rms_z: f64,
    /// The significant changes, largest |z| first.
    pub largest: Vec<Significant>,
    /// Row breaks of a.
    pub rows: Vec<f64>,
    /// Column breaks of a.
    pub columns: Vec<f64>,
    /// Change per cell; null where it was left out.
    pub change: Vec<Vec<Option<f64>>>,
    /// Standard error of the change.
    pub std_err: Vec<Vec<Option<f64>>>,
    /// Change over its standard error.
    pub z: Vec<Vec<Option<f64>>>,
}

/// A significant change.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Significant {
    /// Row break: torque [N·m] in Table 1, speed [m/s] in Table 2.
    pub row: f64,
    /// Column break: speed [m/s] in Table 1, acceleration [m/s²] in Table 2.
    pub column: f64,
    /// Value in a.
    pub a: f64,
    /// Value in b.
    pub b: f64,
    /// b − a.
    pub change: f64,
    /// Its standard error.
    pub std_err: f64,
    /// Change over standard error.
    pub z: f64,
    /// Two-sided p of z.
    pub p: f64,
    /// What the change is worth as an acceleration [m/s²]: itself in Table 1; in Table 2 over the slope of torque in acceleration.
    pub accel_mps2: f64,
}

impl MapComparison {
    /// The verdict in one sentence.
    pub fn sentence(&self) -> String {
        let (compared, significant): (usize, usize) =
            self.maps.iter().fold((0, 0), |sum, map| (sum.0 + map.compared, sum.1 + map.significant));
        match self.verdict {
            DiffVerdict::Same => format!("Same: none of {compared} cells differs by more than chance explains."),
            DiffVerdict::Changed => format!(
                "Changed: {significant} of {compared} cells differ by more than chance explains, {} of them by more than {} m/s².",
                self.matters, self.settings.matters_mps2
            ),
            DiffVerdict::Incompatible => "Incompatible: the maps cannot be compared.".to_owned(),
        }
    }
}

/// Compares `b` with `a`.
pub fn compare(a: &DiffSide, b: &DiffSide, settings: &DiffSettings) -> MapComparison {
    let reasons = differences(a, b);
    let mut comparison = MapComparison {
        a: a.name.clone(),
        b: b.name.clone(),
        table: a.table,
        verdict: DiffVerdict::Incompatible,
        matters: 0,
        reasons,
        notes: notes(a, b),
        settings: *settings,
        threshold_p: None,
        maps: Vec::new(),
    };
    if !comparison.reasons.is_empty() {
        return comparison;
    }
    let mut found: Vec<(MapDiff, Vec<Significant>)> = Vec::new();
    for sheet in &a.sheets {
        if let Some(other) = matching(sheet, &b.sheets) {
            found.push(differ(sheet, other, a.table));
        }
    }
    let p_values: Vec<f64> = found.iter().flat_map(|(_, cells)| cells.iter().map(|c| c.p)).collect();
    if p_values.is_empty() {
        comparison.reasons.push("no cell is known in both: their axes do not overlap, or what overlaps is extrapolated".to_owned());
        return comparison;
    }
    comparison.threshold_p = threshold(&p_values, settings.false_discovery_rate);
    for (mut map, cells) in found {
        let mut largest: Vec<_> = cells.into_iter().filter(|c| comparison.threshold_p.is_some_and(|t| c.p <= t)).collect();
        largest.sort_by(|x, y| y.z.abs().total_cmp(&x.z.abs()).then(x.row.total_cmp(&y.row)).then(x.column.total_cmp(&y.column)));
        map.significant = largest.len();
        map.matters = largest.iter().filter(|c| c.accel_mps2.abs() > settings.matters_mps2).count();
        map.largest = largest;
        comparison.matters += map.matters;
        comparison.maps.push(map);
    }
    comparison.verdict = if comparison.threshold_p.is_some() { DiffVerdict::Changed } else { DiffVerdict::Same };
    comparison
}

fn matching<'a>(sheet: &Sheet, others: &'a [Sheet]) -> Option<&'a Sheet> {
    others.iter().find(|o| o.gear == sheet.gear && WheelAngle::from_deg(o.wheel_angle_deg).is_same_deg(sheet.wheel_angle_deg))
}

/// Why the two cannot be compared.
fn differences(a: &DiffSide, b: &DiffSide) -> Vec<String> {
    let mut reasons = Vec::new();
    if a.table != b.table {
        reasons.push(format!("{} is {:?}, {} is {:?}", a.name, a.table, b.name, b.table));
    }
    let (va, vb) = (a.vehicle, b.vehicle);
    for (what, x, y) in [("wheelbase", va.wheelbase_m, vb.wheelbase_m), ("wheel radius", va.wheel_radius_m, vb.wheel_radius_m)] {
        if (x - y).abs() > SAME_LENGTH * x.abs() {
            reasons.push(format!("another vehicle: {what} {x} m and {y} m"));
        }
    }
    if reasons.is_empty() && !a.sheets.iter().any(|sheet| matching(sheet, &b.sheets).is_some()) {
        let maps_of = |side: &DiffSide| {
            side.sheets.iter().map(|s| format!("{} gear at {}°", s.gear, s.wheel_angle_deg)).collect::<Vec<_>>().join(", ")
        };
        reasons.push(format!("no gear and wheel angle in common: {} and {}", maps_of(a), maps_of(b)));
    }
    reasons
}

fn notes(a: &DiffSide, b: &DiffSide) -> Vec<String> {
    let mut notes = Vec::new();
    let shared = a.logs.iter().filter(|log| b.logs.iter().any(|other| other.sha256 == log.sha256)).count();
    if shared > 0 {
        notes.push(format!(
            "logs that stand behind both maps: {shared}; their errors are the same, so that the standard errors of the changes are too large"
        ));
    }
    if a.vehicle.torque_limit_nm != b.vehicle.torque_limit_nm {
        let text = |limit: Option<f64>| limit.map_or("none".to_owned(), |l| format!("{l} N·m"));
        notes.push(format!("torque limit {} and {}", text(a.vehicle.torque_limit_nm), text(b.vehicle.torque_limit_nm)));
    }
    for (side, other) in [(a, b), (b, a)] {
        for sheet in side.sheets.iter().filter(|sheet| matching(sheet, &other.sheets).is_none()) {
            notes.push(format!("{} gear at {}° is in {} only", sheet.gear, sheet.wheel_angle_deg, side.name));
        }
    }
    notes
}

/// Change per cell of `a`, and every compared cell.
fn differ(a: &Sheet, b: &Sheet, table: Table) -> (MapDiff, Vec<Significant>) {
    let width = a.columns.len();
    let empty = || vec![vec![None; width]; a.rows.len()];
    let (mut change, mut std_err, mut z, mut cells) = (empty(), empty(), empty(), Vec::new());
    for (i, &row) in a.rows.iter().enumerate() {
        for (j, &column) in a.columns.iter().enumerate() {
            let (Some((x, x_err)), Some((y, y_err))) = (a.at(row, column), b.at(row, column)) else { continue };
            let delta = y - x;
            let error = x_err.hypot(y_err).max(LEAST_STD_ERR);
            let score = delta / error;
            (change[i][j], std_err[i][j], z[i][j]) = (Some(delta), Some(error), Some(score));
            let accel_mps2 = if table == Table::Table1 { delta } else { delta / slope(a, i, j) };
            cells.push(Significant { row, column, a: x, b: y, change: delta, std_err: error, z: score, p: two_sided_p(score), accel_mps2 });
        }
    }
    let rms = |of: fn(&Significant) -> f64| (cells.iter().map(|c| of(c).powi(2)).sum::<f64>() / (cells.len().max(1) as f64)).sqrt();
    let map = MapDiff {
        gear: a.gear,
        wheel_angle_deg: a.wheel_angle_deg,
        interpolated: a.rows != b.rows || a.columns != b.columns,
        compared: cells.len(),
        left_out: a.values.len() - cells.len(),
        significant: 0,
        matters: 0,
        rms_change: rms(|c| c.change),
        rms_z: rms(|c| c.z),
        largest: Vec::new(),
        rows: a.rows.clone(),
        columns: a.columns.clone(),
        change,
        std_err,
        z,
    };
    (map, cells)
}

/// Torque per acceleration around cell (i, j) of a Table 2, from its neighbours; infinite on a plateau, where a change of torque has no
/// acceleration to be worth.
fn slope(sheet: &Sheet, i: usize, j: usize) -> f64 {
    let (low, high) = (j.saturating_sub(1), (j + 1).min(sheet.columns.len() - 1));
    let value = |k: usize| sheet.values[i * sheet.columns.len() + k];
    let slope = (value(high) - value(low)) / (sheet.columns[high] - sheet.columns[low]);
    if slope > 0.0 { slope } else { f64::INFINITY }
}
