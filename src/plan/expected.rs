//! The expected result of a plan: the standard error of each cell after its runs.

use crate::fit::Result;
use crate::map::{Gear, PlannedRun, Table1File};
use crate::plan::greedy::Greedy;
use crate::plan::information::Model;
use crate::plan::{PlanSettings, informed};
use serde::Serialize;

/// Certainty of a cell's torque.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExpectedCell {
    /// Gear.
    pub gear: Gear,
    /// Speed [m/s].
    pub speed_mps: f64,
    /// Torque [N·m], gear frame.
    pub torque_nm: f64,
    /// Expected standard error [N·m].
    pub std_err_nm: f64,
}

/// Expected standard errors of the cells after `runs` are driven in addition to those of `file`, by the same model as [`crate::plan::plan`]. A run that
/// the vehicle cannot drive adds nothing.
///
/// # Errors
/// As [`crate::plan::plan`].
pub fn expected(file: &Table1File, settings: &PlanSettings, runs: &[PlannedRun]) -> Result<Vec<ExpectedCell>> {
    let model = Model::new(file, settings)?;
    let informed = informed(&model, runs);
    let cells = model.cells();
    let mut greedy = Greedy::new(&model, &model.covariance(file)?, &informed, &cells);
    for k in 0..informed.len() {
        greedy.take(k);
    }
    let known = cells.iter().zip(greedy.std_errs_nm());
    Ok(known.map(|(c, std_err_nm)| ExpectedCell { gear: c.gear, speed_mps: c.speed_mps, torque_nm: c.torque_nm, std_err_nm }).collect())
}
