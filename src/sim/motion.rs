//! Motion: effective torque → front-wheel speed, from the physics of a vehicle or from a fitted Table 1.

use crate::map::Vehicle;
use crate::sim::WheelAngleTerms;
use crate::sim::error::Result;
use crate::sim::identified::{IdentifiedMotion, IdentifiedSettings};
use crate::sim::load::Load;
use crate::sim::physical::PhysicalMotion;
use crate::sim::plant::PhysicalSettings;
use crate::sim::pose::SpeedStep;

/// The kind of plant, and its settings.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionSettings {
    /// Inertia, friction, scrub.
    Physical(PhysicalSettings),
    /// Table 1 of a fit.
    Identified(Box<IdentifiedSettings>),
}

/// The plant's state: front-wheel speed and its random parts.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)] // one per world: a box would only add an indirection to every step
pub(crate) enum Motion {
    /// Inertia, friction, scrub.
    Physical(PhysicalMotion),
    /// Table 1 of a fit.
    Identified(IdentifiedMotion),
}

impl Motion {
    /// A plant at rest.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub(crate) fn new(settings: &MotionSettings, vehicle: &Vehicle, step_s: f64, seed: u64) -> Result<Self> {
        Ok(match settings {
            MotionSettings::Physical(settings) => Self::Physical(PhysicalMotion::new(settings, vehicle, step_s, seed)?),
            MotionSettings::Identified(settings) => Self::Identified(IdentifiedMotion::new(settings, vehicle, step_s, seed)?),
        })
    }

    /// Current speed [m/s], vehicle frame.
    #[inline]
    pub(crate) fn speed_mps(&self) -> f64 {
        match self {
            Self::Physical(motion) => motion.speed_mps(),
            Self::Identified(motion) => motion.speed_mps(),
        }
    }

    /// Acceleration at the end of the last step [m/s²].
    #[inline]
    pub(crate) fn accel_mps2(&self) -> f64 {
        match self {
            Self::Physical(motion) => motion.accel_mps2(),
            Self::Identified(motion) => motion.accel_mps2(),
        }
    }

    /// Sets the speed directly [m/s].
    pub(crate) fn set_speed(&mut self, speed_mps: f64) {
        match self {
            Self::Physical(motion) => motion.set_speed(speed_mps),
            Self::Identified(motion) => motion.set_speed(speed_mps),
        }
    }

    /// Draws the values that differ between runs.
    pub(crate) fn begin_run(&mut self) {
        match self {
            Self::Physical(motion) => motion.begin_run(),
            Self::Identified(motion) => motion.begin_run(),
        }
    }

    /// Whether it ignores the wheel angle.
    #[inline]
    pub(crate) fn knows_one_angle(&self) -> bool {
        matches!(self, Self::Identified(_))
    }

    /// Sets the wheel angle of the next steps (the identified plant belongs to one angle and ignores it).
    pub(crate) fn set_angle(&mut self, angle: &WheelAngleTerms) {
        if let Self::Physical(motion) = self {
            motion.set_angle(angle);
        }
    }

    /// Mass on which a slope acts along the wheel [kg].
    pub(crate) fn slope_mass_kg(&self) -> f64 {
        match self {
            Self::Physical(motion) => motion.slope_mass_kg(),
            Self::Identified(motion) => motion.slope_mass_kg(),
        }
    }

    /// Torque that the drive delivers of a requested one now [N·m]; that of a physical vehicle's power limit and governor.
    pub(crate) fn delivered_nm(&self, torque_nm: f64) -> f64 {
        match self {
            Self::Physical(motion) => motion.delivered_nm(torque_nm),
            Self::Identified(_) => torque_nm,
        }
    }

    /// Inertia of wheel and motor alone as mass at the rim [kg]: it spins up when the wheel slips.
    pub(crate) fn wheel_mass_kg(&self) -> f64 {
        match self {
            Self::Physical(motion) => motion.wheel_mass_kg(),
            Self::Identified(motion) => motion.wheel_mass_kg(),
        }
    }

    /// Advances one step.
    #[inline]
    pub(crate) fn step(&mut self, load: &Load) -> SpeedStep {
        match self {
            Self::Physical(motion) => motion.step(load),
            Self::Identified(motion) => motion.step(load),
        }
    }
}
