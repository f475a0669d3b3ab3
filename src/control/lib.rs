//! The pivot controller: the law that is deployed on the vehicle.
//!
//! In: [`Inputs`], the measurements of a period. Out: [`Outputs`], torque, wheel angle and gear. Planning places waypoints with speeds
//! along the front wheel's arc; lateral holds the wheel at its angle; longitudinal gets the torque from the drive law. [`WaypointLaw`] is
//! the law of the map; a law of another kind implements the same [`DriveLaw`].
//!
//! Everything here is a pure step: state and inputs to state and outputs, without allocation, clock, input or output, or panic.
//! The crate has no standard library and no allocator, and a test compiles it alone (`tests/alone.rs`); mathematics comes from `libm`
//! (`numeric`), so that it gives the same bits on every processor.

#![cfg_attr(not(test), no_std)]

mod angle;
#[doc(hidden)]
pub mod angle_lookup;
mod angle_map;
mod drive_law;
mod error;
mod gear;
mod heading_law;
mod lateral;
mod lateral_compensation;
mod longitudinal;
#[doc(hidden)]
pub mod lookup;
mod messages;
#[doc(hidden)]
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
pub use angle_lookup::AngleTerms;
pub use angle_map::{AngleLookup, AngleTable, AngleTables, GearTerms};
pub use drive_law::{DriveInputs, DriveLaw};
pub use error::Error;
pub(crate) use error::Result;
pub use gear::Gear;
pub use lateral::LateralSettings;
pub use lateral_compensation::{Accumulation, CompensationEntry, CompensationSettings, CompensationTable, LateralCompensation};
pub use longitudinal::{AfterFailure, LongitudinalSettings};
pub use messages::{AngleStatus, Direction, DriveStep, Failure, Inputs, LateralTask, Outputs, Phase, PivotRequest, Pose, SteeringFault};
pub use pivot::{PivotController, PivotSettings};
pub use planning::{PlanningSettings, WheelPolicy};
pub use preview::Preview;
pub use profile::Profile;
pub use speed_loop::SpeedLoopSettings;
pub use stopping::StoppingGuard;
pub use table_view::TableView;
pub use torque_map::{Lookup, OutsidePolicy, Tables, TorqueFromAccel};
pub use waypoint_law::{Finish, WaypointLaw, WaypointLawSettings};
pub use waypoints::{Nearest, Path, Waypoint};

// for the planner and the verdict of pivot-cal; no part of the controller's interface
#[doc(hidden)]
pub use heading_law::{HeadingLaw, HeadingLawSettings};
#[doc(hidden)]
pub use speed_loop::SpeedLoop;
#[doc(hidden)]
pub use stopping::{Arrival, UnderWay};
#[doc(hidden)]
pub use torque_map::ConstantGain;
