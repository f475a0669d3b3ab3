//! The campaign still to drive: which runs shrink the standard errors of the torque map most per second.
//!
//! Greedy A-optimal design (Fedorov 1972, *Theory of Optimal Experiments*; Chaloner & Verdinelli 1995, *Bayesian experimental design*): the
//! information of a run is the Gram matrix of its whitened regressors, the very columns of the estimator, along the way that the fitted
//! surface predicts; the criterion is the mean posterior variance of the torque over the table's cells. Everything comes from
//! `table1.json`: the runs driven so far are simulated in the same way, and the penalties are those that the fit chose.

mod drive;
mod greedy;
mod information;
mod text;

use super::{Error, Result};
use crate::map::{Gear, Table1File};
use drive::{Candidate, Vehicle};
use greedy::Greedy;
use information::{Information, Model};
use rayon::prelude::*;
use serde::Serialize;

/// What a plan may spend.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanSettings {
    /// Time of driving [s], with spin-ups, stops and pauses. Default 300.
    pub budget_s: f64,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self { budget_s: 300.0 }
    }
}

/// A campaign still to drive, the most useful runs first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// What was asked for [s].
    pub budget_s: f64,
    /// What the runs are expected to take [s].
    pub seconds: f64,
    /// Number of runs, repeats counted.
    pub runs: u32,
    /// Root mean square over the cells of the torque's standard error [N·m]: now, ...
    pub std_err_nm: f64,
    /// ... and expected after the plan.
    pub std_err_after_nm: f64,
    /// The runs, by falling gain per second.
    pub entries: Vec<PlanEntry>,
}

/// A run, and how often it is driven.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanEntry {
    /// Gear.
    pub gear: Gear,
    /// Torque [N·m], gear frame.
    pub torque_nm: f64,
    /// Speed from which it is applied [m/s]; 0 is from rest.
    pub start_speed_mps: f64,
    /// Torque of the spin-up to that speed [N·m]; absent from rest.
    pub spin_up_nm: Option<f64>,
    /// The level ends at this speed [m/s].
    pub speed_limit_mps: f64,
    /// How often.
    pub repeats: u32,
    /// Time of one run with everything around it [s].
    pub seconds: f64,
    /// What the first of these runs takes off the standard error, root mean square over the cells [N·m], ...
    pub gain_nm: f64,
    /// ... as share of what it was before that run [%], ...
    pub gain_percent: f64,
    /// ... and per second of driving [N·m/s].
    pub gain_nm_per_s: f64,
    /// Which cells gain most, and how well they are known before.
    pub reason: String,
}

/// Plans the campaign still to drive after the one behind `file`.
///
/// # Errors
/// A budget that is not positive or that no run fits, no tables, runs or tables that tell no motion.
pub fn plan(file: &Table1File, settings: &PlanSettings) -> Result<Plan> {
    let model = Model::new(file)?;
    let candidates: Vec<(Candidate, f64, Information)> = model
        .vehicles
        .iter()
        .flat_map(|vehicle| vehicle.candidates(&model.levels_nm).into_iter().map(move |c| (vehicle, c)))
        .collect::<Vec<(&Vehicle, Candidate)>>()
        .into_par_iter()
        .filter_map(|(vehicle, candidate)| {
            let driven = vehicle.drive(&candidate)?;
            let information = model.information(candidate.gear, &driven.parts);
            Some((candidate, driven.seconds, information))
        })
        .collect();
    let covariance = model.covariance(file)?;
    let cells = model.cells();
    let mut greedy = Greedy::new(&model, &covariance, &candidates, &cells);
    let std_err_nm = greedy.std_err_nm();
    let mut left_s = settings.budget_s;
    let mut picked: Vec<(usize, PlanEntry)> = Vec::new();
    while let Some(best) = greedy.best(left_s) {
        let (candidate, seconds, _) = &candidates[best];
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
                    gear: candidate.gear,
                    torque_nm: candidate.torque_nm,
                    start_speed_mps: candidate.start_speed_mps,
                    spin_up_nm: (candidate.start_speed_mps > 0.0).then_some(candidate.spin_up_nm),
                    speed_limit_mps: candidate.speed_limit_mps,
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
    Ok(Plan {
        budget_s: settings.budget_s,
        seconds: settings.budget_s - left_s,
        runs: entries.iter().map(|e| e.repeats).sum(),
        std_err_nm,
        std_err_after_nm: greedy.std_err_nm(),
        entries,
    })
}
