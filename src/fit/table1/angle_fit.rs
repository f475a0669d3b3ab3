//! One fit at one wheel angle: the estimate, its surface made monotone, its tables, and the reasons against them.

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

/// Results of a fit at one wheel angle.
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
    /// Notes on the estimate, for the reader.
    pub(crate) remarks: Vec<String>,
    /// The reasons against the tables; none when they are sound.
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

    /// All notes for the reader, in the order of the report, except the logs' own.
    pub(crate) fn notes(&self) -> impl Iterator<Item = String> {
        let disagreements = disagreements(&self.figures.rows);
        self.remarks.iter().chain(&self.objections).cloned().chain(disagreements)
    }
}

fn remarks(estimate: &Estimate, monotone: monotone::MonotoneOutcome) -> Vec<String> {
    let mut remarks = Vec::new();
    if monotone == monotone::MonotoneOutcome::Forced {
        remarks.push(
            "the surface did not rise with torque everywhere and was corrected (by running maxima): check the runs near its flat places"
                .to_owned(),
        );
    }
    if !estimate.rounds.converged {
        remarks.push(format!("the fit stopped after {} iterations before the surface converged", estimate.rounds.count));
    }
    for bound in &estimate.noise_bounds {
        remarks.push(format!("noise model: {bound} is at its bound"));
    }
    for log in &estimate.data.logs {
        if let Some(rate_hz) = slow_rate_hz(log.survey) {
            remarks.push(format!(
                "{}: the encoder is slow ({rate_hz:.1} Hz), so the speeds come from the yaw rate; the cells have few samples",
                log.survey.track.source.file
            ));
        }
    }
    if let Some(coarse) = estimate.data.logs.iter().find(|l| l.coarse_mps[0] > 0.0) {
        remarks.push(format!(
            "{}: the speed comes in steps of {:.3} m/s without noise: each reading counts as an interval",
            coarse.survey.track.source.file, coarse.coarse_mps[0]
        ));
    }
    remarks
}
