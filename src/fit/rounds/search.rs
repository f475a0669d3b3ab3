//! The rounds of the estimator.
//!
//! First on a sample of a long campaign, with delays, encoder and noise free; then on everything, without the moments after steps, for the
//! surface together with the delays. Each round filters the speeds along the segments with the surface of the last one, adds up the
//! whitened sums, solves them with penalties chosen by the data, and moves on to the new surface and calibration.

use crate::campaign::Survey;
use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::torque_input::{Choice, Input};
use crate::fit::motion::integration::{Course, courses, courses_again};
use crate::fit::motion::log_data::Cuts;
use crate::fit::motion::log_data::LogData;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::merging::{merged, spread};
use crate::fit::motion::noise_likelihood;
use crate::fit::motion::passes::{Along, Pass, smoothed_speeds, total, wide_speeds};
use crate::fit::motion::regressors::{Free, nuisance};
use crate::fit::motion::segment::Segment;
use crate::fit::motion::segmentation::{SoFar, all_segments};
use crate::fit::noise::kalman::Noise;
use crate::fit::rounds::convergence::{damped, to_come};
use crate::fit::rounds::cross_validation::Validation;
use crate::fit::rounds::estimate::{CalibrationErrors, Estimate};
use crate::fit::rounds::initial_guess::{Start, hold_known};
use crate::fit::rounds::outliers::Judge;
use crate::fit::rounds::{cross_validation, sampling};
use crate::fit::solve::normal_equations::Gram;
use crate::fit::solve::penalised_least_squares::{SETTLING_ROUNDS, Solution, System, nuisance_prior_std};
use crate::fit::solve::shrinkage::Stacked;
use crate::fit::solve::stribeck_speed;
use crate::fit::surface::design::{Design, STRIBECK_MPS};
use crate::fit::surface::lattice::LatticeSurface;
use crate::fit::{Error, Result, Settings};
use crate::map::Gear;

/// Movement of the surface below which it stands still [m/s², root mean square].
const STILL_MPS2: f64 = 2e-4;
/// Step of a delay below which it stands still, as a share of its standard error.
const STILL_DELAY: f64 = 0.1;
/// Largest step of a delay in one round [s].
const DELAY_STEP_S: f64 = 0.02;
/// Threshold of the cuts in the first rounds, and later.
const CUT_BEYOND: [f64; 2] = [6.0, 5.0];
/// Prior standard deviation of what is known.
const FIXED_STD: f64 = 1e-9;
/// Round on everything from which on speeds go half the way only: most campaigns stand still before.
const HALF_WAY_FROM: usize = 3;
/// Rounds in which the encoder is calibrated by the yaw rate: at once, and when pushes and slips are out.
const ENCODER_ROUNDS: [usize; 2] = [1, 4];
/// Rounds of the penalties' own iteration: while other things still move, and for good.
const PENALTY_ROUNDS: [usize; 2] = [4, SETTLING_ROUNDS];

/// Runs the estimator with the input that was chosen.
///
/// # Errors
/// A slow speed signal without a yaw rate, too little motion, one torque only, equations without information.
pub(crate) fn estimate<'a>(surveys: &'a [Survey], choice: &Choice, settings: &Settings) -> Result<Estimate<'a>> {
    let mut search = Search::new(surveys, choice, settings)?;
    search.delays()?;
    search.surface()
}

/// The state from one round to the next.
pub(crate) struct Search<'a> {
    settings: Settings,
    logs: Vec<LogData<'a>>,
    gears: Vec<Gear>,
    has_yaw: bool,
    calibration: Calibration,
    errors: CalibrationErrors,
    noise: Noise,
    noise_bounds: Vec<&'static str>,
    design: Design,
    /// Forward, reverse; zero before the first round.
    surfaces: [LatticeSurface; 2],
    penalties: Vec<f64>,
    /// Whether the first rounds looked at a part of the data only.
    sampled: bool,
    rounds: usize,
    converged: bool,
    /// The last step of the lag and the dead times as the equations asked for it, and as it was made [s].
    last_step: Vec<(f64, f64)>,
}

/// What rounds work on.
struct Stretch {
    transients: Vec<Vec<(f64, f64)>>,
    segments: Vec<Segment>,
    /// The same with merged readings.
    merged: Vec<Segment>,
}

/// What a round found.
struct Found {
    solution: Solution,
    system: System,
    /// The sums, fold by fold, and the fold of each segment.
    parts: Vec<[Gram; 2]>,
    fold: Vec<usize>,
    along: Along,
    moved_mps2: f64,
    /// Largest step of a delay, over its standard error.
    stepped: f64,
}

/// What was taken of the last round.
struct Judged {
    stacked: Stacked,
    system: System,
    /// Filtered.
    speeds: Vec<Speeds>,
    validation: Option<Validation>,
}

impl<'a> Search<'a> {
    /// Before the first round.
    pub(crate) fn new(surveys: &'a [Survey], choice: &Choice, settings: &Settings) -> Result<Self> {
        let Start { logs, gears, has_yaw, calibration, noise, lattice } = Start::new(surveys, choice, settings)?;
        let design = Design::new(&lattice, gears.len() > 1, STRIBECK_MPS);
        let zero = LatticeSurface { theta: vec![0.0; lattice.columns()], lattice };
        let errors = CalibrationErrors { dead_time_s: vec![0.0; logs.len()], lag_s: 0.0, encoder_scale: 0.0 };
        Ok(Self {
            settings: settings.clone(),
            logs,
            gears,
            has_yaw,
            calibration,
            errors,
            noise,
            noise_bounds: Vec::new(),
            design,
            surfaces: [zero.clone(), zero],
            penalties: Vec::new(),
            sampled: false,
            rounds: 0,
            converged: false,
            last_step: Vec::new(),
        })
    }

    /// Rounds on a sample of a long campaign, with delays, encoder and noise free.
    pub(crate) fn delays(&mut self) -> Result<()> {
        let (chosen, sampled) = sampling::choose(&self.logs);
        self.sampled = sampled;
        for (log, chosen) in self.logs.iter_mut().zip(chosen) {
            log.chosen = chosen;
        }
        for round in 0..self.settings.iterations[0] {
            if round >= 2 {
                self.cut(CUT_BEYOND[usize::from(round > 2)]);
            }
            let stretch = self.stretch(false);
            let lagged = self.lagged();
            let free = match round {
                0 => Free::Surface,
                _ if ENCODER_ROUNDS.contains(&round) => Free::DelaysAndEncoder,
                _ => Free::Delays,
            };
            // two witnesses that are merged do not tell one from the other
            let segments = if free == Free::DelaysAndEncoder { &stretch.segments } else { &stretch.merged };
            let courses = courses(segments, &lagged, &self.calibration);
            let speeds = self.speeds(&courses);
            let found = self.round(&courses, &speeds, free, false)?;
            if (1..=4).contains(&round) {
                // before the first cuts pushes and slips are still in: only what is well explained tells the noise
                self.update_noise(segments, &found.along, 0.6);
            }
            if found.moved_mps2 < STILL_MPS2 && round >= 5 {
                break;
            }
        }
        for log in &mut self.logs {
            log.chosen.fill(true);
        }
        Ok(())
    }

    /// Rounds on everything, without the moments after steps, until surface and delays stand still.
    pub(crate) fn surface(mut self) -> Result<Estimate<'a>> {
        self.penalties.clear();
        self.last_step.clear();
        self.cut(CUT_BEYOND[1]);
        let mut stretch = self.stretch(true);
        let mut speeds = None;
        let most = self.settings.iterations[1].max(2);
        let mut before: Option<[f64; 2]> = None;
        for round in 1.. {
            let lagged = self.lagged();
            let courses = courses(&stretch.merged, &lagged, &self.calibration);
            let along = speeds.take().unwrap_or_else(|| self.speeds(&courses));
            let mut found = self.round(&courses, &along, Free::Delays, true)?;
            let moved = [found.moved_mps2, found.stepped];
            self.converged = moved
                .into_iter()
                .zip([STILL_MPS2, STILL_DELAY])
                .enumerate()
                .all(|(k, (moved, still))| moved < still || before.is_some_and(|before| to_come(before[k], moved) < still));
            before = Some(moved);
            if round == 1 {
                self.update_noise(&stretch.merged, &found.along, 0.98);
                // what was cut is judged again by the better surface, which moves the starts from rest a little as well; then they stay
                if !self.sampled || self.logs.iter().any(|l| l.cuts != Cuts::default()) {
                    drop(courses);
                    self.cut(CUT_BEYOND[1]);
                    stretch = self.stretch(true);
                    before = None;
                    self.last_step.clear();
                    continue;
                }
            } else if self.converged || round >= most {
                let judged = self.judge(&courses, &along, found)?;
                drop(courses);
                return Ok(self.handed_over(stretch, judged));
            }
            // where speeds and surface chase each other, going half the way meets
            let mut next = std::mem::take(&mut found.along.speeds);
            if round >= HALF_WAY_FROM {
                next.iter_mut().zip(&along).for_each(|(next, last)| next.go_half_way_from(last));
            }
            speeds = Some(next);
        }
        Err(Error::Singular)
    }

    /// Cross-validates, and takes as much of the surface as runs left out ask for.
    fn judge(&mut self, courses: &[Course], speeds: &[Speeds], mut found: Found) -> Result<Judged> {
        let prior = self.nuisance_prior(Free::Delays);
        let along = cross_validation::Along { courses, speeds, noise: &self.noise };
        let parts = (found.fold.as_slice(), found.parts.as_slice());
        let lattice = &self.surfaces[0].lattice;
        let validation = cross_validation::validate(&self.design, lattice, &self.gears, parts, &found.system, &prior, &along);
        let share = validation.as_ref().map_or(1.0, |v| v.comparison.surface_share);
        let stacked = Stacked::new(&found.system, found.solution, &self.design.blocks, share, &prior).ok_or(Error::Singular)?;
        if share < 1.0 {
            self.surfaces = self.surfaces_of(&stacked.solution);
            self.calibrate(&stacked.solution, Free::Delays);
            let lagged = self.lagged();
            let courses = courses_again(courses, &lagged, &self.calibration);
            found.along = Pass { courses: &courses, surfaces: &self.surfaces, noise: &self.noise }.along(Some(speeds));
        }
        Ok(Judged { stacked, system: found.system, speeds: found.along.speeds, validation })
    }

    /// The estimate, with every single reading told against it.
    fn handed_over(self, stretch: Stretch, judged: Judged) -> Estimate<'a> {
        let Stretch { transients, segments, merged } = stretch;
        let fitted = (merged, judged.speeds);
        let speeds: Vec<Speeds> = segments
            .iter()
            .zip(fitted.0.iter().zip(&fitted.1))
            .map(|(s, (m, v))| spread(&v.after, &m.readings, &s.readings).into())
            .collect();
        let lagged = self.lagged();
        let courses = courses(&segments, &lagged, &self.calibration);
        let along = Pass { courses: &courses, surfaces: &self.surfaces, noise: &self.noise }.along(Some(&speeds));
        drop(courses);
        Estimate {
            logs: self.logs,
            design: self.design,
            calibration: self.calibration,
            calibration_errors: self.errors,
            noise: self.noise,
            noise_bounds: self.noise_bounds,
            gears: self.gears,
            surfaces: self.surfaces,
            stacked: judged.stacked,
            system: judged.system,
            speeds: smoothed_speeds(&segments, &along.residuals, &self.noise),
            segments,
            fitted,
            offsets: along.offsets,
            white: along.white,
            transients,
            iterations: self.rounds,
            converged: self.converged,
            has_yaw: self.has_yaw,
            validation: judged.validation,
        }
    }

    /// One round: sums, solution, new surface; with delays free, a step of the calibration. The penalties settle when nothing else moves.
    fn round(&mut self, courses: &[Course], speeds: &[Speeds], free: Free, settle: bool) -> Result<Found> {
        self.rounds += 1;
        let logs = self.logs.len();
        let pass = Pass { courses, surfaces: &self.surfaces, noise: &self.noise };
        // the last sums are kept apart by fold for the cross-validation
        let (fold, folds) = if settle { cross_validation::deal(courses) } else { (vec![0; courses.len()], 1) };
        let parts = pass.assemble(speeds, free, logs, (&fold, folds));
        let grams = total(&parts);
        let pairs: Vec<(Gear, &Gram)> = self.gears.iter().map(|g| (*g, &grams[usize::from(*g == Gear::Reverse)])).collect();
        let prior = self.nuisance_prior(free);
        if settle {
            let stribeck_mps = stribeck_speed::speed(&self.surfaces[0].lattice, &pairs, &prior);
            self.design = Design::new(&self.surfaces[0].lattice, self.gears.len() > 1, stribeck_mps);
        }
        let system = System::new(&self.design, &pairs, free.nuisances(logs));
        let updates = PENALTY_ROUNDS[usize::from(settle)];
        let solution = system.solve(&self.design.blocks, &self.penalties, updates, &prior).ok_or(Error::Singular)?;
        self.penalties.clone_from(&solution.penalties);
        let next = self.surfaces_of(&solution);
        let pass = Pass { courses, surfaces: &next, noise: &self.noise };
        let moved_mps2 = pass.movement(speeds, &self.surfaces);
        let along = pass.along(Some(speeds));
        self.surfaces = next;
        let stepped = if free == Free::Surface { 0.0 } else { self.calibrate(&solution, free) };
        Ok(Found { solution, system, parts, fold, along, moved_mps2, stepped })
    }

    /// Prior standard deviations of the nuisance columns; what is known from outside does not move.
    fn nuisance_prior(&self, free: Free) -> Vec<f64> {
        if free == Free::Surface {
            return Vec::new();
        }
        let known = self.settings.known.as_ref();
        let mut prior = nuisance_prior_std(self.logs.len(), self.has_yaw && free == Free::DelaysAndEncoder);
        let hold = |std: &mut f64| *std = FIXED_STD;
        let measured = self.logs.iter().any(|l| l.input != Input::Command);
        if measured || self.settings.lag_s.is_some() || known.is_some_and(|k| k.lag_s.is_some()) {
            hold(&mut prior[nuisance::LAG]);
        }
        if known.is_some_and(|k| k.encoder.is_some()) {
            hold(&mut prior[nuisance::ENCODER_SCALE]);
            hold(&mut prior[nuisance::ENCODER_DELAY]);
        }
        for (std, log) in prior[nuisance::DEAD_TIME..].iter_mut().zip(&self.logs) {
            if self.settings.dead_time_s.is_some() || known.is_some_and(|k| k.dead_time_s.contains_key(&log.survey.track.source.sha256)) {
                hold(std);
            }
        }
        prior
    }

    /// Speeds along the courses: by the surface, where there is one.
    fn speeds(&self, courses: &[Course]) -> Vec<Speeds> {
        if self.has_surface() {
            Pass { courses, surfaces: &self.surfaces, noise: &self.noise }.along(None).speeds
        } else {
            wide_speeds(courses)
        }
    }

    fn surfaces_of(&self, solution: &Solution) -> [LatticeSurface; 2] {
        let lattice = &self.surfaces[0].lattice;
        let beta = &solution.beta[..self.design.coefficients()];
        Gear::ALL.map(|g| LatticeSurface { lattice: lattice.clone(), theta: self.design.lattice_values(g, beta) })
    }

    /// Whether a round has been made.
    fn has_surface(&self) -> bool {
        self.rounds > 0
    }

    fn lagged(&self) -> Vec<EffectiveTorque> {
        self.logs.iter().map(|l| l.torque(self.calibration.lag_s)).collect()
    }

    /// The segments as they are now; without the moments after steps, if so asked.
    fn stretch(&self, without_transients: bool) -> Stretch {
        let lagged = self.lagged();
        let transients = if without_transients && self.settings.transient_s > 0.0 {
            self.transients(&lagged)
        } else {
            vec![Vec::new(); self.logs.len()]
        };
        let so_far = self.has_surface().then_some(SoFar { surfaces: &self.surfaces, noise: &self.noise });
        let segments = all_segments(&self.logs, &self.calibration, &lagged, so_far, &transients);
        let merged = merged(&segments, &lagged, &self.calibration, &self.noise);
        Stretch { transients, segments, merged }
    }

    /// The moments after steps of the effective torque.
    fn transients(&self, lagged: &[EffectiveTorque]) -> Vec<Vec<(f64, f64)>> {
        let after = |(lagged, dead_s): (&EffectiveTorque, &f64)| {
            lagged.steps(0.05 * lagged.largest_nm()).into_iter().map(|t| (t + dead_s, t + dead_s + self.settings.transient_s)).collect()
        };
        lagged.iter().zip(&self.calibration.dead_time_s).map(after).collect()
    }

    /// Robust cuts with the surface as it is. The judge begins anew at every step of the torque, even where nothing is left out after it: what
    /// a drive does there that a lag does not explain is no push.
    fn cut(&mut self, threshold: f64) {
        let lagged = self.lagged();
        let transients = self.transients(&lagged);
        let judge = Judge {
            calibration: &self.calibration,
            lagged: &lagged,
            surfaces: &self.surfaces,
            noise: &self.noise,
            transients: &transients,
        };
        judge.cut(&mut self.logs, threshold);
    }

    /// Noise from the `share` of the segments that the surface explains best.
    fn update_noise(&mut self, segments: &[Segment], along: &Along, share: f64) {
        let (kept, residuals) = noise_likelihood::well_explained(segments, &along.residuals, &along.white, share);
        let spread = noise_likelihood::offset_spread(segments, &along.residuals, &self.noise);
        let range_mps2 = self.gears.iter().map(|g| self.surfaces[usize::from(*g == Gear::Reverse)].range_mps2()).fold(0.0, f64::max);
        let found = noise_likelihood::estimate(&kept, &residuals, self.noise, spread, range_mps2);
        self.noise = found.noise;
        self.noise_bounds = found.at_bounds;
    }

    /// A step of delays and encoder calibration, and how sure they are; the largest step of a delay, over its standard error.
    fn calibrate(&mut self, solution: &Solution, free: Free) -> f64 {
        let q = self.design.coefficients();
        let of = |k: usize| solution.beta[q + k];
        let step = |k: usize| of(k).clamp(-DELAY_STEP_S, DELAY_STEP_S);
        let before = self.calibration.clone();
        let asked: Vec<f64> =
            std::iter::once(nuisance::LAG).chain((0..self.logs.len()).map(|k| nuisance::DEAD_TIME + k)).map(step).collect();
        let made: Vec<f64> = asked.iter().enumerate().map(|(k, asked)| damped(*asked, self.last_step.get(k).copied())).collect();
        self.calibration.lag_s = (before.lag_s + made[0]).clamp(0.0, 0.3);
        for (dead_time, made) in self.calibration.dead_time_s.iter_mut().zip(&made[1..]) {
            *dead_time = (*dead_time + made).clamp(-0.1, 0.5);
        }
        self.last_step = asked.into_iter().zip(made).collect();
        let covariance = |a: usize, b: usize| solution.covariance[(q + a, q + b)];
        let std_err = |k: usize| covariance(k, k).max(0.0).sqrt();
        self.errors.lag_s = std_err(nuisance::LAG);
        self.errors.dead_time_s = (0..self.logs.len()).map(|k| std_err(nuisance::DEAD_TIME + k)).collect();
        if free == Free::DelaysAndEncoder {
            self.errors.encoder_scale = std_err(nuisance::ENCODER_SCALE);
            if self.has_yaw {
                self.calibration.encoder_scale *= 1.0 + of(nuisance::ENCODER_SCALE).clamp(-0.02, 0.02);
                let delay_s = self.calibration.encoder_delay_s + step(nuisance::ENCODER_DELAY);
                self.calibration.encoder_delay_s = delay_s.clamp(-0.3, 0.3);
            }
        }
        hold_known(&mut self.calibration, &self.logs, &self.settings);
        let now = &self.calibration;
        let errors = &self.errors;
        let steps = before.dead_time_s.iter().zip(&now.dead_time_s).zip(&errors.dead_time_s).map(|((a, b), error)| (b - a).abs() / error);
        steps.fold((now.lag_s - before.lag_s).abs() / errors.lag_s, f64::max)
    }
}
