//! Messages between the modules, and inputs and outputs of the controller.
//!
//! ```text
//!   planning ── PivotRequest (pivot and direction flag, waypoints) ──► longitudinal ── LateralTask (hold, restore) ──► lateral
//!      ▲                                                                │   ▲                                            │
//!      └───────────────────────── Phase ────────────────────────────────┘   └───────────── AngleStatus ──────────────────┘
//! ```

use crate::Gear;
use crate::waypoints::Path;

/// Direction of the turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Direction {
    /// Heading grows.
    Left,
    /// Heading falls.
    Right,
}

impl Direction {
    /// The number of the direction flag: 2 left, 3 right.
    pub fn flag(self) -> u8 {
        match self {
            Self::Left => 2,
            Self::Right => 3,
        }
    }

    /// +1 left, −1 right.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// Position of the reference point (middle of the rear axle), and heading.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Pose {
    /// East of the origin [m].
    pub x_m: f64,
    /// North of the origin [m].
    pub y_m: f64,
    /// Heading [rad], counter-clockwise positive.
    pub heading_rad: f64,
}

/// Readings of the controller in each period, vehicle frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Front-wheel rolling speed [m/s], forward positive; `None` while the sensor gives none.
    pub speed_mps: Option<f64>,
    /// Front-wheel angle [rad], left positive.
    pub wheel_angle_rad: f64,
    /// Pose of the reference point.
    pub pose: Pose,
    /// Gear that the drive is in; `None` is neutral.
    pub gear: Option<Gear>,
    /// Emergency stop for an obstacle.
    pub estop: bool,
}

/// Commands of the controller in each period, vehicle frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// Torque command [N·m], positive drives forward.
    pub torque_nm: f64,
    /// Target of the front-wheel angle [rad], left positive.
    pub wheel_angle_rad: f64,
    /// Gear command; `None` is neutral.
    pub gear: Option<Gear>,
    /// Phase of the pivot.
    pub phase: Phase,
    /// Direction of the turn; `None` before the first request.
    pub direction: Option<Direction>,
    /// Status of the front wheel.
    pub angle: AngleStatus,
    /// Message from longitudinal to lateral.
    pub task: LateralTask,
    /// Whether that task is to return the wheel.
    pub restore: bool,
    /// Output of the drive law; `None` if it was not called.
    pub drive: Option<DriveStep>,
}

/// One period of a drive law, in the gear's frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveStep {
    /// Torque [N·m], positive drives in the gear's direction.
    pub torque_nm: f64,
    /// Desired speed [m/s].
    pub target_speed_mps: f64,
    /// Speed of the look-up [m/s].
    pub speed_mps: f64,
    /// Desired acceleration [m/s²].
    pub accel_mps2: f64,
    /// Measured arc length of the front wheel [m].
    pub arc_m: f64,
    /// Whether the desired acceleration is at its limit.
    pub limited: bool,
    /// Whether the look-up fell outside the table's axes.
    pub outside_table: bool,
    /// Whether the end of the path is reached.
    pub end_reached: bool,
}

/// From planning to the other modules: a pivot.
#[derive(Debug, Clone, PartialEq)]
pub struct PivotRequest {
    /// Pivot flag: the wheel goes to its pivot angle instead of following a curvature.
    pub pivot: bool,
    /// Direction flag.
    pub direction: Direction,
    /// Angle that the front wheel holds [rad], left positive.
    pub wheel_angle_rad: f64,
    /// Angle to which it returns after the turn [rad], left positive.
    pub return_angle_rad: f64,
    /// Gear for that direction at that angle.
    pub gear: Gear,
    /// Size of the turn [rad], positive.
    pub turn_rad: f64,
    /// Duration by the speeds of the waypoints [s].
    pub planned_s: f64,
    /// Waypoints along the front wheel's arc.
    pub path: Path,
}

/// From longitudinal to lateral: task of the front wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LateralTask {
    /// No task: straight ahead.
    Rest,
    /// Turn the wheel to this angle [rad] and hold it.
    Hold(f64),
    /// Return the wheel to this angle [rad].
    Restore(f64),
    /// Keep the target: something failed.
    Freeze,
}

/// From lateral to longitudinal: status of the front wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleStatus {
    /// Moving to its target, without a fault.
    InProgress,
    /// Within tolerance of its target.
    Reached,
    /// The steering has a fault.
    Fault(SteeringFault),
}

/// Faults of the steering.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum SteeringFault {
    /// The angle is outside the plausible range, or NaN.
    Implausible,
    /// The angle has not changed for too long, away from its target.
    Stuck,
    /// The angle moves but has not arrived in time.
    TooSlow,
    /// The angle has left its target while the vehicle drives.
    Lost,
}

/// Phase of a pivot: the longitudinal module's state, and its message to planning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Phase {
    /// Nothing requested.
    Idle,
    /// At rest until the wheel is at its angle.
    WaitingForAngle,
    /// At rest until the drive is in gear.
    SettingGear,
    /// Following the waypoints.
    Driving,
    /// The end is reached; no torque until the wheel rests.
    WaitingForStandstill,
    /// At rest until the wheel is at its return angle.
    RestoringAngle,
    /// Done.
    Succeeded,
    /// Failed, with the reason; no driving torque until a new request.
    Failed(Failure),
}

impl Phase {
    /// Whether a pivot is in progress.
    pub fn is_active(self) -> bool {
        !matches!(self, Self::Idle | Self::Succeeded | Self::Failed(_))
    }
}

/// Why a pivot failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Failure {
    /// Emergency stop for an obstacle before the pivot had succeeded.
    ObstacleStop,
    /// The steering has a fault.
    Steering(SteeringFault),
    /// The drive did not report the gear in time.
    GearNotSet,
    /// No speed reading for too long.
    SpeedLost,
    /// At rest before the end for too long.
    StoodStill,
    /// The phase took too long.
    TimeOut,
    /// The table gives no torque here and its policy forbids the nearest one.
    OutsideTable,
}
