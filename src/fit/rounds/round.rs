//! One round: the whitened sums along the segments, their solution with penalties chosen by the data, and the next surface and delays.

use crate::fit::motion::integration::Course;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::passes::{Pass, PassResult, total};
use crate::fit::motion::regressors::Free;
use crate::fit::rounds::cross_validation;
use crate::fit::rounds::state::State;
use crate::fit::solve::normal_equations::Gram;
use crate::fit::solve::penalised_least_squares::{SETTLING_ROUNDS, Solution, System};
use crate::fit::solve::shrinkage::physics_alone;
use crate::fit::solve::stribeck_speed;
use crate::fit::surface::design::Design;
use crate::fit::{Error, Result};
use crate::map::{Gear, PerGear};

/// Rounds of the penalties' own iteration while other things still move.
const PENALTY_ROUNDS: usize = 4;

/// Results of a round.
pub(crate) struct RoundResult {
    pub(crate) solution: Solution,
    pub(crate) system: System,
    /// The sums of both gears, fold by fold.
    pub(crate) folds: Vec<PerGear<Gram>>,
    /// The fold of each segment.
    pub(crate) fold: Vec<usize>,
    pub(crate) pass: PassResult,
    /// Root mean square change of the surface over the readings [m/s²].
    pub(crate) moved_mps2: f64,
    /// Largest step of a delay, over its standard error.
    pub(crate) stepped: f64,
}

impl State<'_> {
    /// Makes a round with the surface looked up at `speeds`. With `settle` the Stribeck speed is estimated, the penalties are iterated
    /// until they settle, and the sums are kept apart by fold for the cross-validation.
    ///
    /// # Errors
    /// Equations without information.
    pub(crate) fn round(&mut self, courses: &[Course], speeds: &[Speeds], free: Free, settle: bool) -> Result<RoundResult> {
        self.rounds += 1;
        let logs = self.logs.len();
        let (fold, count) = if settle { cross_validation::deal(courses) } else { (vec![0; courses.len()], 1) };
        let folds = self.pass(courses).assemble(speeds, free, logs, (&fold, count));
        let sums = total(&folds);
        let of_gears: Vec<(Gear, &Gram)> = self.gears.iter().map(|g| (*g, &sums[*g])).collect();
        let prior = self.nuisance_prior(free);
        if settle {
            let lattice = &self.surfaces.forward.lattice;
            let stribeck_mps = stribeck_speed::speed(lattice, &of_gears, &prior);
            self.design = Design::new(lattice, self.gears.len() > 1, stribeck_mps);
        }
        let mut system = System::new(&self.design, &of_gears, free.nuisances(logs));
        if free != Free::Surface {
            self.observe_lag(&mut system, &prior);
        }
        let iterations = if settle { SETTLING_ROUNDS } else { PENALTY_ROUNDS };
        // intervals follow the surface that places the speed in them: a free surface would be confirmed by its own readings
        if self.penalties.is_empty() && self.logs.iter().any(|l| l.coarse_mps != [0.0; 2]) {
            self.penalties = physics_alone(&self.design.blocks);
        }
        let solution = system.solve(&self.design.blocks, &self.penalties, iterations, &prior).ok_or(Error::Singular)?;
        self.penalties.clone_from(&solution.penalties);
        let next = self.surfaces_of(&solution);
        let pass = Pass { surfaces: &next, ..self.pass(courses) };
        let moved_mps2 = pass.movement(speeds, &self.surfaces);
        let pass = pass.along(Some(speeds));
        self.surfaces = next;
        let stepped = if free == Free::Surface { 0.0 } else { self.calibrate(&solution, free) };
        Ok(RoundResult { solution, system, folds, fold, pass, moved_mps2, stepped })
    }
}
