//! The next campaign: the runs that reduce the standard errors of the torque map most per second.
//!
//! Greedy A-optimal design (Fedorov 1972, *Theory of Optimal Experiments*; Chaloner & Verdinelli 1995, *Bayesian experimental design*). The
//! information of a run is the Gram matrix of its whitened regressors, the columns of the estimator, along the run predicted by the fitted
//! surface. The criterion is the mean posterior variance of the torque over the table's cells. All data come from `table1.json`: the runs
//! driven so far are simulated in the same way, and the penalties are those that the fit chose.

mod drive;
pub(crate) mod expected;
mod greedy;
mod information;
mod settings;
mod to_campaign;

use crate::fit::{Error, Result};
use crate::map::Table1File;
pub use crate::map::{PlanEntry, PlannedRun, Proposal};
use greedy::Greedy;
use information::{Information, Model};
use rayon::prelude::*;
pub use settings::PlanSettings;

/// Turning the wheel to its angle before the first run [s].
const STEER_S: f64 = 2.0;

/// Plans the next campaign after that of `file`.
///
/// # Errors
/// A budget that is not positive or that no run fits, no tables, runs or tables that show no motion.
pub fn plan(file: &Table1File, settings: &PlanSettings) -> Result<Proposal> {
    let model = Model::new(file, settings)?;
    let runs: Vec<PlannedRun> = model.vehicles.iter().flat_map(|vehicle| vehicle.candidates(&model.levels_nm)).collect();
    let candidates = informed(&model, &runs);
    let covariance = model.covariance(file)?;
    let cells = model.cells();
    let mut greedy = Greedy::new(&model, &covariance, &candidates, &cells);
    let std_err_nm = greedy.std_err_nm();
    let mut left_s = settings.budget_s - STEER_S;
    let mut picked: Vec<(usize, PlanEntry)> = Vec::new();
    while let Some(best) = greedy.best(left_s) {
        let (run, seconds, _) = &candidates[best];
        let before = greedy.std_err_nm();
        let reason = greedy.reason(best, &cells);
        greedy.take(best);
        let gain_nm = before - greedy.std_err_nm();
        left_s -= seconds;
        match picked.iter_mut().find(|(k, _)| *k == best) {
            Some((_, entry)) => entry.repeats += 1,
            None => picked.push((
                best,
                PlanEntry {
                    run: *run,
                    repeats: 1,
                    seconds: (seconds * 100.0).round() / 100.0,
                    gain_nm,
                    gain_percent: 100.0 * gain_nm / before,
                    gain_nm_per_s: gain_nm / seconds,
                    reason,
                },
            )),
        }
    }
    if picked.is_empty() {
        return Err(Error::NoPlan { budget_s: settings.budget_s });
    }
    let entries: Vec<PlanEntry> = picked.into_iter().map(|(_, entry)| entry).collect();
    Ok(Proposal {
        budget_s: settings.budget_s,
        seconds: settings.budget_s - left_s,
        runs: entries.iter().map(|e| e.repeats).sum(),
        std_err_nm,
        std_err_after_nm: greedy.std_err_nm(),
        entries,
    })
}

/// Runs with their time [s] and their information; those that cannot be driven are skipped.
fn informed(model: &Model, runs: &[PlannedRun]) -> Vec<(PlannedRun, f64, Information)> {
    runs.par_iter()
        .filter_map(|run| {
            let driven = model.vehicles.iter().find(|v| v.gear == run.gear)?.drive(run)?;
            Some((*run, driven.seconds, model.information(run.gear, &driven.parts, 1)))
        })
        .collect()
}
