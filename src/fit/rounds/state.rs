//! The state of the rounds, from one to the next.

use crate::fit::FitSettings;
use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive_form::campaign_drift::{CampaignDrift, Progress};
use crate::fit::drive_form::drift_posterior::{CHANGES, DriftPosterior};
use crate::fit::drive_form::parameters::PARAMETERS;
use crate::fit::motion::coarse_readings::replace_coarse;
use crate::fit::motion::integration::Course;
use crate::fit::motion::log_data::LogData;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::merging::merged;
use crate::fit::motion::noise_likelihood;
use crate::fit::motion::passes::{Pass, PassResult, wide_speeds};
use crate::fit::motion::segment::Segment;
use crate::fit::motion::segmentation::all_segments;
use crate::fit::motion::so_far::SoFar;
use crate::fit::noise::model::Noise;
use crate::fit::rounds::convergence::DelayStep;
use crate::fit::rounds::estimate::CalibrationErrors;
use crate::fit::rounds::initial_guess::InitialGuess;
use crate::fit::rounds::outliers::Judge;
use crate::fit::solve::penalised_least_squares::Solution;
use crate::fit::surface::design::{Design, STRIBECK_MPS};
use crate::fit::surface::lattice::LatticeSurface;
use crate::map::{Gear, PerGear};

/// The state from one round to the next.
pub(crate) struct State<'a> {
    pub(crate) settings: FitSettings,
    pub(crate) logs: Vec<LogData<'a>>,
    /// The end of the campaign.
    pub(crate) end: PerGear<Progress>,
    pub(crate) gears: Vec<Gear>,
    pub(crate) has_yaw: bool,
    pub(crate) calibration: Calibration,
    pub(crate) calibration_errors: CalibrationErrors,
    pub(crate) noise: Noise,
    /// Parameters of the noise that lie at a bound.
    pub(crate) noise_bounds: Vec<&'static str>,
    pub(crate) design: Design,
    /// Forward, reverse; zero before the first round.
    pub(crate) surfaces: PerGear<LatticeSurface>,
    pub(crate) penalties: Vec<f64>,
    /// Lag of the drive by the torque feedback, with its standard error [s].
    pub(crate) feedback_lag: Option<(f64, f64)>,
    /// Which changes are estimated: of friction, then of torque, each over the campaign and over each log.
    pub(crate) drifts: [bool; CHANGES],
    /// All changes as far as the data show them, before the clear ones are chosen.
    pub(crate) shrunk_drift: DriftPosterior,
    /// Rounds so far.
    pub(crate) rounds: usize,
    /// The last step of the lag and of each dead time.
    pub(crate) last_steps: Vec<DelayStep>,
}

/// The data of a round.
pub(crate) struct RoundData {
    /// Moments after steps that are skipped, per log [s].
    pub(crate) transients: Vec<Vec<(f64, f64)>>,
    pub(crate) segments: Vec<Segment>,
    /// The same with merged readings.
    pub(crate) merged: Vec<Segment>,
}

impl<'a> State<'a> {
    /// Before the first round, from a first guess.
    pub(crate) fn from_guess(guess: InitialGuess<'a>, settings: &FitSettings) -> Self {
        let InitialGuess { logs, end, gears, has_yaw, calibration, noise, lattice, feedback_lag, .. } = guess;
        let design = Design::new(&lattice, gears.len() > 1, STRIBECK_MPS);
        let zero = LatticeSurface { theta: vec![0.0; lattice.columns()], lattice };
        let calibration_errors = CalibrationErrors {
            dead_time_s: vec![0.0; logs.len()],
            drive_s: [0.0; PARAMETERS],
            drift: CampaignDrift::default(),
            encoder_scale: 0.0,
        };
        Self {
            settings: settings.clone(),
            logs,
            end,
            gears,
            has_yaw,
            calibration,
            calibration_errors,
            noise,
            noise_bounds: Vec::new(),
            design,
            surfaces: PerGear { forward: zero.clone(), reverse: zero },
            penalties: Vec::new(),
            feedback_lag,
            drifts: [false; CHANGES],
            shrunk_drift: DriftPosterior::default(),
            rounds: 0,
            last_steps: Vec::new(),
        }
    }

    /// Whether a round has been made.
    fn has_surface(&self) -> bool {
        self.rounds > 0
    }

    /// The effective torque of each log.
    pub(crate) fn torques(&self) -> Vec<EffectiveTorque> {
        self.logs.iter().map(|l| l.torque(&self.calibration.drive, self.calibration.drift)).collect()
    }

    /// A pass with the surface and the noise as they are.
    pub(crate) fn pass<'b>(&'b self, courses: &'b [Course<'b>]) -> Pass<'b> {
        Pass { courses, surfaces: &self.surfaces, noise: &self.noise }
    }

    /// The segments as they are now; on request without the moments after steps.
    pub(crate) fn data(&self, without_transients: bool) -> RoundData {
        let torques = self.torques();
        let transients = if without_transients && self.settings.transient_s > 0.0 {
            self.transients(&torques)
        } else {
            vec![Vec::new(); self.logs.len()]
        };
        let so_far = self.has_surface().then_some(SoFar { surfaces: &self.surfaces, noise: &self.noise });
        let mut segments = all_segments(&self.logs, &self.calibration, &torques, so_far, &transients);
        if let Some(so_far) = so_far {
            replace_coarse(&mut segments, &self.logs, &self.calibration, &torques, so_far);
        }
        let merged = merged(&segments, &torques, &self.calibration, &self.noise);
        RoundData { transients, segments, merged }
    }

    /// The moments after steps of the effective torque.
    fn transients(&self, torques: &[EffectiveTorque]) -> Vec<Vec<(f64, f64)>> {
        let after = |(torque, dead_s): (&EffectiveTorque, &f64)| {
            torque.steps(0.05 * torque.largest_nm()).into_iter().map(|t| (t + dead_s, t + dead_s + self.settings.transient_s)).collect()
        };
        torques.iter().zip(&self.calibration.dead_time_s).map(after).collect()
    }

    /// Speeds along the courses: by the surface, if there is one.
    pub(crate) fn speeds(&self, courses: &[Course]) -> Vec<Speeds> {
        if self.has_surface() { self.pass(courses).along(None).speeds } else { wide_speeds(courses) }
    }

    /// The surfaces that a solution describes.
    pub(crate) fn surfaces_of(&self, solution: &Solution) -> PerGear<LatticeSurface> {
        self.design.surfaces(&self.surfaces.forward.lattice, &solution.beta)
    }

    /// Robust cuts with the surface as it is. Judging restarts at every step of the torque, even if no time after it is skipped: a response
    /// that a lag does not explain is no push.
    pub(crate) fn cut(&mut self, threshold: f64) {
        let torques = self.torques();
        let transients = self.transients(&torques);
        let judge = Judge {
            calibration: &self.calibration,
            lagged: &torques,
            surfaces: &self.surfaces,
            noise: &self.noise,
            transients: &transients,
        };
        judge.cut(&mut self.logs, threshold);
    }

    /// Noise from the `share` of the segments that the surface explains best.
    pub(crate) fn update_noise(&mut self, segments: &[Segment], pass: &PassResult, share: f64) {
        let (kept, residuals) = noise_likelihood::well_explained(segments, &pass.residuals, &pass.white, share);
        let spread = noise_likelihood::offset_spread(segments, &pass.residuals, &self.noise);
        let range_mps2 = self.gears.iter().map(|g| self.surfaces[*g].range_mps2()).fold(0.0, f64::max);
        let found = noise_likelihood::estimate(&kept, &residuals, self.noise, spread, range_mps2);
        self.noise = found.noise;
        self.noise_bounds = found.at_bounds;
    }
}
