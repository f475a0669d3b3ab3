//! What a scenario is driven with, and what is seen of it.

use crate::control::{Outputs, PivotSettings};
use crate::sim::{Measurement, TrueState};
use crate::verify::measured_region::Region;

/// What a run needs to know of the vehicle under test.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PivotBench<'a> {
    /// Settings of the controller; the scenario's policy replaces theirs.
    pub(crate) control: &'a PivotSettings,
    /// Control period [s].
    pub(crate) period_s: f64,
    /// Torque limit [N·m].
    pub(crate) torque_limit_nm: f64,
    /// Breakaway torque of the map [N·m].
    pub(crate) breakaway_nm: f64,
    /// Torque that holds half of the cruise speed, and torque that accelerates there as planned [N·m].
    pub(crate) planned_nm: [f64; 2],
    /// Where Table 2 was measured.
    pub(crate) region: &'a Region,
}

/// One control period of a run, for a log or a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PivotMoment {
    /// The truth at the start of the period.
    pub state: TrueState,
    /// What the controller read.
    pub seen: Measurement,
    /// What it commanded.
    pub command: Outputs,
}
