//! A step of the delays and of the encoder's calibration: the nuisance coefficients of a solution, damped and bounded.

use crate::fit::drive::torque_input::TorqueInput;
use crate::fit::drive_form::campaign_drift::{CampaignDrift, SPANS};
use crate::fit::drive_form::drift_posterior::{CHANGES, DriftPosterior};
use crate::fit::drive_form::drive_model::{DriveKind, DriveModel};
use crate::fit::drive_form::parameters::{LIMIT, PARAMETERS};
use crate::fit::drive_form::torque_limit::TorqueLimit;
use crate::fit::motion::regressors::Free;
use crate::fit::nuisance;
use crate::fit::rounds::convergence::DelayStep;
use crate::fit::rounds::initial_guess::hold_known;
use crate::fit::rounds::state::State;
use crate::fit::solve::penalised_least_squares::{Solution, System, nuisance_prior_std};
use faer::Mat;

/// Largest step of a delay in one round [s].
const DELAY_STEP_S: f64 = 0.02;
/// Largest step of a parameter of the drive in one round, if that is more: a share of it.
const DRIVE_STEP: f64 = 0.2;
/// Largest step of the logarithm of a limit in one round.
const LIMIT_STEP: f64 = 0.05;
/// Prior standard deviation of the changes during a campaign, shares.
const MOST_DRIFT: f64 = 0.2;
/// Least number of standard errors at which such a change counts.
const CLEAR_DRIFT: f64 = 4.0;
/// Number of standard errors by which the lags by feedback and by speed may differ.
const AGREEING_STD_ERRS: f64 = 2.0;
/// Prior standard deviation of known values.
const FIXED_STD: f64 = 1e-9;

/// Largest step of a parameter of the drive in one round.
fn most_drive_step(drive: &DriveModel, parameter: usize) -> f64 {
    if parameter == LIMIT { LIMIT_STEP } else { DELAY_STEP_S.max(DRIVE_STEP * drive.times_s[parameter]) }
}

impl State<'_> {
    /// Prior standard deviations of the nuisance columns; values known from outside do not move.
    pub(crate) fn nuisance_prior(&self, free: Free) -> Vec<f64> {
        if free == Free::Surface {
            return Vec::new();
        }
        let known = self.settings.known.as_ref();
        let mut prior = nuisance_prior_std(self.logs.len(), self.has_yaw && free == Free::DelaysAndEncoder);
        let hold = |std: &mut f64| *std = FIXED_STD;
        let measured = self.logs.iter().any(|l| l.input != TorqueInput::Command);
        let drive = &self.calibration.drive;
        for (p, has) in drive.has().into_iter().enumerate() {
            let std = &mut prior[nuisance::DRIVE + p];
            *std = std.max(most_drive_step(drive, p));
            // a surface that is flat below a torque limit explains as much: the limit stays where the growth below puts it
            let stays = p == LIMIT && matches!(drive.limit, TorqueLimit::Torque(_));
            // a limit is not a part of what is given
            if !has || stays || measured || (p != LIMIT && self.drive_is_given()) {
                hold(std);
            }
        }
        for (k, drifts) in (nuisance::DRIFT_FRICTION..).zip(self.drifts) {
            prior[k] = if drifts && free == Free::DelaysAndDrift { MOST_DRIFT } else { FIXED_STD };
        }
        if known.is_some_and(|k| k.encoder.is_some()) {
            hold(&mut prior[nuisance::ENCODER_SCALE]);
            hold(&mut prior[nuisance::ENCODER_DELAY]);
        }
        for (std, log) in prior[nuisance::DEAD_TIME..].iter_mut().zip(&self.logs) {
            if known.is_some_and(|k| k.dead_time_s.contains_key(&log.survey.track.source.sha256)) {
                hold(std);
            }
        }
        prior
    }

    /// Adds the lag of a first-order drive by the torque feedback to the equations, as one more observation. A feedback has its own filter,
    /// or is that of the motor behind a gear: where the speeds alone give another lag, its standard error grows with the square of the
    /// difference in standard errors, so that it soon counts for nothing.
    pub(crate) fn observe_lag(&self, system: &mut System, prior: &[f64]) {
        let drive = &self.calibration.drive;
        let measured = self.logs.iter().any(|l| l.input != TorqueInput::Command);
        let Some((lag_s, std_err_s)) = self.feedback_lag else { return };
        if drive.kind != DriveKind::FirstOrder || measured || self.drive_is_given() {
            return;
        }
        let Some(alone) = system.solve(&self.design.blocks, &self.penalties, 0, prior) else { return };
        let k = system.design + nuisance::DRIVE;
        let step_s = lag_s - drive.times_s[0];
        let difference = (step_s - alone.beta[k]).abs() / std_err_s.hypot(alone.covariance[(k, k)].max(0.0).sqrt());
        system.observe(nuisance::DRIVE, step_s, std_err_s * (difference / AGREEING_STD_ERRS).powi(2).max(1.0));
    }

    /// Continues to estimate the clear changes during the campaign, and sets the others to zero; what `solution` says of all of them is
    /// kept. Returns what is free from now on.
    pub(crate) fn keep_clear_drifts(&mut self, solution: &Solution) -> Free {
        let from = self.design.coefficients() + nuisance::DRIFT_FRICTION;
        let covariance = Mat::from_fn(CHANGES, CHANGES, |a, b| solution.covariance[(from + a, from + b)]);
        let found = &self.calibration.drift;
        let all: [f64; CHANGES] = std::array::from_fn(|k| if k < SPANS { found.friction_share[k] } else { found.torque_share[k - SPANS] });
        self.shrunk_drift = DriftPosterior::new(all, &covariance, self.drifts).unwrap_or_default();
        let (found, std_err) = (&mut self.calibration.drift, &self.calibration_errors.drift);
        let changes = found.friction_share.iter_mut().chain(&mut found.torque_share);
        let errors = std_err.friction_share.iter().chain(&std_err.torque_share);
        for ((drifts, change), std_err) in self.drifts.iter_mut().zip(changes).zip(errors) {
            *drifts &= change.abs() > CLEAR_DRIFT * std_err;
            if !*drifts {
                *change = 0.0;
            }
        }
        if self.drifts == [false; CHANGES] { Free::Delays } else { Free::DelaysAndDrift }
    }

    /// Whether the drive's parameters are known from outside.
    fn drive_is_given(&self) -> bool {
        self.settings.lag_s.is_some() || self.settings.known.as_ref().is_some_and(|k| k.drive.is_some())
    }

    /// Makes the step of delays and encoder calibration that `solution` gives, and stores their standard errors. Returns the largest
    /// step of a delay over its standard error.
    pub(crate) fn calibrate(&mut self, solution: &Solution, free: Free) -> f64 {
        let q = self.design.coefficients();
        let of = |k: usize| solution.beta[q + k];
        // a long ramp is not known to milliseconds
        let drive = self.calibration.drive;
        let most_s = |k: usize| if k < PARAMETERS { most_drive_step(&drive, k) } else { DELAY_STEP_S };
        let step = |k: usize| of(k).clamp(-most_s(k), most_s(k));
        let before = self.calibration.clone();
        let delays = (nuisance::DRIVE..nuisance::ENCODER_SCALE).chain((0..self.logs.len()).map(|k| nuisance::DEAD_TIME + k));
        let damp = |(k, asked_s): (usize, f64)| DelayStep::damped(asked_s, self.last_steps.get(k));
        let steps: Vec<DelayStep> = delays.map(step).enumerate().map(damp).collect();
        self.calibration.drive = before.drive.moved(std::array::from_fn(|p| steps[p].made_s));
        for (dead_time_s, step) in self.calibration.dead_time_s.iter_mut().zip(&steps[PARAMETERS..]) {
            *dead_time_s = (*dead_time_s + step.made_s).clamp(-0.1, 0.5);
        }
        self.last_steps = steps;
        let drift = &mut self.calibration.drift;
        for k in 0..SPANS {
            drift.friction_share[k] += of(nuisance::DRIFT_FRICTION + k);
            drift.torque_share[k] += of(nuisance::DRIFT_TORQUE + k);
        }
        let std_err = |k: usize| solution.covariance[(q + k, q + k)].max(0.0).sqrt();
        self.calibration_errors.drive_s = std::array::from_fn(|p| std_err(nuisance::DRIVE + p));
        self.calibration_errors.dead_time_s = (0..self.logs.len()).map(|k| std_err(nuisance::DEAD_TIME + k)).collect();
        self.calibration_errors.drift = CampaignDrift {
            friction_share: std::array::from_fn(|k| std_err(nuisance::DRIFT_FRICTION + k)),
            torque_share: std::array::from_fn(|k| std_err(nuisance::DRIFT_TORQUE + k)),
        };
        if free == Free::DelaysAndEncoder {
            self.calibration_errors.encoder_scale = std_err(nuisance::ENCODER_SCALE);
            if self.has_yaw {
                self.calibration.encoder_scale *= 1.0 + of(nuisance::ENCODER_SCALE).clamp(-0.02, 0.02);
                let delay_s = self.calibration.encoder_delay_s + step(nuisance::ENCODER_DELAY);
                self.calibration.encoder_delay_s = delay_s.clamp(-0.3, 0.3);
            }
        }
        hold_known(&mut self.calibration, &self.logs, &self.settings);
        let (now, std_err) = (&self.calibration, &self.calibration_errors);
        let moved = before.dead_time_s.iter().zip(&now.dead_time_s).zip(&std_err.dead_time_s).map(|((a, b), error)| (b - a).abs() / error);
        let (from, to, has) = (before.drive.parameters(), now.drive.parameters(), now.drive.has());
        let by_drive = (0..PARAMETERS).filter(|p| has[*p]).map(|p| (to[p] - from[p]).abs() / std_err.drive_s[p]);
        moved.chain(by_drive).fold(0.0, f64::max)
    }
}
