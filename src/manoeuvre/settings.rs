//! Which manoeuvres are driven, and how.

use crate::manoeuvre::Result;
use crate::manoeuvre::scenario::Manoeuvre;
use crate::sim;
use crate::sim::VehicleFile;
use crate::verify::{Gate, Spread};

/// Which manoeuvres are driven, and how.
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
        })
    }
}
