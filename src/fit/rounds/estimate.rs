//! The estimate after the last round: surface, delays, speeds and noise.

use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive_form::campaign_drift::{CampaignDrift, Progress};
use crate::fit::drive_form::drift_posterior::DriftPosterior;
use crate::fit::drive_form::drive_model::DriveModel;
use crate::fit::drive_form::parameters::PARAMETERS;
use crate::fit::motion::log_data::LogData;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::regressors::Free;
use crate::fit::motion::segment::Segment;
use crate::fit::noise::model::Noise;
use crate::fit::rounds::cross_validation::Validation;
use crate::fit::solve::monotone;
use crate::fit::solve::penalised_least_squares::System;
use crate::fit::solve::shrinkage::Stacked;
use crate::fit::surface::design::Design;
use crate::fit::surface::lattice::LatticeSurface;
use crate::map::{Gear, PerGear};
use faer::Mat;

/// Standard errors of the calibration.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CalibrationErrors {
    /// Standard error of each log's dead time [s].
    pub(crate) dead_time_s: Vec<f64>,
    /// Standard errors of the drive's parameters: times [s], and the limit's logarithm.
    pub(crate) drive_s: [f64; PARAMETERS],
    /// Standard errors of the changes during the campaign.
    pub(crate) drift: CampaignDrift,
    /// Standard error of the encoder's scale.
    pub(crate) encoder_scale: f64,
}

/// The fitted data.
pub(crate) struct EstimateData<'a> {
    pub(crate) logs: Vec<LogData<'a>>,
    /// The end of the campaign.
    pub(crate) end: PerGear<Progress>,
    /// Gears with runs.
    pub(crate) gears: Vec<Gear>,
    /// Whether a log has a yaw rate.
    pub(crate) has_yaw: bool,
    /// The segments, with single readings.
    pub(crate) segments: Vec<Segment>,
    /// Moments after steps that were skipped, per log [s].
    pub(crate) transients: Vec<Vec<(f64, f64)>>,
}

/// The surface, as coefficients and as values of the lattice.
pub(crate) struct SurfaceModel {
    pub(crate) design: Design,
    /// Forward, reverse.
    pub(crate) surfaces: PerGear<LatticeSurface>,
    /// The physics form with a share of the surface.
    pub(crate) stacked: Stacked,
    pub(crate) system: System,
    /// The covariance with penalties that the data do not rule out.
    pub(crate) plausible: Mat<f64>,
}

impl SurfaceModel {
    /// The surface of a gear.
    pub(crate) fn surface(&self, gear: Gear) -> &LatticeSurface {
        &self.surfaces[gear]
    }

    /// Makes the surface rise with torque at every speed of `gears`, as near to the estimate as its information allows; if that fails, by
    /// running maxima.
    pub(crate) fn make_monotone(&mut self, gears: &[Gear]) -> monotone::MonotoneOutcome {
        let lattice = self.surfaces.forward.lattice.clone();
        let mut beta = self.stacked.solution.beta.clone();
        let outcome = monotone::enforce(&self.design, &lattice, &self.system, &self.stacked.solution, gears, &mut beta);
        match outcome {
            monotone::MonotoneOutcome::AlreadyMonotone => {}
            monotone::MonotoneOutcome::Moved(_) => {
                self.stacked.solution.beta = beta;
                self.surfaces = self.design.surfaces(&lattice, &self.stacked.solution.beta);
            }
            monotone::MonotoneOutcome::Forced => Gear::ALL.into_iter().for_each(|g| monotone::force(&lattice, &mut self.surfaces[g].theta)),
        }
        outcome
    }
}

/// Results along the segments.
pub(crate) struct Paths {
    /// The segments with merged readings, as they were fitted.
    pub(crate) merged: Vec<Segment>,
    /// Where the surface was looked up along them.
    pub(crate) lookups: Vec<Speeds>,
    /// Speeds along the segments with single readings, smoothed [m/s].
    pub(crate) speeds_mps: Vec<Vec<f64>>,
    /// Offset of each segment [m/s²].
    pub(crate) offsets_mps2: Vec<f64>,
    /// Whitened residuals of the segments.
    pub(crate) white: Vec<Vec<f64>>,
}

/// How the rounds ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RoundCount {
    pub(crate) count: usize,
    pub(crate) converged: bool,
}

/// Everything that the estimator found.
pub(crate) struct Estimate<'a> {
    pub(crate) data: EstimateData<'a>,
    pub(crate) model: SurfaceModel,
    pub(crate) calibration: Calibration,
    /// The changes during the campaign, clear or not.
    pub(crate) drift: DriftPosterior,
    /// Other drives that were fitted: by how much each is worse, with its standard error (−2·ln L).
    pub(crate) other_drives: Vec<(DriveModel, f64, f64)>,
    /// A drive that the data prefer by far to the one that was given, and by how much (−2·ln L).
    pub(crate) better_than_given: Option<(DriveModel, f64)>,
    /// What was estimated with the surface.
    pub(crate) free: Free,
    pub(crate) calibration_errors: CalibrationErrors,
    pub(crate) noise: Noise,
    /// Parameters of the noise that lie at a bound.
    pub(crate) noise_bounds: Vec<&'static str>,
    pub(crate) paths: Paths,
    pub(crate) rounds: RoundCount,
    /// Results on runs left out; absent with fewer than two runs.
    pub(crate) validation: Option<Validation>,
}

impl Estimate<'_> {
    /// The effective torque of each log.
    pub(crate) fn torques(&self) -> Vec<EffectiveTorque> {
        self.data.logs.iter().map(|log| log.torque(&self.calibration.drive, self.calibration.drift)).collect()
    }
}
