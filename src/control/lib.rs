//! The pivot controller: the law that is deployed, written as for the vehicle.
//!
//! In: [`Inputs`], what is measured, once a period. Out: [`Outputs`], torque, wheel angle and gear. Planning lays waypoints with speeds along the
//! front wheel's arc; lateral holds the wheel at its angle; longitudinal asks the drive law for torque. [`WaypointLaw`] is the law of the map;
//! [`HeadingLaw`] is the conventional one, behind the same [`DriveLaw`].
//!
//! Everything here is a pure step: state and inputs to state and outputs, without allocation, clock, input or output, and without a panic.
//! The crate has no standard library and no allocator, and a test compiles it alone (`tests/alone.rs`); mathematics comes from `libm`
//! ([`numeric`]), so that it gives the same bits on every processor.

#![cfg_attr(not(test), no_std)]

mod angle;
pub mod angle_lookup;
mod angle_map;
mod drive_law;
mod error;
mod gear;
mod heading_law;
mod lateral;
pub mod lateral_compensation;
mod longitudinal;
pub mod lookup;
mod messages;
pub mod numeric;
mod phase;
mod pivot;
mod planning;
mod preview;
mod profile;
mod speed_loop;
mod stopping;
mod table_view;
mod torque_map;
mod waypoint_law;
mod waypoints;

pub use angle::RAD_PER_DEG;
pub use angle_map::{AngleLookup, AngleTable, AngleTables, GearTerms};
pub use drive_law::{DriveInputs, DriveLaw};
pub use error::{Error, Result};
pub use gear::Gear;
pub use heading_law::{HeadingLaw, HeadingLawSettings};
pub use lateral::{Lateral, LateralSettings};
pub use longitudinal::{AfterFailure, Longitudinal, LongitudinalOutputs, LongitudinalSettings};
pub use messages::{AngleStatus, Direction, DriveStep, Failure, Inputs, LateralTask, Outputs, Phase, PivotRequest, Pose, SteeringFault};
pub use phase::Event;
pub use pivot::{PivotController, PivotSettings};
pub use planning::{PlanningSettings, WheelPolicy};
pub use preview::Preview;
pub use profile::Profile;
pub use speed_loop::{SpeedLoop, SpeedLoopSettings};
pub use stopping::StoppingGuard;
pub use table_view::TableView;
pub use torque_map::{ConstantGain, Lookup, OutsidePolicy, Tables, TorqueFromAccel};
pub use waypoint_law::{Finish, WaypointLaw, WaypointLawSettings};
pub use waypoints::{MAX_WAYPOINTS, Nearest, Path, Place, Waypoint};
