//! The files that hold a map, and the folder that holds the files.
//!
//! In: JSON and CSV text, or a folder. Out: [`Table1File`], [`Table2File`] and the files beside them, checked field by field, and
//! [`MapFolder`], which checks whether each file is the one that the others describe.

mod csv_name;
mod fit_traces;
mod folder;
mod format;
mod identified_drive;
mod json_text;
mod lateral_table_file;
mod named;
mod plan_file;
mod save;
mod shape;
mod status;
mod table1_file;
mod table2_file;

pub use csv_name::{csv_name, is_csv_name};
pub use fit_traces::{DeadTimeLikelihood, DelayLikelihood, FitTraces, ResidualCells, ResidualTimes, RunTrace};
pub use folder::{FolderError, MapFolder, Mismatch, StoredFile};
pub(crate) use format::expect_format;
pub use format::{FIT_TRACES_FORMAT, FORMAT_VERSION, LATERAL_TABLE_FORMAT, TABLE1_FORMAT, TABLE2_FORMAT};
pub use identified_drive::{CampaignChange, ComparedDrive, DriveFamily, DriveLimit, IdentifiedDrive, LimitKind};
pub use lateral_table_file::{LateralCurve, LateralEntry, LateralMean, LateralTableFile};
pub use named::FixedText;
pub use plan_file::{PlanEntry, PlanFile, PlannedRun, Proposal};
pub use save::{sha256_hex, write_whole};
pub use status::{ActuatorInput, DelayStatus, InputSource, SampleVerdict, SpeedSource, ZeroRow};
pub use table1_file::{
    AccelMap, Actuator, BreakawayTorque, CsvRef, DelayEstimate, FineSurface, LedgerRow, LogActuator, LogRef, PlantNoise, RunRow,
    SpeedReading, Stage1Report, Table1File, Units,
};
pub use table2_file::{DeadBand, GridPoint, RoundTripErrors, Table2File, TorqueMap};
