//! Torque maps: the numbers, their look-up, and the files that hold them.
//!
//! In: arrays of numbers, or files. Out: [`AccelTable`] (Table 1) and [`TorqueTable`] (Table 2), whose constructors check axis order,
//! finiteness and shape; [`Table1File`] and [`Table2File`], the JSON artefacts with everything beyond the tables; and [`MapFolder`], the
//! files of a folder with their mismatches.

mod error;
mod files;
mod numbers;
mod vehicle;

pub use error::{Error, Result};
pub(crate) use files::expect_format;
pub use files::{
    AccelMap, Actuator, ActuatorInput, BreakawayTorque, CampaignChange, ComparedDrive, CsvRef, DeadBand, DeadTimeLikelihood, DelayEstimate,
    DelayLikelihood, DelayStatus, DriveFamily, DriveLimit, FIT_TRACES_FORMAT, FORMAT_VERSION, FineSurface, FitTraces, FixedText,
    FolderError, GridPoint, IdentifiedDrive, InputSource, LATERAL_TABLE_FORMAT, LateralCurve, LateralEntry, LateralMean, LateralTableFile,
    LedgerRow, LimitKind, LogActuator, LogRef, MapFolder, Mismatch, PlanEntry, PlanFile, PlannedRun, PlantNoise, Proposal, ResidualCells,
    ResidualTimes, RoundTripErrors, RunRow, RunTrace, SampleVerdict, SpeedReading, SpeedSource, Stage1Report, StoredFile, TABLE1_FORMAT,
    TABLE2_FORMAT, Table1File, Table2File, TorqueMap, Units, ZeroRow, csv_name, is_csv_name, sha256_hex, write_whole,
};
pub(crate) use numbers::{ACCEL_AXIS, SPEED_AXIS, TORQUE_AXIS, check_values, decimal};
pub use numbers::{
    AccelAtAngle, AccelMaps, AccelTable, AngleFamily, AngleSurface, Axis, CellStatus, DepartureFrom, Gear, LeftOutAngle, Matrix, PerGear,
    SAME_ANGLE_DEG, Side, TorqueTable, WheelAngle, angle_lookup, lookup,
};
pub use vehicle::Vehicle;
