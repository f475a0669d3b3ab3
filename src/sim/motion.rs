//! Motion: effective torque → front-wheel speed, either by the physics of a vehicle or by a fitted Table 1.

use crate::map::Vehicle;
use crate::sim::WheelAngleTerms;
use crate::sim::error::Result;
use crate::sim::identified::{IdentifiedMotion, IdentifiedSettings};
use crate::sim::load::Load;
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
    pub fn set_angle(&mut self, angle: &WheelAngleTerms) {
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
