//! The proof that the controller and the look-up can be carried to a microcontroller: their files, compiled as they are into a library
//! without the standard library and without an allocator. `cargo build --example core_only`; `cargo test` builds it too.
//!
//! What the compiler cannot see here, float functions of the standard library such as `sqrt`, a test (`tests/core_only.rs`) looks for.

#![no_std]
#![allow(unreachable_pub, dead_code, unused_imports, missing_docs)]

/// What the controller uses of the rest: a degree.
pub mod units {
    /// Radians in one degree.
    pub const RAD_PER_DEG: f64 = core::f64::consts::PI / 180.0;
}

/// What the controller uses of the map: the gear, the look-up, and a table that it only borrows.
#[path = "../src/map"]
pub mod map {
    pub mod angle_lookup;
    mod gear;
    pub mod lookup;
    pub use gear::Gear;

    /// Breaks along one axis.
    #[derive(Debug, Clone, Copy)]
    pub struct Axis(&'static [f64]);

    impl Axis {
        /// The breaks.
        pub fn breaks(&self) -> &[f64] {
            self.0
        }
    }

    /// A table in read-only memory, in place of the one that this project reads from files.
    #[derive(Debug, Clone, Copy)]
    pub struct TorqueTable {
        speed_mps: Axis,
        accel_mps2: Axis,
        torque_nm: &'static [f64],
    }

    impl TorqueTable {
        /// Speed breaks [m/s].
        pub fn speed_mps(&self) -> &Axis {
            &self.speed_mps
        }

        /// Acceleration breaks [m/s²].
        pub fn accel_mps2(&self) -> &Axis {
            &self.accel_mps2
        }

        /// Torques [N·m], row by row.
        pub fn values(&self) -> &[f64] {
            self.torque_nm
        }
    }
}

#[path = "../src/control"]
pub mod control {
    mod angle_map;
    mod drive_law;
    mod error;
    mod heading_law;
    mod lateral;
    pub mod lateral_compensation;
    mod longitudinal;
    mod messages;
    mod numeric;
    mod path;
    mod phase;
    mod pivot;
    mod planning;
    mod preview;
    mod profile;
    mod speed_loop;
    mod stopping;
    mod torque_map;
    mod waypoint_law;

    pub use angle_map::{AngleLookup, AngleTable, AngleTables, GearTerms};
    pub use drive_law::{DriveInputs, DriveLaw};
    pub use error::{Error, Result};
    pub use heading_law::{HeadingLaw, HeadingLawSettings};
    pub use lateral::{Lateral, LateralSettings};
    pub use longitudinal::{AfterFailure, Longitudinal, LongitudinalOutputs, LongitudinalSettings};
    pub use messages::{
        AngleStatus, Direction, DriveStep, Failure, Inputs, LateralTask, Outputs, Phase, PivotRequest, Pose, SteeringFault,
    };
    pub use path::{MAX_WAYPOINTS, Nearest, Path, Place, Waypoint};
    pub use phase::Event;
    pub use pivot::{PivotController, Settings};
    pub use planning::{PlanningSettings, WheelPolicy};
    pub use preview::Preview;
    pub use profile::Profile;
    pub use speed_loop::{SpeedLoop, SpeedLoopSettings};
    pub use stopping::StoppingGuard;
    pub use torque_map::{ConstantGain, Lookup, OutsidePolicy, Tables, TorqueMap};
    pub use waypoint_law::{Finish, WaypointLaw, WaypointLawSettings};
}
