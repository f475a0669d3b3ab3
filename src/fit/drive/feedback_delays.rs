//! Delays of the drive by its torque feedback. Command → feedback shows dead time and lag without a clock of the speed sensors. So it
//! separates dead time from a clock offset between command and speed, and shows whether a first-order lag explains the drive.

use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::lagged_command::LaggedCommand;
use crate::fit::drive::settled_holds::settled;
use crate::fit::drive::step_timing::StepTiming;
use crate::signal::Series;

/// Dead time and lag of one log by its torque feedback.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FeedbackDelays {
    pub(crate) dead_time_s: f64,
    pub(crate) dead_time_std_err_s: f64,
    pub(crate) lag_s: f64,
    pub(crate) lag_std_err_s: f64,
    /// Standard deviation of the feedback about the lagged command [N·m].
    pub(crate) residual_nm: f64,
    /// Feedback minus lagged command in the 0.3 s after steps.
    pub(crate) after_steps: Squares,
    /// The same where the drive has settled.
    pub(crate) settled: Squares,
    /// The steps, one for each reading in the 0.3 s after them.
    pub(crate) steps: Squares,
}

/// A sum of squares that can be pooled.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Squares {
    sum: f64,
    count: usize,
}

impl Squares {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        values.fold(Self::default(), |all, v| Self { sum: all.sum + v * v, count: all.count + 1 })
    }

    /// Root mean square; 0 for none.
    fn rms(self) -> f64 {
        (self.sum / self.count.max(1) as f64).sqrt()
    }
}

impl std::iter::Sum for Squares {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::default(), |a, b| Self { sum: a.sum + b.sum, count: a.count + b.count })
    }
}

/// A first-order lag explains the drive up to this ratio of the feedback's residual after steps to that elsewhere.
const LAG_EXPLAINS: f64 = 2.5;
/// A residual after steps, beyond that elsewhere, is no evidence against the lag below this share of the steps: stamps with an error of
/// some milliseconds leave 2 %. (Behind 800 N·m/s, 5 % are left, and the feedback is 4 times better than the command; behind 1200 N·m/s,
/// 2.4 %.)
const LEAST_MISFIT: f64 = 0.03;

/// Fewest readings near steps.
const FEWEST_READINGS: usize = 20;
/// Readings of a coarse search.
const MOST_READINGS: usize = 1500;
/// Most iterations of a Gauss-Newton search.
const ITERATIONS: usize = 12;
/// Standard deviation of normal errors over the median of their sizes.
const STD_OF_MEDIAN: f64 = 1.4826;
/// Number of standard deviations beyond which Huber's weight falls.
const HUBER: f64 = 2.5;

impl FeedbackDelays {
    /// Ratio of the residual after steps to its noise, at least 1: the factor on the standard errors of a drive that is not of first order.
    pub(crate) fn misfit(&self) -> f64 {
        (self.after_steps.rms() / self.residual_nm.max(1e-9)).max(1.0)
    }
}

/// The residual after steps over that where the drive has settled, for all logs: near 1 where a first-order lag explains the drive.
pub(crate) fn after_step_ratio<'a>(logs: impl Iterator<Item = &'a FeedbackDelays> + Clone) -> f64 {
    let after: Squares = logs.clone().map(|f| f.after_steps).sum();
    let settled: Squares = logs.map(|f| f.settled).sum();
    after.rms() / settled.rms().max(1e-9)
}

/// Whether a first-order lag explains the feedback of all these logs.
pub(crate) fn lag_explains<'a>(logs: impl Iterator<Item = &'a FeedbackDelays> + Clone) -> bool {
    let pooled = |of: fn(&FeedbackDelays) -> Squares| logs.clone().map(of).sum::<Squares>().rms();
    let (after, settled, steps) = (pooled(|f| f.after_steps), pooled(|f| f.settled), pooled(|f| f.steps));
    after_step_ratio(logs) < LAG_EXPLAINS || after * after - settled * settled < (LEAST_MISFIT * steps).powi(2)
}

/// Fits u(t − T_d; T_c) to the feedback by Gauss-Newton, after a coarse search. `None` if the command has no step.
pub(crate) fn delays(command: &Series, feedback: &Series, fixed_lag_s: Option<f64>) -> Option<FeedbackDelays> {
    let largest = command.value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let steps = LaggedCommand::new(command, 0.05).steps(0.1 * largest);
    if steps.is_empty() || largest <= 0.0 {
        return None;
    }
    let near = near_steps(feedback, &steps);
    if near.len() < FEWEST_READINGS {
        return None;
    }
    let cost = |lagged: &LaggedCommand, dead: f64, stride: usize| -> f64 {
        near.iter().step_by(stride).map(|&i| (feedback.value[i] - lagged.at(feedback.t_s[i] - dead).torque_nm).abs().min(largest)).sum()
    };
    let stride = near.len().div_ceil(MOST_READINGS);
    let mut best = (f64::INFINITY, 0.0, 0.05);
    for lag in fixed_lag_s.map_or(vec![0.01, 0.03, 0.06, 0.1, 0.15, 0.2], |l| vec![l]) {
        let lagged = LaggedCommand::new(command, lag);
        for dead in dead_times_s() {
            let value = cost(&lagged, dead, stride);
            if value < best.0 {
                best = (value, dead, lag);
            }
        }
    }
    let (_, mut dead, mut lag) = best;
    let mut std_err = [0.0; 2];
    let mut scale = 1.0;
    for _ in 0..ITERATIONS {
        let lagged = LaggedCommand::new(command, lag);
        let (mut a, mut g) = ([[0.0; 2]; 2], [0.0; 2]);
        let residuals: Vec<f64> = near.iter().map(|&i| feedback.value[i] - lagged.at(feedback.t_s[i] - dead).torque_nm).collect();
        let sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
        scale = (STD_OF_MEDIAN * crate::signal::median(&sizes)).max(1e-6);
        for (&i, r) in near.iter().zip(&residuals) {
            let at = lagged.at(feedback.t_s[i] - dead);
            // a drive that is not of first order, or a lost message, does not pull the fit away
            let weight = (HUBER * scale / r.abs().max(1e-12)).min(1.0);
            let j = [at.by_dead_time, if fixed_lag_s.is_some() { 0.0 } else { at.by_drive[0] }];
            for p in 0..2 {
                g[p] += weight * j[p] * r;
                for q in 0..2 {
                    a[p][q] += weight * j[p] * j[q];
                }
            }
        }
        a[1][1] += 1e-9 * (a[0][0] + a[1][1]) + 1e-12;
        let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
        if determinant <= 0.0 {
            return None;
        }
        let step = [(a[1][1] * g[0] - a[0][1] * g[1]) / determinant, (a[0][0] * g[1] - a[1][0] * g[0]) / determinant];
        dead += step[0].clamp(-0.02, 0.02);
        lag = (lag + step[1].clamp(-0.02, 0.02)).clamp(0.0, 0.3);
        std_err = [scale * (a[1][1] / determinant).sqrt(), scale * (a[0][0] / determinant).sqrt()];
        if step.iter().all(|s| s.abs() < 1e-6) {
            break;
        }
    }
    let lagged = LaggedCommand::new(command, lag);
    let residual = |i: usize| feedback.value[i] - lagged.at(feedback.t_s[i] - dead).torque_nm;
    // each reading soon after a step, with the step's size; a step whose message is late, after missing ones, gives no information on the
    // drive
    let timing = StepTiming::new(command);
    let after: Vec<(usize, f64)> = near
        .iter()
        .filter_map(|&i| {
            let t = feedback.t_s[i] - dead;
            let k = steps.partition_point(|s| *s <= t).checked_sub(1)?;
            let command_at = |t: f64| command.held(t).unwrap_or(0.0);
            (t - steps[k] < 0.3 && !timing.follows_a_gap(steps[k])).then(|| (i, command_at(steps[k]) - command_at(steps[k] - 1e-6)))
        })
        .collect();
    Some(FeedbackDelays {
        dead_time_s: dead,
        dead_time_std_err_s: std_err[0],
        lag_s: lag,
        lag_std_err_s: std_err[1],
        residual_nm: scale,
        after_steps: Squares::of(after.iter().map(|(i, _)| residual(*i))),
        settled: Squares::of(settled(command, feedback, (-dead).max(0.0)).into_iter().flat_map(|hold| hold.readings).map(residual)),
        steps: Squares::of(after.iter().map(|(_, step)| *step)),
    })
}

/// Dead time of the feedback behind a drive that is known, with its standard error [s], where this drive explains the feedback better than
/// the first-order lag of `first`. A feedback of the motor's torque does not show the gear behind it.
pub(crate) fn dead_time_through(
    torque: &EffectiveTorque,
    command: &Series,
    feedback: &Series,
    first: &FeedbackDelays,
) -> Option<(f64, f64)> {
    let largest = torque.largest_nm();
    let near = near_steps(feedback, &torque.steps(0.1 * largest));
    if near.len() < FEWEST_READINGS {
        return None;
    }
    let away = |i: usize, dead_s: f64| feedback.value[i] - torque.at(feedback.t_s[i] - dead_s).torque_nm;
    let cost =
        |dead_s: f64| -> f64 { near.iter().step_by(near.len().div_ceil(MOST_READINGS)).map(|&i| away(i, dead_s).abs().min(largest)).sum() };
    let mut dead_s = dead_times_s().min_by(|a, b| cost(*a).total_cmp(&cost(*b)))?;
    let mut std_err_s = 0.0;
    for _ in 0..ITERATIONS {
        let scale = STD_OF_MEDIAN * crate::signal::median(&near.iter().map(|&i| away(i, dead_s).abs()).collect::<Vec<_>>());
        let (mut information, mut slope) = (0.0, 0.0);
        for &i in &near {
            let (at, r) = (torque.at(feedback.t_s[i] - dead_s), away(i, dead_s));
            let weight = (HUBER * scale / r.abs().max(1e-12)).min(1.0);
            information += weight * at.by_dead_time * at.by_dead_time;
            slope += weight * at.by_dead_time * r;
        }
        if information <= 0.0 {
            return None;
        }
        let step = (slope / information).clamp(-0.02, 0.02);
        dead_s += step;
        std_err_s = scale / information.sqrt();
        if step.abs() < 1e-6 {
            break;
        }
    }
    let lagged = LaggedCommand::new(command, first.lag_s);
    let of_first = Squares::of(near.iter().map(|&i| feedback.value[i] - lagged.at(feedback.t_s[i] - first.dead_time_s).torque_nm));
    let own = Squares::of(near.iter().map(|&i| away(i, dead_s)));
    (own.rms() < of_first.rms()).then_some((dead_s, std_err_s))
}

/// The dead times of a coarse search [s].
fn dead_times_s() -> impl Iterator<Item = f64> {
    (0..=40).map(|k| f64::from(k) * 0.01)
}

/// The readings in the second after a step: only they show delays.
fn near_steps(feedback: &Series, steps: &[f64]) -> Vec<usize> {
    let is_near = |&i: &usize| {
        let t = feedback.t_s[i];
        let k = steps.partition_point(|s| *s <= t);
        k > 0 && t - steps[k - 1] < 1.0
    };
    (0..feedback.len()).filter(is_near).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    #[test]
    fn known_delays_are_found_within_their_standard_errors() {
        let t_s: Vec<f64> = (0..3000).map(|k| f64::from(k) * 0.02).collect();
        let value = t_s.iter().map(|t| if (t / 2.0).floor() % 2.0 == 0.0 { 0.0 } else { 4.0 + (t / 4.0).floor() }).collect();
        let command = Series { t_s: t_s.clone(), value };
        let lagged = LaggedCommand::new(&command, 0.05);
        let mut rng = rand_pcg::Pcg64::seed_from_u64(2);
        let noise = Normal::new(0.0, 0.3).unwrap();
        let feedback = Series {
            t_s: t_s.iter().map(|t| t + 0.007).collect(),
            value: t_s.iter().map(|t| lagged.at(t + 0.007 - 0.048).torque_nm + noise.sample(&mut rng)).collect(),
        };
        let found = delays(&command, &feedback, None).unwrap();
        assert!((found.dead_time_s - 0.048).abs() < 4.0 * found.dead_time_std_err_s + 1e-4, "{found:?}");
        assert!((found.lag_s - 0.05).abs() < 0.004, "{found:?}");
        assert!((found.lag_s - 0.05).abs() < 4.0 * found.lag_std_err_s + 1e-4, "{found:?}");
        let all = std::iter::once(&found);
        assert!(after_step_ratio(all.clone()) < 1.3 && lag_explains(all), "{found:?}");
    }

    #[test]
    fn a_slew_limit_is_no_lag_however_slow_it_is() {
        for limit_nm_s in [60.0, 15.0] {
            let t_s: Vec<f64> = (0..3000).map(|k| f64::from(k) * 0.02).collect();
            let value = t_s.iter().map(|t| if (t / 2.0).floor() % 2.0 == 0.0 { 0.0 } else { 14.0 + (t / 4.0).floor() }).collect();
            let command = Series { t_s: t_s.clone(), value };
            let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
            let noise = Normal::new(0.0, 0.3).unwrap();
            let mut torque = 0.0f64;
            let slewed = command.value.iter().map(|c| {
                torque += (c - torque).clamp(-0.02 * limit_nm_s, 0.02 * limit_nm_s);
                torque + noise.sample(&mut rng)
            });
            let feedback = Series { t_s, value: slewed.collect() };
            let found = delays(&command, &feedback, None).unwrap();
            assert!(
                !lag_explains(std::iter::once(&found)),
                "{limit_nm_s} N·m/s: {} in {found:?}",
                after_step_ratio(std::iter::once(&found))
            );
        }
    }
}
