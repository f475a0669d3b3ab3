//! The search: a grid over Kp and the lag time on three turns, then one setting after the other on every turn, and a slower or faster plan.

use crate::controller::ControllerSettings;
use crate::tune::knob::{FASTER, Knob, SLOWER, with_plan};
use crate::tune::limit_margin::{LimitMargin, nearest_limits};
use crate::tune::settings::{PlanFreedom, TuneSettings};
use crate::tune::trial::{Trial, TunedLaw};
use crate::tune::tuning::{Tuning, changes};
use crate::verify::{Class, Maps, Result, Scenario};

/// The turns of the first grid: the shortest, the longest, and one in the other direction.
const GRID_TURNS: [&str; 4] = ["left-30", "left-180", "right-90", "right-90-mirror"];
/// Draws of the first grid.
const GRID_DRAWS: usize = 16;
/// Kp [1/s] and lag time · Kp of the first grid.
const GRID: [&[f64]; 2] = [&[0.7, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0], &[0.5, 0.7, 0.8, 0.9, 1.0, 1.2]];
/// Passes over all settings, at most.
const PASSES: usize = 4;
/// A change must gain this share of the time, so that the draws do not decide.
const WORTHWHILE: f64 = 0.002;

/// The candidates so far.
struct GainSearch<'a> {
    maps: &'a Maps,
    settings: &'a TuneSettings,
    /// Turns and hard conditions.
    scenarios: Vec<Scenario>,
    /// Draws per scenario of a candidate.
    draws: usize,
    /// Called after each candidate.
    done: &'a dyn Fn(),
    candidates: usize,
}

impl GainSearch<'_> {
    fn drive(&mut self, candidate: &ControllerSettings, scenarios: &[Scenario], draws: usize) -> Result<Trial> {
        self.candidates += 1;
        let trial = Trial::drive(self.maps, self.settings, candidate, scenarios, draws, TunedLaw::Map);
        (self.done)();
        trial
    }

    fn cost(&self, trial: &Trial) -> f64 {
        trial.cost(self.settings.reserve)
    }

    /// The best of the grid over Kp and lag time around `from`.
    fn grid(&mut self, from: &ControllerSettings) -> Result<ControllerSettings> {
        let turns: Vec<Scenario> = self.scenarios.iter().filter(|s| GRID_TURNS.contains(&s.name.as_str())).cloned().collect();
        let mut best = self.drive(from, &turns, GRID_DRAWS)?;
        for kp in GRID[0] {
            for lag in GRID[1] {
                let candidate = Knob::LagTimesKp.set(&Knob::Kp.set(from, *kp), *lag);
                let trial = self.drive(&candidate, &turns, GRID_DRAWS)?;
                if self.cost(&trial) < self.cost(&best) {
                    best = trial;
                }
            }
        }
        Ok(best.settings)
    }

    /// One setting after the other, as long as one of them gains something.
    fn descend(&mut self, mut best: Trial, knobs: &[Knob]) -> Result<Trial> {
        let (scenarios, draws) = (self.scenarios.clone(), self.draws);
        for _ in 0..PASSES {
            let before = self.cost(&best);
            for knob in knobs {
                let mut moved = knob.applies(&best.settings);
                while moved {
                    moved = false;
                    for value in knob.neighbours(&best.settings).collect::<Vec<_>>() {
                        let trial = self.drive(&knob.set(&best.settings, value), &scenarios, draws)?;
                        if self.cost(&trial) < (1.0 - WORTHWHILE) * self.cost(&best) {
                            (best, moved) = (trial, true);
                            break;
                        }
                    }
                }
            }
            if self.cost(&best) >= before {
                break;
            }
        }
        Ok(best)
    }

    /// Grid and descent from `from`; the start itself if it is the best.
    fn gains(&mut self, from: &ControllerSettings, knobs: &[Knob]) -> Result<Trial> {
        let (scenarios, draws) = (self.scenarios.clone(), self.draws);
        let start = self.drive(from, &scenarios, draws)?;
        let grid = self.grid(from)?;
        let found = self.drive(&grid, &scenarios, draws)?;
        let better = if self.cost(&found) < self.cost(&start) { found } else { start };
        self.descend(better, knobs)
    }

    /// What is near to `from`, with as many draws as the final judgement: the largest of few draws can miss what one of many shows.
    fn refined(&mut self, from: &ControllerSettings) -> Result<Trial> {
        self.draws = self.settings.verify.draws;
        let slower = self.settings.plan != PlanFreedom::Keep;
        let knobs: &[Knob] = if slower { &Knob::ALL } else { &Knob::GAINS };
        let scenarios = self.scenarios.clone();
        let mut best = self.drive(from, &scenarios, self.draws)?;
        for share in [1.0, 0.85, 0.7].into_iter().filter(|share| slower || *share == 1.0) {
            let trial = self.drive(&with_plan(from, share), &scenarios, self.draws)?;
            let trial = self.descend(trial, knobs)?;
            if self.cost(&trial) < self.cost(&best) {
                best = trial;
            }
            if best.passes() {
                break;
            }
        }
        Ok(best)
    }

    /// Gains for the plan of the start, and where that is allowed for a slower or faster one.
    fn best(&mut self, start: &ControllerSettings) -> Result<Trial> {
        let mut best = self.gains(start, &Knob::GAINS)?;
        let reserve = self.settings.reserve;
        if best.least_margin() < reserve && self.settings.plan != PlanFreedom::Keep {
            for share in SLOWER {
                let trial = self.gains(&with_plan(start, share), &Knob::ALL)?;
                if self.cost(&trial) < self.cost(&best) {
                    best = trial;
                }
                if best.least_margin() >= reserve {
                    break;
                }
            }
        } else if best.least_margin() >= reserve && self.settings.plan == PlanFreedom::Any {
            let gains = best.settings.clone();
            for share in FASTER {
                let candidate = with_plan(&gains, share);
                let trial = self.drive(&candidate, &self.scenarios.clone(), self.draws)?;
                let trial = self.descend(trial, &Knob::GAINS)?;
                if self.cost(&trial) >= self.cost(&best) {
                    break;
                }
                best = trial;
            }
        }
        Ok(best)
    }
}

/// Searches the settings that keep the gate with a reserve and are the fastest of those. `done` is called after each candidate.
///
/// # Errors
/// A plant that cannot be simulated, a controller that cannot be set up. A map that no gains serve is a result, not an error.
pub(crate) fn tune(maps: &Maps, settings: &TuneSettings, done: &dyn Fn()) -> Result<Tuning> {
    let start = settings.start.settings();
    let all = &settings.verify.scenarios;
    let scenarios: Vec<Scenario> = all.iter().filter(|s| matches!(s.class, Class::Turn | Class::Hard)).cloned().collect();
    let mut search = GainSearch { maps, settings, scenarios, draws: settings.draws, done, candidates: 0 };
    let found = search.best(start)?;
    // the final word has the draws of `verify`
    let judged = |candidate: &ControllerSettings, law| Trial::drive(maps, settings, candidate, all, settings.verify.draws, law);
    let (before, mut after) = (judged(start, TunedLaw::Map)?, judged(&found.settings, TunedLaw::Map)?);
    if !after.passes() && !before.passes() {
        let refined = search.refined(&found.settings)?;
        let again = judged(&refined.settings, TunedLaw::Map)?;
        if again.passes() || again.cost(0.0) < after.cost(0.0) {
            after = again;
        }
    }
    // a start that passes is not given up for settings that do not
    let after = if before.passes() && !after.passes() { before.clone() } else { after };
    let perfect = if after.passes() { None } else { Some(judged(&after.settings, TunedLaw::Perfect)?) };
    let time = |trial: &Trial| Some(trial.settling_s).filter(|t| t.is_finite());
    Ok(Tuning {
        passes: after.passes(),
        changes: changes(start, &after.settings),
        candidates: search.candidates,
        settling_s: [time(&before), time(&after)],
        before: nearest_limits(&before.margins),
        after: nearest_limits(&after.margins),
        loop_margins: after.loop_margins,
        limits: limits(&after, perfect.as_ref(), settings.reserve),
        settings: after.settings,
    })
}

/// What limits the result.
fn limits(after: &Trial, perfect: Option<&Trial>, reserve: f64) -> Vec<String> {
    let mut limits: Vec<String> =
        nearest_limits(&after.margins).iter().filter(|m| m.margin < reserve.max(0.3)).take(3).map(LimitMargin::sentence).collect();
    match perfect {
        Some(perfect) if perfect.passes() => limits.push(
            "the perfect inverse of the plant keeps every limit with these settings: the map limits, not the controller; drive the runs of \
             `pivot-cal plan`"
                .to_owned(),
        ),
        Some(perfect) => {
            let first = perfect.margins.first().map_or(String::new(), LimitMargin::sentence);
            limits.push(format!(
                "the perfect inverse of the plant breaks the gate too ({first}): the drive's delays, the sensors or the gate limit, not the map"
            ));
        }
        None => {}
    }
    limits
}
