//! Torque maps: the numbers, their look-up, and the files that hold them.
//!
//! In: arrays of numbers, or files. Out: [`AccelTable`] (Table 1) and [`TorqueTable`] (Table 2), whose constructors have checked axis
//! order, finiteness and shape, and [`Table1File`] and [`Table2File`], the JSON artefacts with everything that a table alone does not tell.

mod accel_maps;
pub(crate) mod accel_table;
mod angle_family;
pub mod angle_lookup;
mod axis;
mod cell;
mod csv_matrix;
mod error;
mod fit_traces;
mod format;
mod gear;
mod json_text;
mod lateral_table_file;
pub mod lookup;
mod per_gear;
mod plan_file;
mod save;
mod table1_file;
mod table2_file;
pub(crate) mod torque_table;
mod vehicle;

pub use accel_maps::{AccelAtAngle, AccelMaps};
pub use accel_table::AccelTable;
pub use angle_family::{AngleFamily, LeftOutAngle, SAME_ANGLE_DEG, Side, csv_name, is_csv_name};
pub use axis::Axis;
pub use cell::CellStatus;
pub use csv_matrix::Matrix;
pub(crate) use csv_matrix::decimal;
pub use error::{Error, Result};
pub use fit_traces::{DeadTimeLikelihood, DelayLikelihood, FitTraces, ResidualCells, ResidualTimes, RunTrace};
pub(crate) use format::expect_format;
pub use format::{FIT_TRACES_FORMAT, FORMAT_VERSION, LATERAL_TABLE_FORMAT, TABLE1_FORMAT, TABLE2_FORMAT};
pub use gear::Gear;
pub use lateral_table_file::{LateralCurve, LateralEntry, LateralMean, LateralTableFile};
pub use per_gear::PerGear;
pub use plan_file::{PlanFile, PlannedRun, Proposal};
pub use save::{sha256_hex, write_whole};
pub use table1_file::{
    AccelMap, Actuator, Breakaway, CsvRef, DelayEstimate, LedgerRow, LogActuator, LogRef, PlantNoise, RunRow, Stage1Report, Surface,
    Table1File, Units, Witness,
};
pub use table2_file::{DeadBand, Place, RoundTrip, Table2File, TorqueMap};
pub use torque_table::TorqueTable;
pub use vehicle::Vehicle;
