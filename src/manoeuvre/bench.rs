//! What a manoeuvre is driven with.

use crate::manoeuvre::planned::Planned;
use crate::manoeuvre::torque::ManoeuvreTorque;
use crate::verify::Maps;

/// What a manoeuvre is run with.
#[derive(Debug, Clone)]
pub(crate) struct Bench<'a> {
    /// The map, with the compensation table if the folder has one.
    pub(crate) maps: &'a Maps,
    /// Torque for speed, acceleration and angle.
    pub(crate) torque: ManoeuvreTorque<'a>,
    /// Wheelbase [m].
    pub(crate) wheelbase_m: f64,
    /// The plan of a planned task, made once for all of its runs.
    pub(crate) planned: Option<&'a Planned>,
}
