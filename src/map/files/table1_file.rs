//! `table1.json`: Table 1 with everything that is not in its CSV.

use crate::map::files::actuator::Actuator;
use crate::map::files::check::Check;
use crate::map::files::format::{TABLE1_FORMAT, parse_file};
use crate::map::files::log_ref::LogRef;
use crate::map::files::named;
use crate::map::files::save::sha256_hex;
use crate::map::files::shape::ArrayField;
use crate::map::files::status::{SampleVerdict, SpeedSource};
use crate::map::{
    AccelMaps, AccelTable, AngleFamily, AngleSurface, Axis, CellStatus, Gear, Result, SPEED_AXIS, TORQUE_AXIS, Vehicle, WheelAngle,
};
use serde::{Deserialize, Serialize};

/// `table1.json`: one [`AccelMap`] per gear and wheel angle, and where they come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table1File {
    /// Always `pivot-cal/table1`.
    pub format: String,
    /// Version of this layout.
    pub format_version: u32,
    /// Version of the program that wrote the file.
    pub tool_version: String,
    /// Identifier of the generation: every file that is made from this Table 1 carries the same. The first 16 hexadecimal digits of the SHA-256
    /// of this file without it; empty in files of versions before it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub generation: String,
    /// Units of every number whose name does not give them.
    pub units: Units,
    /// The vehicle, from the signal map or the log.
    pub vehicle: Vehicle,
    /// Whether the vehicle's torque limit is only the largest torque driven, because none was given.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub torque_limit_driven: bool,
    /// The logs that were read, ordered by hash.
    pub logs: Vec<LogRef>,
    /// Settings of the estimator, as used.
    pub settings: serde_json::Value,
    /// Dead time and lag of the drive.
    pub actuator: Actuator,
    /// The sources of the wheel's speed and how they compare.
    pub witnesses: Vec<SpeedReading>,
    /// The random part of the plant.
    pub noise: PlantNoise,
    /// The tables.
    pub maps: Vec<AccelMap>,
    /// The common part of a gear's maps at several wheel angles; none with one angle.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub families: Vec<AngleFamily>,
    /// The checks on the campaign and the fit; absent in files of versions before them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub checks: Vec<Check>,
    /// Counts of the samples, and the runs.
    pub report: Stage1Report,
}

/// Units of a map's numbers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Units {
    /// Unit of speeds.
    pub speed: String,
    /// Unit of torques.
    pub torque: String,
    /// Unit of accelerations.
    pub accel: String,
}

impl Default for Units {
    fn default() -> Self {
        Self { speed: "m/s".into(), torque: "N.m".into(), accel: "m/s^2".into() }
    }
}

/// A CSV beside the JSON.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CsvRef {
    /// File name, in the same folder.
    pub file: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

/// One source of the front wheel's speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpeedReading {
    /// The source.
    #[serde(with = "named")]
    pub name: SpeedSource,
    /// Reading over true speed.
    pub scale: f64,
    /// Standard error of the scale; absent when the scale is 1 by definition.
    pub scale_std_err: Option<f64>,
    /// How much later it reads than the reference source [s].
    pub delay_s: f64,
    /// Standard deviation of one reading [m/s].
    pub noise_mps: f64,
}

/// The random part of the plant, for simulating it as in the logs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlantNoise {
    /// Standard deviation of the disturbance, an Ornstein-Uhlenbeck acceleration [m/s²].
    pub disturbance_mps2: f64,
    /// Its time constant [s].
    pub disturbance_time_s: f64,
    /// Standard deviation of one constant acceleration per run [m/s²].
    pub run_offset_mps2: f64,
    /// Standard deviation of a speed reading [m/s].
    pub speed_noise_mps: f64,
    /// Step of the encoder's readings [m/s], where it is coarse; 0 where noise hides it.
    #[serde(default)]
    pub speed_step_mps: f64,
}

/// Table 1 of one gear and wheel angle. Rows are torques, columns speeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AccelMap {
    /// Gear, in whose frame all numbers are.
    pub gear: Gear,
    /// Wheel angle of the test [°], left positive.
    pub wheel_angle_deg: f64,
    /// The CSV with the same numbers.
    pub csv: CsvRef,
    /// Speed breaks [m/s]; the break 0 means "just moving".
    pub speed_mps: Vec<f64>,
    /// Torque breaks [N·m].
    pub torque_nm: Vec<f64>,
    /// Acceleration [m/s²].
    pub accel_mps2: Vec<Vec<f64>>,
    /// Standard error [m/s²].
    pub std_err_mps2: Vec<Vec<f64>>,
    /// Samples nearest to the cell.
    pub count: Vec<Vec<u64>>,
    /// Confidence, 0 to 1: 1/(1 + (standard error / 0.1 m/s²)²), and at most 0.5 where nothing was measured nearby.
    pub confidence: Vec<Vec<f64>>,
    /// Source of the value.
    pub status: Vec<Vec<CellStatus>>,
    /// Per speed break the lowest and highest torque [N·m] that samples cover, or null.
    pub measured_torque_nm: Vec<Option<[f64; 2]>>,
    /// The torque that sets a resting wheel in motion.
    pub breakaway: BreakawayTorque,
    /// The surface on a finer grid, from which Table 2 is made and vehicles are simulated.
    pub surface: FineSurface,
}

/// A fine grid of the fitted surface: rows torque, columns speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FineSurface {
    /// Speed breaks [m/s].
    pub speed_mps: Vec<f64>,
    /// Torque breaks [N·m].
    pub torque_nm: Vec<f64>,
    /// Acceleration [m/s²].
    pub accel_mps2: Vec<Vec<f64>>,
}

/// The torque that sets a resting wheel in motion, in the gear's direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BreakawayTorque {
    /// Best estimate [N·m]: where the surface at v → 0⁺ crosses zero, held within the bounds below.
    pub torque_nm: f64,
    /// Standard error [N·m]; absent when only bounds are known.
    pub std_err_nm: Option<f64>,
    /// Largest held torque at which the wheel stayed at rest [N·m].
    pub at_rest_up_to_nm: Option<f64>,
    /// Smallest held torque that set the wheel in motion [N·m].
    pub moved_from_nm: Option<f64>,
}

/// Counts of the samples, and the runs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Stage1Report {
    /// Samples per verdict, over all logs.
    pub ledger: Vec<LedgerRow>,
    /// The runs, in the order of their logs and times; of a large campaign those that [`Stage1Report::listed_runs`] counts.
    pub runs: Vec<RunRow>,
    /// Counts of a campaign of which some runs are not listed; absent if all are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub listed_runs: Option<ListedRuns>,
    /// Root mean square of the one-step residual over the used samples, as acceleration [m/s²].
    pub residual_rms_mps2: f64,
    /// Cells that were measured, of those within the axes (0 to 1).
    pub coverage: f64,
    /// Iterations of the fit.
    pub iterations: u32,
    /// Notes for the reader: early stops, bounds reached, runs that disagree.
    pub notes: Vec<String>,
    /// Figures of the estimator's own choices (models compared, cross-validation), in a layout that may grow.
    #[serde(default)]
    pub diagnostics: serde_json::Value,
}

/// Counts of the runs, of which `table1.json` lists some: those with the largest residual, and evenly spaced ones.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ListedRuns {
    /// Runs that are listed.
    pub listed: usize,
    /// All runs.
    pub all: usize,
    /// Runs of which the fit used something.
    pub used: usize,
    /// Their used time [s].
    pub used_s: f64,
}

impl Stage1Report {
    /// Number of runs of which the fit used something, those that are not listed included.
    pub fn used_runs(&self) -> usize {
        self.listed_runs.map_or_else(|| self.runs.iter().filter(|run| run.used_s > 0.0).count(), |counts| counts.used)
    }

    /// Number of runs, those that are not listed included.
    pub fn all_runs(&self) -> usize {
        self.listed_runs.map_or(self.runs.len(), |counts| counts.all)
    }
}

/// One line of the ledger.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LedgerRow {
    /// Verdict on the samples.
    #[serde(with = "named")]
    pub verdict: SampleVerdict,
    /// Number of samples.
    pub samples: u64,
    /// Their time [s].
    pub seconds: f64,
}

/// One run: a stretch of held torque at the wheel angle of a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRow {
    /// File name of the log.
    pub log: String,
    /// Wheel angle of the run [°], where the file holds maps of several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wheel_angle_deg: Option<f64>,
    /// Start after the log's first sample [s].
    pub start_s: f64,
    /// Length [s].
    pub duration_s: f64,
    /// Gear.
    pub gear: Gear,
    /// Median commanded torque [N·m], gear frame.
    pub torque_nm: f64,
    /// Speed at its start [m/s], gear frame.
    pub start_speed_mps: f64,
    /// Speed at its end [m/s], gear frame.
    pub end_speed_mps: f64,
    /// Seconds that the fit used.
    pub used_s: f64,
    /// Root mean square difference of simulated and recorded speed [m/s], held out: simulated open loop from the run's start by a surface
    /// fitted without the run. Absent when the fit used nothing of the run, or had no other one.
    pub speed_rmse_mps: Option<f64>,
    /// Share of the recorded speed's variance that the same simulation explains, held out likewise.
    pub r_squared: Option<f64>,
    /// Constant acceleration by which the run differs from the surface [m/s²].
    pub offset_mps2: Option<f64>,
    /// Verdicts other than `used`, with their seconds.
    pub rejected: Vec<LedgerRow>,
}

impl Table1File {
    /// Reads the JSON text.
    ///
    /// # Errors
    /// Not JSON, another format, an unknown version, a missing or misplaced field, a text that is not allowed, an array whose size is not
    /// that of its axes, or tables that [`AccelTable::new`] refuses.
    pub fn from_json(text: &str) -> Result<Self> {
        let file: Self = parse_file(text, TABLE1_FORMAT)?;
        file.vehicle.checked()?;
        file.maps.iter().enumerate().try_for_each(|(k, map)| map.check(&format!("maps[{k}]")))?;
        file.families.iter().try_for_each(AngleFamily::check)?;
        Ok(file)
    }

    /// The JSON text, indented, with arrays of numbers on one line and a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_json(&self) -> Result<String> {
        crate::map::files::json_text::to_text(self)
    }

    /// The file with the identifier of its generation, which follows from all that is in it.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub(crate) fn with_generation(mut self) -> Result<Self> {
        self.generation.clear();
        let mut hash = sha256_hex(self.to_json()?.as_bytes());
        hash.truncate(16);
        self.generation = hash;
        Ok(self)
    }

    /// The map of a gear at a wheel angle.
    pub fn map(&self, gear: Gear, angle: WheelAngle) -> Option<&AccelMap> {
        self.maps.iter().find(|m| m.gear == gear && m.angle().is_same(angle))
    }

    /// The map of a gear at the test angle.
    pub fn map_at_test_angle(&self, gear: Gear) -> Option<&AccelMap> {
        self.map(gear, self.vehicle.test_angle())
    }

    /// Whether the maps belong to more than one wheel angle.
    pub fn has_several_angles(&self) -> bool {
        WheelAngle::several(self.maps.iter().map(|m| m.wheel_angle_deg))
    }

    /// The largest driving torque that the drive delivers at a speed [N·m]: the vehicle's limit, or that of the drive where it is lower.
    pub fn most_torque_nm(&self, speed_mps: f64) -> f64 {
        self.delivered_nm(speed_mps).min(self.torque_limit_nm())
    }

    /// The largest driving torque by the limit of the drive that the fit found [N·m]; without end where it found none.
    pub fn delivered_nm(&self, speed_mps: f64) -> f64 {
        let limit = self.actuator.drive.as_ref().and_then(|d| d.limit);
        limit.map_or(f64::INFINITY, |l| l.most_nm(speed_mps))
    }

    /// Whether a limit of the speed, if the fit found one, leaves no driving torque at a speed.
    pub fn is_governed(&self, speed_mps: f64) -> bool {
        self.actuator.drive.as_ref().and_then(|d| d.limit).is_some_and(|l| l.governs(speed_mps))
    }

    /// The vehicle's torque limit [N·m], or without one the largest torque of the tables.
    pub fn torque_limit_nm(&self) -> f64 {
        self.vehicle.torque_limit_or_largest_nm(self.maps.iter().flat_map(|m| m.torque_nm.iter().copied()))
    }
}

impl AccelMap {
    /// The wheel angle of the map.
    pub fn angle(&self) -> WheelAngle {
        WheelAngle::from_deg(self.wheel_angle_deg)
    }

    /// Every array against the axes; `place` is the map in errors.
    fn check(&self, place: &str) -> Result<()> {
        self.table()?;
        self.surface.table()?;
        let field = |name| ArrayField { map: place, name };
        let (rows, columns) = (self.torque_nm.len(), self.speed_mps.len());
        field("accel_mps2").expect_numbers(rows, columns, &self.accel_mps2)?;
        field("std_err_mps2").expect_numbers(rows, columns, &self.std_err_mps2)?;
        field("count").expect_cells(rows, columns, &self.count)?;
        field("confidence").expect_numbers(rows, columns, &self.confidence)?;
        field("status").expect_cells(rows, columns, &self.status)?;
        field("measured_torque_nm").expect_len("", columns, self.measured_torque_nm.len())?;
        field("surface.accel_mps2").expect_numbers(self.surface.torque_nm.len(), self.surface.speed_mps.len(), &self.surface.accel_mps2)?;
        field("wheel_angle_deg").expect_finite("", self.wheel_angle_deg)?;
        field("breakaway.torque_nm").expect_finite("", self.breakaway.torque_nm)
    }

    /// The table itself.
    ///
    /// # Errors
    /// As [`Axis::new`] and [`AccelTable::new`].
    pub fn table(&self) -> Result<AccelTable> {
        table_of(&self.speed_mps, &self.torque_nm, &self.accel_mps2)
    }
}

impl FineSurface {
    /// The fine grid as a table.
    ///
    /// # Errors
    /// As [`Axis::new`] and [`AccelTable::new`].
    pub fn table(&self) -> Result<AccelTable> {
        table_of(&self.speed_mps, &self.torque_nm, &self.accel_mps2)
    }
}

fn table_of(speed: &[f64], torque: &[f64], accel: &[Vec<f64>]) -> Result<AccelTable> {
    AccelTable::new(Axis::new(SPEED_AXIS, speed.to_vec())?, Axis::new(TORQUE_AXIS, torque.to_vec())?, accel.concat())
}

impl AccelMaps {
    /// From the maps of a `table1.json` and its families.
    ///
    /// # Errors
    /// As [`Axis::new`] and [`AccelTable::new`].
    pub fn new<'a>(maps: impl IntoIterator<Item = &'a AccelMap>, families: &[AngleFamily]) -> Result<Self> {
        let one = |map: &AccelMap| {
            Ok(AngleSurface {
                gear: map.gear,
                wheel_angle_deg: map.wheel_angle_deg,
                surface: map.surface.table()?,
                std_err: table_of(&map.speed_mps, &map.torque_nm, &map.std_err_mps2)?,
            })
        };
        Ok(Self::from_surfaces(maps.into_iter().map(one).collect::<Result<_>>()?, families.to_vec()))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde_json::Value;

    fn error_after(change: impl Fn(&mut Value)) -> String {
        let mut json: Value = serde_json::from_str(include_str!("../../../maps/table1.json")).unwrap();
        change(&mut json);
        Table1File::from_json(&json.to_string()).unwrap_err().to_string()
    }

    #[test]
    fn every_array_of_a_map_must_have_the_size_of_its_axes() {
        for field in ["accel_mps2", "std_err_mps2", "count", "confidence", "status"] {
            let short_row = error_after(|json| drop(json["maps"][0][field][2].as_array_mut().unwrap().pop()));
            assert!(short_row.contains(&format!("maps[0].{field}[2] has ")) || field == "accel_mps2", "{short_row}");
            let missing_row = error_after(|json| drop(json["maps"][1][field].as_array_mut().unwrap().pop()));
            assert!(missing_row.contains(&format!("maps[1].{field} has ")) || field == "accel_mps2", "{missing_row}");
        }
        let error = error_after(|json| drop(json["maps"][0]["measured_torque_nm"].as_array_mut().unwrap().pop()));
        assert!(error.starts_with("maps[0].measured_torque_nm has "), "{error}");
    }

    #[test]
    fn a_cell_that_slipped_into_the_next_row_is_found() {
        let error = error_after(|json| {
            let rows = json["maps"][0]["accel_mps2"].as_array_mut().unwrap();
            let cell = rows[0].as_array_mut().unwrap().pop().unwrap();
            rows[1].as_array_mut().unwrap().insert(0, cell);
        });
        assert!(error.starts_with("maps[0].accel_mps2[0] has "), "{error}");
    }

    #[test]
    fn a_status_that_does_not_exist_is_refused_with_its_field() {
        let error = error_after(|json| json["actuator"]["lag"]["status"] = "at bound".into());
        assert!(error.contains("status is \"at bound\"; allowed: estimated, "), "{error}");
        let error = error_after(|json| json["actuator"]["input"] = "pedal".into());
        assert!(error.contains("input is \"pedal\"; allowed: torque command, torque feedback"), "{error}");
        let error = error_after(|json| json["report"]["ledger"][0]["verdict"] = "good".into());
        assert!(error.contains("verdict is \"good\"; allowed: used, "), "{error}");
    }

    #[test]
    fn a_file_that_is_read_and_written_keeps_its_bytes() {
        let text = include_str!("../../../maps/table1.json");
        assert!(Table1File::from_json(text).unwrap().to_json().unwrap() == text);
    }

    #[test]
    fn a_map_is_found_by_gear_and_angle() {
        let file = Table1File::from_json(include_str!("../../../maps/table1.json")).unwrap();
        let test_angle = file.vehicle.test_angle();
        for gear in Gear::ALL {
            assert_eq!(file.map_at_test_angle(gear).unwrap().gear, gear);
            assert!(file.map(gear, WheelAngle::from_deg(test_angle.deg() - 0.9)).is_some());
            assert!(file.map(gear, WheelAngle::from_deg(test_angle.deg() - 1.0)).is_none());
        }
        assert!(!file.has_several_angles());
    }
}
