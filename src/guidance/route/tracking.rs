//! A tracking law computes the front-wheel angle from the vehicle's offset from a path.
//!
//! In: [`TrackState`], one period in the travel frame. Out: the wheel angle in that frame. Every law is a step without
//! allocation ([`Law`]); [`TrackingSettings`] selects the law.

use crate::guidance::route::front_axle::FrontAxle;
use crate::guidance::route::lqr::{Lqr, LqrLaw};
use crate::guidance::route::mpc::{Mpc, MpcSettings};
use crate::guidance::route::pure_pursuit::PurePursuit;
use crate::guidance::route::rear_axle::RearAxle;
use crate::guidance::route::track::{Law, TrackState};
use serde::{Deserialize, Serialize};

/// Name of a tracking law.
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

    /// Display name.
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
pub(crate) enum TrackingSettings {
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
    pub(crate) fn new(name: LawName) -> Self {
        match name {
            LawName::PurePursuit => Self::PurePursuit(PurePursuit::default()),
            LawName::FrontAxle => Self::FrontAxle(FrontAxle::default()),
            LawName::RearAxle => Self::RearAxle(RearAxle::default()),
            LawName::Lqr => Self::Lqr(Lqr::default()),
            LawName::Mpc => Self::Mpc(MpcSettings::default()),
        }
    }

    /// The law in its initial state.
    fn law(&self) -> Box<dyn Law + Send> {
        match self {
            Self::PurePursuit(law) => Box::new(*law),
            Self::FrontAxle(law) => Box::new(*law),
            Self::RearAxle(law) => Box::new(*law),
            Self::Lqr(settings) => Box::new(LqrLaw::new(settings)),
            Self::Mpc(settings) => Box::new(Mpc::new(settings)),
        }
    }
}

/// The selected law, within the limits of the wheel.
#[derive(Debug)]
pub(crate) struct TrackingLaw(Box<dyn Law + Send>);

impl TrackingLaw {
    /// A law in its initial state.
    pub(crate) fn new(settings: TrackingSettings) -> Self {
        Self(settings.law())
    }

    /// Resets the law for a new leg.
    pub(crate) fn start(&mut self) {
        self.0.forget();
    }

    /// Commanded front-wheel angle [rad], in the vehicle's frame, within the limit; 0 if the numbers give none.
    pub(crate) fn wheel_angle_rad(&mut self, track: &TrackState<'_>) -> f64 {
        // a law with a state must not keep a place that is not a number
        let known = track.offset.lateral_m.is_finite() && track.offset.heading_rad.is_finite();
        let wanted_rad = if known { self.0.wheel_angle_rad(track) } else { f64::NAN };
        if wanted_rad.is_finite() { track.leg.gear().sign() * wanted_rad.max(-track.max_wheel_rad).min(track.max_wheel_rad) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::control::Pose;
    use crate::guidance::PosePath;
    use crate::guidance::route::clothoid_path::{ClothoidPiece, course};
    use crate::guidance::route::path_position::Leg;
    use crate::guidance::route::track::Limits;

    fn straight(reverse: bool) -> PosePath {
        let piece = ClothoidPiece::straight(10.0);
        course(&[if reverse { piece.reversed() } else { piece }], 0.9)
    }

    fn beside(path: &PosePath, x_m: f64, y_m: f64) -> TrackState<'_> {
        let speed_mps = if x_m < 0.0 { -0.5 } else { 0.5 };
        TrackState::new(Leg::first(&path.poses).unwrap(), Pose { x_m, y_m, heading_rad: 0.0 }, 0, speed_mps, 0.0, &Limits::new(0.9))
    }

    #[test]
    fn every_law_steers_towards_the_path_in_both_directions_and_keeps_the_limit() {
        for name in LawName::ALL {
            let angle = |path: &PosePath, x_m, y_m| TrackingLaw::new(TrackingSettings::new(name)).wheel_angle_rad(&beside(path, x_m, y_m));
            let (forward, reverse) = (straight(false), straight(true));
            assert!(angle(&forward, 3.0, 0.1) < -0.01 && angle(&forward, 3.0, -0.1) > 0.01, "{}", name.title());
            // driving backward, too, a wheel turned to the left takes the rear axle to larger y
            assert!(angle(&reverse, -3.0, 0.1) < -0.01 && angle(&reverse, -3.0, -0.1) > 0.01, "{}", name.title());
            assert!(angle(&forward, 3.0, 50.0).abs() <= Limits::new(0.9).max_wheel_rad, "{}", name.title());
            assert_eq!(angle(&forward, 3.0, f64::NAN), 0.0, "{}", name.title());
        }
    }

    #[test]
    fn only_the_mpc_remembers_and_a_new_leg_makes_it_forget() {
        let path = straight(false);
        for name in LawName::ALL {
            let mut law = TrackingLaw::new(TrackingSettings::new(name));
            let first = law.wheel_angle_rad(&beside(&path, 3.0, 0.3));
            let second = law.wheel_angle_rad(&beside(&path, 3.0, 0.3));
            assert_eq!(first != second, name == LawName::Mpc, "{}", name.title());
            law.start();
            assert_eq!(law.wheel_angle_rad(&beside(&path, 3.0, 0.3)), first, "{}", name.title());
        }
    }
}
