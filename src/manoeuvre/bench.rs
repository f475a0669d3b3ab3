//! What a manoeuvre is driven with.

use crate::manoeuvre::Result;
use crate::manoeuvre::planned_task::Planned;
use crate::manoeuvre::torque::ManoeuvreTorque;
use crate::sim;
use crate::verify::Maps;

/// What a manoeuvre is run with.
#[derive(Debug, Clone)]
pub(crate) struct ManoeuvreBench<'a> {
    /// The map, with the compensation table if the folder has one.
    pub(crate) maps: &'a Maps,
    /// Torque for speed, acceleration and angle.
    pub(crate) torque: ManoeuvreTorque<'a>,
    /// Wheelbase [m].
    pub(crate) wheelbase_m: f64,
    /// The plan of a planned task, made once for all of its runs.
    pub(crate) planned: Option<&'a Planned>,
}

impl<'a> ManoeuvreBench<'a> {
    /// Of a map and a physical vehicle, without a plan.
    ///
    /// # Errors
    /// A vehicle that cannot be simulated.
    pub(crate) fn new(maps: &'a Maps, vehicle: &sim::WorldSettings) -> Result<Self> {
        Ok(Self { maps, torque: ManoeuvreTorque::new(Some(maps), vehicle)?, wheelbase_m: vehicle.vehicle.wheelbase_m, planned: None })
    }
}
