//! Settings of the manoeuvres.

use crate::controller::ControllerSettings;
use crate::manoeuvre::Result;
use crate::manoeuvre::scenario::Manoeuvre;
use crate::sim;
use crate::sim::VehicleFile;
use crate::verify::{Gate, Spread};

/// Settings of the manoeuvres.
#[derive(Debug, Clone, PartialEq)]
pub struct ManoeuvreSettings {
    /// The manoeuvres. Default none: they judge the vehicle's other maps and laws, and take longer than all pivots.
    pub manoeuvres: Vec<Manoeuvre>,
    /// Perturbed vehicles per manoeuvre. Default 20: a manoeuvre takes a hundred times as long as a pivot.
    pub draws: usize,
    /// The physical vehicle. Default the bundled scrubber.
    pub vehicle: sim::WorldSettings,
    /// How far it is perturbed.
    pub spread: Spread,
    /// Seed of everything random. Default 1.
    pub seed: u64,
    /// The limits.
    pub gate: Gate,
    /// Settings of the controller; those of path tracking and of the turns on the spot are used. Default that of the program.
    pub controller: ControllerSettings,
}

impl ManoeuvreSettings {
    /// The defaults.
    ///
    /// # Errors
    /// None in practice: vehicle and gate are part of the program.
    pub fn new() -> Result<Self> {
        Ok(Self {
            manoeuvres: Vec::new(),
            draws: 20,
            vehicle: VehicleFile::bundled()?.settings(),
            spread: Spread::default(),
            seed: 1,
            gate: Gate::with(None)?,
            controller: ControllerSettings::default(),
        })
    }
}
