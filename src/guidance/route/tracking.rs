//! What a tracking law is: from the vehicle's place beside a path to its front-wheel angle.
//!
//! In: [`Track`], one period as the direction of travel sees it. Out: the wheel angle in that frame. Every law is a pure step without
//! allocation; which law tracks is a choice ([`TrackingSettings`]).

use crate::control::messages::Pose;
use crate::control::numeric::{sin_cos, wrapped};
use crate::guidance::route::front_axle::FrontAxle;
use crate::guidance::route::lqr::Lqr;
use crate::guidance::route::mpc::{Mpc, MpcSettings};
use crate::guidance::route::path_position::{Leg, Matched, Offset};
use crate::guidance::route::pure_pursuit::PurePursuit;
use crate::guidance::route::rear_axle::RearAxle;
use crate::map::Gear;
use serde::{Deserialize, Serialize};

/// One period as the direction of travel sees it.
#[derive(Debug, Clone, Copy)]
pub struct Track<'a> {
    /// The leg that is tracked.
    pub leg: Leg<'a>,
    /// Pose of the rear axle's middle in the travel frame.
    pub pose: Pose,
    /// Nearest point of the path.
    pub matched: Matched,
    /// Piece of the leg that it lies on.
    pub index: usize,
    /// Offset from it.
    pub offset: Offset,
    /// Speed of the rear axle's middle along the travel [m/s], not negative.
    pub speed_mps: f64,
    /// Wheel angle in the travel frame [rad], as measured.
    pub wheel_angle_rad: f64,
    /// Wheelbase [m].
    pub wheelbase_m: f64,
    /// Largest wheel angle that may be asked for [rad].
    pub max_wheel_rad: f64,
    /// Control period [s].
    pub period_s: f64,
}

impl<'a> Track<'a> {
    /// Of a vehicle at `pose` with front-wheel speed [m/s] and angle [rad] in the vehicle's frame; `hint` is the piece where it was last seen.
    pub fn new(leg: Leg<'a>, pose: Pose, hint: usize, front_speed_mps: f64, wheel_angle_rad: f64, limits: &Limits) -> Self {
        let (matched, index) = leg.nearest(pose.x_m, pose.y_m, hint);
        let travel = leg.travel_pose(pose);
        let sign = leg.gear().sign();
        let speed_mps = (sign * front_speed_mps * sin_cos(wheel_angle_rad).1).max(0.0);
        Self {
            leg,
            pose: travel,
            matched,
            index,
            offset: Offset::new(travel, &matched),
            speed_mps: if speed_mps.is_finite() { speed_mps } else { 0.0 },
            wheel_angle_rad: sign * wheel_angle_rad,
            wheelbase_m: limits.wheelbase_m,
            max_wheel_rad: limits.max_wheel_rad,
            period_s: limits.period_s,
        }
    }

    /// Offset of the front axle from the point of the path nearest to it.
    pub(crate) fn front_offset(&self) -> Offset {
        let (sin, cos) = sin_cos(self.pose.heading_rad);
        let front = Pose {
            x_m: self.pose.x_m + self.wheelbase_m * cos,
            y_m: self.pose.y_m + self.wheelbase_m * sin,
            heading_rad: self.pose.heading_rad,
        };
        let (matched, _) = self.leg.nearest(front.x_m, front.y_m, self.index);
        Offset { heading_rad: wrapped(front.heading_rad - matched.course_rad), ..Offset::new(front, &matched) }
    }

    /// Whether the vehicle drives backward.
    pub fn is_reverse(&self) -> bool {
        self.leg.gear() == Gear::Reverse
    }
}

/// What a law must know of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Limits {
    /// Wheelbase [m].
    pub wheelbase_m: f64,
    /// Largest wheel angle that may be asked for while tracking [rad]. Default 1.2 (69°).
    pub max_wheel_rad: f64,
    /// Control period [s]. Default 0.02.
    pub period_s: f64,
}

impl Limits {
    /// The defaults for a wheelbase [m].
    pub fn new(wheelbase_m: f64) -> Self {
        Self { wheelbase_m, max_wheel_rad: 1.2, period_s: 0.02 }
    }
}

/// Which law tracks, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LawName {
    /// Pure pursuit.
    PurePursuit,
    /// Front-axle feedback (Stanley).
    FrontAxle,
    /// Rear-axle feedback.
    RearAxle,
    /// Linear-quadratic regulator.
    Lqr,
    /// Model predictive control.
    Mpc,
}

impl LawName {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::PurePursuit, Self::FrontAxle, Self::RearAxle, Self::Lqr, Self::Mpc];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::PurePursuit => "pure-pursuit",
            Self::FrontAxle => "front-axle",
            Self::RearAxle => "rear-axle",
            Self::Lqr => "lqr",
            Self::Mpc => "mpc",
        }
    }

    /// Name for people.
    pub fn title(self) -> &'static str {
        match self {
            Self::PurePursuit => "pure pursuit",
            Self::FrontAxle => "front-axle feedback",
            Self::RearAxle => "rear-axle feedback",
            Self::Lqr => "LQR",
            Self::Mpc => "MPC",
        }
    }
}

impl core::str::FromStr for LawName {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::ALL.into_iter().find(|law| law.name() == text).ok_or("known laws: pure-pursuit, front-axle, rear-axle, lqr, mpc")
    }
}

/// A law with its gains.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TrackingSettings {
    /// Pure pursuit.
    PurePursuit(PurePursuit),
    /// Front-axle feedback.
    FrontAxle(FrontAxle),
    /// Rear-axle feedback.
    RearAxle(RearAxle),
    /// Linear-quadratic regulator.
    Lqr(Lqr),
    /// Model predictive control.
    Mpc(MpcSettings),
}

impl TrackingSettings {
    /// A law with its default gains.
    pub fn new(name: LawName) -> Self {
        match name {
            LawName::PurePursuit => Self::PurePursuit(PurePursuit::default()),
            LawName::FrontAxle => Self::FrontAxle(FrontAxle::default()),
            LawName::RearAxle => Self::RearAxle(RearAxle::default()),
            LawName::Lqr => Self::Lqr(Lqr::default()),
            LawName::Mpc => Self::Mpc(MpcSettings::default()),
        }
    }
}

/// A law with its memory; only the MPC has any.
#[derive(Debug, Clone)]
pub struct TrackingLaw {
    settings: TrackingSettings,
    lqr_gains: [f64; 2],
    mpc: Mpc,
}

impl TrackingLaw {
    /// A law that has seen nothing.
    pub fn new(settings: TrackingSettings) -> Self {
        let lqr_gains = if let TrackingSettings::Lqr(lqr) = &settings { lqr.gains() } else { [0.0; 2] };
        Self { settings, lqr_gains, mpc: Mpc::default() }
    }

    /// Forgets the leg before.
    pub fn start(&mut self) {
        self.mpc = Mpc::default();
    }

    /// Front-wheel angle to ask for [rad], in the vehicle's frame, within the limit; 0 when the numbers allow no answer.
    pub fn wheel_angle_rad(&mut self, track: &Track<'_>) -> f64 {
        let wanted_rad = match &self.settings {
            TrackingSettings::PurePursuit(law) => law.wheel_angle_rad(track),
            TrackingSettings::FrontAxle(law) => law.wheel_angle_rad(track),
            TrackingSettings::RearAxle(law) => law.wheel_angle_rad(track),
            TrackingSettings::Lqr(_) => Lqr::wheel_angle_rad(self.lqr_gains, track),
            TrackingSettings::Mpc(law) => self.mpc.wheel_angle_rad(law, track),
        };
        if wanted_rad.is_finite() { track.leg.gear().sign() * wanted_rad.max(-track.max_wheel_rad).min(track.max_wheel_rad) } else { 0.0 }
    }
}
