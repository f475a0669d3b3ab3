//! What the modules tell one another, and what the controller reads and commands.
//!
//! ```text
//!   planning ── PivotRequest (pivot and direction flag, waypoints) ──► longitudinal ── LateralTask (hold, restore) ──► lateral
//!      ▲                                                                │   ▲                                            │
//!      └───────────────────────── Phase ────────────────────────────────┘   └───────────── AngleStatus ──────────────────┘
//! ```

use crate::Gear;
use crate::waypoints::Path;

/// Which way the vehicle turns.
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

/// Where the reference point (middle of the rear axle) is, and where the vehicle looks.
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

/// What the controller reads each period, in the vehicle's frame.
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

/// What the controller commands each period, in the vehicle's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// Torque command [N·m], positive drives forward.
    pub torque_nm: f64,
    /// Target of the front-wheel angle [rad], left positive.
    pub wheel_angle_rad: f64,
    /// Gear command; `None` is neutral.
    pub gear: Option<Gear>,
    /// Where the pivot stands.
    pub phase: Phase,
    /// Which way it turns; `None` before the first request.
    pub direction: Option<Direction>,
    /// How far the front wheel is.
    pub angle: AngleStatus,
    /// What the longitudinal module told the lateral one.
    pub task: LateralTask,
    /// Whether that is to return the wheel.
    pub restore: bool,
    /// What the drive law did; `None` unless it was asked.
    pub drive: Option<DriveStep>,
}

/// One period of a drive law, in the gear's frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveStep {
    /// Torque [N·m], positive drives in the gear's direction.
    pub torque_nm: f64,
    /// Speed that was asked for [m/s].
    pub target_speed_mps: f64,
    /// Speed that was looked up [m/s].
    pub speed_mps: f64,
    /// Desired acceleration [m/s²].
    pub accel_mps2: f64,
    /// Arc length at which the front wheel is seen [m].
    pub arc_m: f64,
    /// Whether the desired acceleration is at its limit.
    pub limited: bool,
    /// Whether the look-up fell outside the table's axes.
    pub outside_table: bool,
    /// Whether the end of the path is reached.
    pub end_reached: bool,
}

/// From planning to the other modules: turn on the spot.
#[derive(Debug, Clone, PartialEq)]
pub struct PivotRequest {
    /// Pivot flag: the wheel goes to its pivot angle instead of following a curvature.
    pub pivot: bool,
    /// Direction flag.
    pub direction: Direction,
    /// Angle that the front wheel holds [rad], left positive.
    pub wheel_angle_rad: f64,
    /// Gear that turns that way at that angle.
    pub gear: Gear,
    /// Size of the turn [rad], positive.
    pub turn_rad: f64,
    /// Time that the speeds of the waypoints take [s].
    pub planned_s: f64,
    /// Waypoints along the front wheel's arc.
    pub path: Path,
}

/// From longitudinal to lateral: what the front wheel has to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LateralTask {
    /// Nothing asked: straight ahead.
    Rest,
    /// Turn the wheel to this angle [rad] and hold it.
    Hold(f64),
    /// Return the wheel to 0.
    Restore,
    /// Leave the target where it is: something failed.
    Freeze,
}

/// From lateral to longitudinal: how far the front wheel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleStatus {
    /// On its way, and nothing wrong with that.
    InProgress,
    /// Within tolerance of its target.
    Reached,
    /// The steering is at fault.
    Fault(SteeringFault),
}

/// What the steering can do wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum SteeringFault {
    /// The angle is outside the plausible range, or not a number.
    Implausible,
    /// The angle has not changed for too long, away from its target.
    Stuck,
    /// The angle moves but has not arrived in time.
    TooSlow,
    /// The angle has left its target while the vehicle drives.
    Lost,
}

/// Where a pivot stands: the longitudinal module's state, and its message to planning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Phase {
    /// Nothing requested.
    Idle,
    /// Standing until the wheel is at its angle.
    WaitingForAngle,
    /// Standing until the drive is in gear.
    SettingGear,
    /// Following the waypoints.
    Driving,
    /// The end is reached; no torque, until the wheel stands still.
    WaitingForStandstill,
    /// Standing until the wheel is back at 0.
    RestoringAngle,
    /// Done.
    Succeeded,
    /// Given up, with the reason; no driving torque until a new request.
    Failed(Failure),
}

impl Phase {
    /// Whether a pivot is under way.
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
    /// The steering is at fault.
    Steering(SteeringFault),
    /// The drive did not report the gear in time.
    GearNotSet,
    /// No speed reading for too long.
    SpeedLost,
    /// Standing still short of the end for too long.
    StoodStill,
    /// The phase took too long.
    TimeOut,
    /// The table gives no torque here and its policy forbids the nearest one.
    OutsideTable,
}
