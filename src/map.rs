//! Torque maps: the numbers, their look-up, and the files that hold them.
//!
//! In: arrays of numbers, or files. Out: [`AccelTable`] (Table 1) and [`TorqueTable`] (Table 2), whose constructors check axis order,
//! finiteness and shape; [`Table1File`] and [`Table2File`], the JSON artefacts with everything beyond the tables. `MapFolder` is the
//! files of a folder with their mismatches.

mod error;
pub(crate) mod files;
pub(crate) mod numbers;
mod vehicle;

pub use error::Error;
pub(crate) use error::Result;
pub(crate) use files::PlanFile;
pub(crate) use files::parse_file;
pub use files::{
    AccelMap, Actuator, ActuatorInput, BreakawayTorque, CampaignChange, Check, CheckOutcome, CsvRef, DeadBand, DelayEstimate, DelayStatus,
    DriveFamily, DriveLimit, FineSurface, FitTraces, GridPoint, IdentifiedDrive, InputSource, LedgerRow, LimitKind, ListedRuns,
    LogActuator, LogLoss, LogRef, PlanEntry, PlannedRun, PlantNoise, Proposal, RoundTripErrors, RunRow, SampleVerdict, SpeedReading,
    SpeedSource, Stage1Report, Table1File, Table2File, TorqueMap, Units, ZeroRow,
};
#[doc(hidden)] // details of the fit, and what tests need
pub use files::{ComparedDrive, sha256_hex};
pub(crate) use files::{
    DeadTimeLikelihood, DelayLikelihood, Destination, FIT_TRACES_FORMAT, FORMAT_VERSION, FixedText, FolderError, FolderLock, FolderView,
    FolderWriter, LATERAL_TABLE_FORMAT, LateralCurve, LateralEntry, LateralMean, MapFolder, Mismatch, ResidualCells, ResidualTimes,
    RunTrace, StoredFile, TABLE1_FORMAT, TABLE2_FORMAT, csv_name, read_settled,
};
pub(crate) use files::{LateralTableFile, read_whole, read_whole_text, toml_line, toml_text, write_whole};
pub(crate) use numbers::AccelMaps;
pub(crate) use numbers::{ACCEL_AXIS, SPEED_AXIS, TORQUE_AXIS, check_values, decimal};
pub use numbers::{AccelTable, AngleFamily, Axis, CellStatus, Gear, Matrix, RawUnit, RawUnits, Side, TorqueTable, WheelAngle};
pub(crate) use numbers::{AngleSurface, PerGear, SAME_ANGLE_DEG, angle_lookup, lookup};
#[doc(hidden)] // details of the fit
pub use numbers::{DepartureFrom, LeftOutAngle};
pub use vehicle::Vehicle;
