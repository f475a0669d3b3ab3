//! One fit at one wheel angle: the estimate, its surface made monotone, its tables, and what speaks against them.

use crate::campaign::{AngleGroup, SampleVerdict};
use crate::fit::drive::torque_input::TorqueChoice;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::rounds::initial_guess::slow_rate_hz;
use crate::fit::solve::monotone;
use crate::fit::table1::runs::{Compared, RunFigures, disagreements, run_figures, simulate};
use crate::fit::table1::soundness::objections;
use crate::fit::table1::standard_errors::Uncertainty;
use crate::fit::table1::tables::{UsedSample, accel_map, used_samples, verdicts};
use crate::fit::{FitSettings, Result, rounds};
use crate::map::AccelMap;

/// What a fit at one wheel angle gives.
pub(crate) struct AngleFit<'a> {
    /// The wheel angle of the runs [°], left positive.
    pub(crate) wheel_angle_deg: f64,
    pub(crate) estimate: Estimate<'a>,
    /// How the surface was made to rise with torque.
    pub(crate) monotone: monotone::MonotoneOutcome,
    /// The final verdict on every encoder sample, per log.
    pub(crate) verdicts: Vec<Vec<SampleVerdict>>,
    /// The used samples.
    pub(crate) samples: Vec<UsedSample>,
    /// Table 1 of each gear.
    pub(crate) maps: Vec<AccelMap>,
    /// Every reading against its simulation.
    pub(crate) compared: Vec<Compared>,
    /// The runs.
    pub(crate) figures: RunFigures,
    /// What a reader should know of the estimate.
    pub(crate) remarks: Vec<String>,
    /// What speaks against the tables; nothing when they are sound.
    pub(crate) objections: Vec<String>,
}

impl<'a> AngleFit<'a> {
    /// Fits the surveys of one wheel angle; files are named as for a vehicle with `test_angle_deg`.
    ///
    /// # Errors
    /// A slow speed signal without a yaw rate, too little motion, one torque only, equations without information.
    pub(crate) fn new(group: &'a AngleGroup, choice: &TorqueChoice, settings: &FitSettings, test_angle_deg: f64) -> Result<Self> {
        let mut estimate = rounds::estimate(&group.surveys, choice, settings)?;
        let monotone = estimate.model.make_monotone(&estimate.data.gears);
        let uncertainty = Uncertainty::new(&estimate);
        let samples = used_samples(&estimate);
        let angles_deg = (group.wheel_angle_deg, test_angle_deg);
        let table = |gear| accel_map(&estimate, &uncertainty, gear, settings, &samples, angles_deg);
        let maps: Vec<AccelMap> = estimate.data.gears.iter().copied().map(table).collect::<Result<_>>()?;
        let objections = objections(&estimate, &maps, &samples, settings);
        let verdicts = verdicts(&estimate);
        let compared = simulate(&estimate);
        let figures = run_figures(&estimate, &compared, &verdicts);
        let remarks = remarks(&estimate, monotone);
        let wheel_angle_deg = group.wheel_angle_deg;
        Ok(Self { wheel_angle_deg, estimate, monotone, verdicts, samples, maps, compared, figures, remarks, objections })
    }

    /// Everything that a reader should know, in the order of the report, but for the logs' own notes.
    pub(crate) fn notes(&self) -> impl Iterator<Item = String> {
        let disagreements = disagreements(&self.figures.rows);
        self.remarks.iter().chain(&self.objections).cloned().chain(disagreements)
    }
}

fn remarks(estimate: &Estimate, monotone: monotone::MonotoneOutcome) -> Vec<String> {
    let mut remarks = Vec::new();
    if monotone == monotone::MonotoneOutcome::Forced {
        remarks.push("the surface was made to rise with torque by running maxima: the data contradict it in places".to_owned());
    }
    if !estimate.rounds.converged {
        remarks.push(format!("the fit stopped after {} iterations before the surface stood still", estimate.rounds.count));
    }
    for bound in &estimate.noise_bounds {
        remarks.push(format!("noise model: {bound} is at its bound"));
    }
    for log in &estimate.data.logs {
        if let Some(rate_hz) = slow_rate_hz(log.survey) {
            remarks.push(format!(
                "{}: the speed signal is slow ({rate_hz:.1} Hz): the yaw rate tells the speeds; cells count its samples and stay thin",
                log.survey.track.source.file
            ));
        }
    }
    if let Some(low) = estimate.data.logs.iter().find(|l| !l.may_anchor) {
        remarks.push(format!("{}: speed is too coarse to tell when a start from rest begins", low.survey.track.source.file));
    }
    remarks
}
