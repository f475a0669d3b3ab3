//! One fit at one wheel angle: the estimate, its surface made monotone, its tables, and what speaks against them.

use crate::campaign::{Survey, Verdict};
use crate::fit::drive::torque_input::Choice;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::rounds::initial_guess::slow_rate_hz;
use crate::fit::rounds::search::estimate;
use crate::fit::solve::monotone;
use crate::fit::table1::runs::{Compared, RunFigures, disagreements, run_figures, simulate};
use crate::fit::table1::soundness::objections;
use crate::fit::table1::standard_errors::Uncertainty;
use crate::fit::table1::tables::{UsedSample, accel_map, used_samples, verdicts};
use crate::fit::{Result, Settings};
use crate::map::{AccelMap, Gear};

/// What a fit at one wheel angle gives.
pub(crate) struct Part<'a> {
    pub(crate) estimate: Estimate<'a>,
    /// How the surface was made to rise with torque.
    pub(crate) monotone: monotone::Outcome,
    /// The final verdict on every encoder sample, per log.
    pub(crate) verdicts: Vec<Vec<Verdict>>,
    /// The used samples.
    pub(crate) samples: Vec<UsedSample>,
    /// Table 1 of each gear, with its CSV.
    pub(crate) maps: Vec<(AccelMap, String)>,
    /// Every reading against its simulation.
    pub(crate) compared: Vec<Compared>,
    /// The runs.
    pub(crate) figures: RunFigures,
    /// What a reader should know of the logs and the estimate.
    pub(crate) remarks: Vec<String>,
    /// What speaks against the tables; nothing when they are sound.
    pub(crate) objections: Vec<String>,
}

impl<'a> Part<'a> {
    /// Fits the surveys of one wheel angle, which is their tracks' test angle; files are named as for a vehicle with `test_angle_deg`.
    pub(crate) fn new(surveys: &'a [Survey], choice: &Choice, settings: &Settings, test_angle_deg: f64) -> Result<Self> {
        let mut estimate = estimate(surveys, choice, settings)?;
        let mut remarks: Vec<String> =
            surveys.iter().flat_map(|s| s.track.notes.iter().map(|n| format!("{}: {n}", s.track.source.file))).collect();
        remarks.extend(choice.note());
        let monotone = make_monotone(&mut estimate, &mut remarks);
        remarks.extend(estimate_notes(&estimate));
        let uncertainty = Uncertainty::new(&estimate);
        let verdicts = verdicts(&estimate);
        let samples = used_samples(&estimate);
        let angles_deg = (surveys[0].track.vehicle.test_angle_deg, test_angle_deg);
        let maps: Vec<(AccelMap, String)> = estimate
            .gears
            .iter()
            .map(|gear| accel_map(&estimate, &uncertainty, *gear, settings, &samples, angles_deg))
            .collect::<Result<_>>()?;
        let tables: Vec<AccelMap> = maps.iter().map(|(map, _)| map.clone()).collect();
        let objections = objections(&estimate, &tables, &samples, settings);
        let compared = simulate(&estimate);
        let figures = run_figures(&estimate, &compared, &verdicts);
        Ok(Self { estimate, monotone, verdicts, samples, maps, compared, figures, remarks, objections })
    }

    /// Everything that a reader should know, in the order of the report.
    pub(crate) fn notes(&self) -> Vec<String> {
        let disagreements = disagreements(&self.figures.rows);
        self.remarks.iter().chain(&self.objections).cloned().chain(disagreements).collect()
    }
}

fn make_monotone(estimate: &mut Estimate, notes: &mut Vec<String>) -> monotone::Outcome {
    let lattice = estimate.surfaces[0].lattice.clone();
    let mut beta = estimate.stacked.solution.beta.clone();
    let outcome = monotone::enforce(&estimate.design, &lattice, &estimate.system, &estimate.stacked.solution, &estimate.gears, &mut beta);
    match outcome {
        monotone::Outcome::AlreadyMonotone => {}
        monotone::Outcome::Moved(_) => {
            estimate.stacked.solution.beta = beta;
            let q = estimate.design.coefficients();
            for gear in Gear::ALL {
                estimate.surfaces[usize::from(gear == Gear::Reverse)].theta =
                    estimate.design.lattice_values(gear, &estimate.stacked.solution.beta[..q]);
            }
        }
        monotone::Outcome::Forced => {
            for surface in &mut estimate.surfaces {
                monotone::force(&lattice, &mut surface.theta);
            }
            notes.push("the surface was made to rise with torque by running maxima: the data contradict it in places".to_owned());
        }
    }
    outcome
}

fn estimate_notes(estimate: &Estimate) -> Vec<String> {
    let mut notes = Vec::new();
    if !estimate.converged {
        notes.push(format!("the fit stopped after {} iterations before the surface stood still", estimate.iterations));
    }
    for bound in &estimate.noise_bounds {
        notes.push(format!("noise model: {bound} is at its bound"));
    }
    for log in &estimate.logs {
        if let Some(rate_hz) = slow_rate_hz(log.survey) {
            notes.push(format!(
                "{}: the speed signal is slow ({rate_hz:.1} Hz): the yaw rate tells the speeds; cells count its samples and stay thin",
                log.survey.track.source.file
            ));
        }
    }
    if let Some(low) = estimate.logs.iter().find(|l| !l.may_anchor) {
        notes.push(format!("{}: speed is too coarse to tell when a start from rest begins", low.survey.track.source.file));
    }
    notes
}
