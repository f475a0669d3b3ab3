//! The numbers: axes, tables, changes with gear and wheel angle, and the look-up.
//!
//! In: arrays of numbers. Out: [`AccelTable`] and [`TorqueTable`], whose constructors have checked axis order, finiteness and shape.
//! [`lookup`], [`angle_lookup`] and [`Gear`] are those of the controller.

mod accel_maps;
mod accel_table;
mod angle_family;
mod axis;
mod cell;
mod csv_matrix;
mod per_gear;
mod raw_unit;
mod torque_table;
mod wheel_angle;

pub use crate::control::Gear;
pub(crate) use crate::control::{angle_lookup, lookup};
pub use accel_maps::AccelMaps;
pub(crate) use accel_maps::AngleSurface;
pub use accel_table::AccelTable;
pub(crate) use accel_table::{SPEED_AXIS, TORQUE_AXIS, check_values};
pub use angle_family::{AngleFamily, DepartureFrom, LeftOutAngle};
pub use axis::Axis;
pub use cell::CellStatus;
pub use csv_matrix::Matrix;
pub(crate) use csv_matrix::decimal;
pub(crate) use per_gear::PerGear;
pub use raw_unit::{RawUnit, RawUnits};
pub(crate) use torque_table::ACCEL_AXIS;
pub use torque_table::TorqueTable;
pub(crate) use wheel_angle::SAME_ANGLE_DEG;
pub use wheel_angle::{Side, WheelAngle};
