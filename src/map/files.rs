//! The files that hold a map, and the folder that holds the files.
//!
//! In: JSON and CSV text, or a folder. Out: [`Table1File`], [`Table2File`] and the files beside them, checked field by field, and
//! [`MapFolder`], which checks whether each file is the one that the others describe.

mod actuator;
mod check;
mod csv_name;
mod destination;
mod fault;
mod fit_traces;
mod folder;
mod folder_lock;
mod folder_writer;
mod format;
mod identified_drive;
mod json_text;
pub(crate) mod lateral_table_file;
mod leftovers;
mod log_ref;
mod named;
pub(crate) mod plan_file;
mod read;
mod save;
mod shape;
mod status;
mod table1_file;
mod table2_file;
mod toml_text;

pub use actuator::{Actuator, DelayEstimate, LogActuator};
pub use check::{Check, CheckOutcome};
pub(crate) use csv_name::csv_name;
pub(crate) use destination::Destination;
pub use fit_traces::FitTraces;
pub(crate) use fit_traces::{DeadTimeLikelihood, DelayLikelihood, ResidualCells, ResidualTimes, RunTrace};
pub(crate) use folder::{FolderError, MapFolder, Mismatch, StoredFile};
pub(crate) use folder_lock::FolderLock;
pub(crate) use folder_writer::{FolderView, FolderWriter, read_settled};
pub(crate) use format::parse_file;
pub(crate) use format::{FIT_TRACES_FORMAT, FORMAT_VERSION, LATERAL_TABLE_FORMAT, TABLE1_FORMAT, TABLE2_FORMAT};
pub use identified_drive::{CampaignChange, ComparedDrive, DriveFamily, DriveLimit, IdentifiedDrive, LimitKind};
pub(crate) use lateral_table_file::LateralTableFile;
pub(crate) use lateral_table_file::{LateralCurve, LateralEntry, LateralMean};
pub use log_ref::{LogLoss, LogRef};
pub(crate) use named::FixedText;
pub(crate) use plan_file::PlanFile;
pub use plan_file::{PlanEntry, PlannedRun, Proposal};
pub(crate) use read::{read_whole, read_whole_text};
pub use save::sha256_hex;
pub(crate) use save::write_whole;
pub use status::{ActuatorInput, DelayStatus, InputSource, SampleVerdict, SpeedSource, ZeroRow};
pub use table1_file::{
    AccelMap, BreakawayTorque, CsvRef, FineSurface, LedgerRow, ListedRuns, PlantNoise, RunRow, SpeedReading, Stage1Report, Table1File,
    Units,
};
pub use table2_file::{DeadBand, GridPoint, RoundTripErrors, Table2File, TorqueMap};
pub(crate) use toml_text::{toml_line, toml_text};
