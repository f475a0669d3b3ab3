//! What the rounds have found so far.

use crate::fit::noise::model::Noise;
use crate::fit::surface::lattice::LatticeSurface;
use crate::map::{Gear, PerGear};

/// Surfaces and noise as found so far.
#[derive(Clone, Copy)]
pub(crate) struct SoFar<'a> {
    /// Forward, reverse.
    pub(crate) surfaces: &'a PerGear<LatticeSurface>,
    pub(crate) noise: &'a Noise,
}

impl<'a> SoFar<'a> {
    /// The surface of a gear.
    pub(crate) fn surface(&self, gear: Gear) -> &'a LatticeSurface {
        &self.surfaces[gear]
    }
}
