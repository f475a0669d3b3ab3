//! Motion: effective torque → front-wheel speed, either by the physics of a vehicle or by a fitted Table 1.

use crate::map::Vehicle;
use crate::sim::{AngleTerms, Gear};
use crate::sim::drive::TorqueStep;
use crate::sim::error::Result;
use crate::sim::identified::{IdentifiedMotion, IdentifiedSettings};
use crate::sim::physical::PhysicalMotion;
use crate::sim::plant::PhysicalSettings;
use crate::sim::pose::SpeedStep;

/// Which plant, and its settings.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionSettings {
    /// Inertia, friction, scrub.
    Physical(PhysicalSettings),
    /// Table 1 of a fit.
    Identified(Box<IdentifiedSettings>),
}

/// What acts on the wheel over one step, vehicle frame, referred to the wheel.
#[derive(Debug, Clone, Copy)]
pub struct Load {
    /// Torque that the drive passes to the floor.
    pub torque: TorqueStep,
    /// Slope and pushes as torque at the wheel [N·m], + forward.
    pub external_nm: f64,
    /// Friction of the brake [N·m], ≥ 0.
    pub brake_nm: f64,
    /// Gear engaged; `None` is neutral.
    pub gear: Option<Gear>,
}

/// The plant's state: front-wheel speed and what is random about it.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)] // one per world: boxing would only add an indirection to every step
pub enum Motion {
    /// Inertia, friction, scrub.
    Physical(PhysicalMotion),
    /// Table 1 of a fit.
    Identified(IdentifiedMotion),
}

impl Motion {
    /// A plant at rest.
    ///
    /// # Errors
    /// A setting out of its range.
    pub fn new(settings: &MotionSettings, vehicle: &Vehicle, step_s: f64, seed: u64) -> Result<Self> {
        Ok(match settings {
            MotionSettings::Physical(settings) => Self::Physical(PhysicalMotion::new(settings, vehicle, step_s, seed)?),
            MotionSettings::Identified(settings) => Self::Identified(IdentifiedMotion::new(settings, vehicle, step_s, seed)?),
        })
    }

    /// Speed now [m/s], vehicle frame.
    #[inline]
    pub fn speed_mps(&self) -> f64 {
        match self {
            Self::Physical(motion) => motion.speed_mps(),
            Self::Identified(motion) => motion.speed_mps(),
        }
    }

    /// Acceleration at the end of the last step [m/s²].
    #[inline]
    pub fn accel_mps2(&self) -> f64 {
        match self {
            Self::Physical(motion) => motion.accel_mps2(),
            Self::Identified(motion) => motion.accel_mps2(),
        }
    }

    /// Sets the speed at once [m/s].
    pub fn set_speed(&mut self, speed_mps: f64) {
        match self {
            Self::Physical(motion) => motion.set_speed(speed_mps),
            Self::Identified(motion) => motion.set_speed(speed_mps),
        }
    }

    /// Draws what differs from run to run.
    pub fn begin_run(&mut self) {
        match self {
            Self::Physical(motion) => motion.begin_run(),
            Self::Identified(motion) => motion.begin_run(),
        }
    }

    /// Whether the wheel angle makes no difference to it.
    #[inline]
    pub(crate) fn knows_one_angle(&self) -> bool {
        matches!(self, Self::Identified(_))
    }

    /// Tells the plant the wheel angle of the steps to come (the identified plant belongs to one angle and does not ask).
    pub fn set_angle(&mut self, angle: &AngleTerms) {
        if let Self::Physical(motion) = self {
            motion.set_angle(angle);
        }
    }

    /// Mass on which a slope acts along the wheel [kg].
    pub fn slope_mass_kg(&self) -> f64 {
        match self {
            Self::Physical(motion) => motion.slope_mass_kg(),
            Self::Identified(motion) => motion.slope_mass_kg(),
        }
    }

    /// Inertia of wheel and motor alone as mass at the rim [kg]: what spins up when the wheel slips.
    pub fn wheel_mass_kg(&self) -> f64 {
        match self {
            Self::Physical(motion) => motion.wheel_mass_kg(),
            Self::Identified(motion) => motion.wheel_mass_kg(),
        }
    }

    /// Advances one step.
    #[inline]
    pub fn step(&mut self, load: &Load) -> SpeedStep {
        match self {
            Self::Physical(motion) => motion.step(load),
            Self::Identified(motion) => motion.step(load),
        }
    }
}

/// One step of the classical Runge-Kutta method for v̇ = a(stage, v), stages 0, 1, 2 being start, middle and end of the step; the speed
/// half way by its continuous extension of third order. Returns the speeds and the acceleration at the end.
///
/// Source: Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, II.1 and II.6.
#[inline]
pub(crate) fn runge_kutta(step_s: f64, start_mps: f64, mut accel: impl FnMut(usize, f64) -> f64) -> (SpeedStep, f64) {
    let half = 0.5 * step_s;
    let k1 = accel(0, start_mps);
    let k2 = accel(1, start_mps + half * k1);
    let k3 = accel(1, start_mps + half * k2);
    let k4 = accel(2, start_mps + step_s * k3);
    let mid_mps = start_mps + step_s * (5.0 * k1 + 4.0 * (k2 + k3) - k4) * (1.0 / 24.0);
    let end_mps = start_mps + step_s * (k1 + 2.0 * (k2 + k3) + k4) * (1.0 / 6.0);
    (SpeedStep { start_mps, mid_mps, end_mps }, k4)
}
