//! `table1.json`: Table 1 with everything that its CSV does not tell.

use crate::map::format::{TABLE1_FORMAT, expect_format};
use crate::map::{AccelTable, AngleFamily, Axis, CellStatus, Gear, Result, Vehicle};
use serde::{Deserialize, Serialize};

/// `table1.json`: one [`AccelMap`] per gear and wheel angle, and where they come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table1File {
    /// Always `pivot-cal/table1`.
    pub format: String,
    /// Version of this layout, [`FORMAT_VERSION`].
    pub format_version: u32,
    /// Version of the program that wrote the file.
    pub tool_version: String,
    /// Units of every number whose name does not tell.
    pub units: Units,
    /// The vehicle, as the signal map or the log told it.
    pub vehicle: Vehicle,
    /// The logs that were read, ordered by hash.
    pub logs: Vec<LogRef>,
    /// Settings of the estimator, as used.
    pub settings: serde_json::Value,
    /// Dead time and lag of the drive.
    pub actuator: Actuator,
    /// The speed witnesses and how they compare.
    pub witnesses: Vec<Witness>,
    /// What is random about the plant.
    pub noise: PlantNoise,
    /// The tables.
    pub maps: Vec<AccelMap>,
    /// What the maps of a gear at several wheel angles have in common; none with one angle.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub families: Vec<AngleFamily>,
    /// What happened to the samples and the runs.
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

/// A log that was read.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LogRef {
    /// SHA-256 of the file; of a recording in several files, of their hashes in hexadecimal, one after the other.
    pub sha256: String,
    /// File name without its folder; of several files `first … last`.
    pub file: String,
    /// Size [bytes].
    pub bytes: u64,
}

/// A CSV beside the JSON.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CsvRef {
    /// File name, in the same folder.
    pub file: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

/// A delay with its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DelayEstimate {
    /// The delay [s].
    pub value_s: f64,
    /// Standard error [s]; absent when the value was given.
    pub std_err_s: Option<f64>,
    /// `estimated`, `weakly determined`, `given`, `not separable`, `at bound`.
    pub status: String,
}

/// The drive between commanded and effective torque: dead time, then a first-order lag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// Dead time of the drive [s], the mean over the logs.
    pub dead_time: DelayEstimate,
    /// Time constant of the first-order lag [s], shared by the logs.
    pub lag: DelayEstimate,
    /// The input that the fit used: `torque command` or `torque feedback`; in parentheses the reason, where it is not plain that a drive is
    /// modelled from its command.
    pub input: String,
    /// The same per log: a command's stamp is late by its sampling phase, differently in each log.
    pub per_log: Vec<LogActuator>,
}

/// Delays of one log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LogActuator {
    /// SHA-256 of the log.
    pub sha256: String,
    /// File name of the log.
    pub file: String,
    /// Dead time as this log shows it, after the clock offset is taken out.
    pub dead_time: DelayEstimate,
    /// How far the speed sources' clock is ahead of the torque command's [s] (positive: speed is stamped too early).
    pub clock_offset: DelayEstimate,
}

/// One source of the front wheel's speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Witness {
    /// `encoder` or `yaw rate`.
    pub name: String,
    /// Reading over true speed.
    pub scale: f64,
    /// Standard error of the scale; absent when the scale is 1 by definition.
    pub scale_std_err: Option<f64>,
    /// How much later it reads than the reference witness [s].
    pub delay_s: f64,
    /// Standard deviation of one reading [m/s].
    pub noise_mps: f64,
}

/// What is random about the plant: used to simulate it as the logs showed it.
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
    /// Where the value comes from.
    pub status: Vec<Vec<CellStatus>>,
    /// Per speed break the lowest and highest torque [N·m] that samples cover, or null.
    pub measured_torque_nm: Vec<Option<[f64; 2]>>,
    /// The torque that sets a resting wheel in motion.
    pub breakaway: Breakaway,
    /// The surface on a finer grid, from which Table 2 is made and vehicles are simulated.
    pub surface: Surface,
}

/// A fine grid of the fitted surface: rows torque, columns speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    /// Speed breaks [m/s].
    pub speed_mps: Vec<f64>,
    /// Torque breaks [N·m].
    pub torque_nm: Vec<f64>,
    /// Acceleration [m/s²].
    pub accel_mps2: Vec<Vec<f64>>,
}

/// The torque that sets a resting wheel in motion, in the gear's direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Breakaway {
    /// Best estimate [N·m]: where the surface at v → 0⁺ crosses zero, held within the bounds below.
    pub torque_nm: f64,
    /// Standard error [N·m]; absent when only bounds are known.
    pub std_err_nm: Option<f64>,
    /// Largest held torque at which the wheel stayed at rest [N·m].
    pub at_rest_up_to_nm: Option<f64>,
    /// Smallest held torque that set the wheel in motion [N·m].
    pub moved_from_nm: Option<f64>,
}

/// What happened to the samples and the runs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Stage1Report {
    /// Samples per verdict, over all logs.
    pub ledger: Vec<LedgerRow>,
    /// The runs, in the order of their logs and times.
    pub runs: Vec<RunRow>,
    /// Root mean square of the one-step residual over the used samples, as acceleration [m/s²].
    pub residual_rms_mps2: f64,
    /// Cells that were measured, of those within the axes (0 to 1).
    pub coverage: f64,
    /// Iterations of the fit.
    pub iterations: u32,
    /// What a reader should know: early stops, bounds reached, runs that disagree.
    pub notes: Vec<String>,
    /// Figures of the estimator's own choices (models compared, cross-validation), in a layout that may grow.
    #[serde(default)]
    pub diagnostics: serde_json::Value,
}

/// One line of the ledger.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LedgerRow {
    /// `used` or the reason for which samples were left out.
    pub verdict: String,
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
    /// Not JSON, another format, an unknown version, a missing or misplaced field, or tables that [`AccelTable::new`] refuses.
    pub fn from_json(text: &str) -> Result<Self> {
        let value = expect_format(text, TABLE1_FORMAT)?;
        let file: Self = serde_json::from_value(value)?;
        file.vehicle.checked()?;
        for map in &file.maps {
            map.table()?;
            map.surface.table()?;
        }
        file.families.iter().try_for_each(AngleFamily::check)?;
        Ok(file)
    }

    /// The JSON text, indented, with arrays of numbers on one line and a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_json(&self) -> Result<String> {
        crate::map::json_text::to_text(self)
    }

    /// The map of a gear at a wheel angle within `tolerance_deg` of `wheel_angle_deg`.
    pub fn map(&self, gear: Gear, wheel_angle_deg: f64, tolerance_deg: f64) -> Option<&AccelMap> {
        self.maps.iter().find(|m| m.gear == gear && (m.wheel_angle_deg - wheel_angle_deg).abs() <= tolerance_deg)
    }
}

impl AccelMap {
    /// The table itself.
    ///
    /// # Errors
    /// As [`Axis::new`] and [`AccelTable::new`].
    pub fn table(&self) -> Result<AccelTable> {
        table_of(&self.speed_mps, &self.torque_nm, &self.accel_mps2)
    }
}

impl Surface {
    /// The fine grid as a table.
    ///
    /// # Errors
    /// As [`Axis::new`] and [`AccelTable::new`].
    pub fn table(&self) -> Result<AccelTable> {
        table_of(&self.speed_mps, &self.torque_nm, &self.accel_mps2)
    }
}

fn table_of(speed: &[f64], torque: &[f64], accel: &[Vec<f64>]) -> Result<AccelTable> {
    let speed = Axis::new(crate::map::accel_table::SPEED_AXIS, speed.to_vec())?;
    let torque = Axis::new(crate::map::accel_table::TORQUE_AXIS, torque.to_vec())?;
    AccelTable::new(speed, torque, accel.concat())
}
