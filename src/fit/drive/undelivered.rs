//! Torque that was commanded and not delivered, by the feedback: a governor, a power limit, a drive that derates, a supply that clips.
//!
//! Sample by sample, the feedback is compared with the command through the drive. Torque that stays below it long after a step has settled
//! is not delivered; the interval reaches back to where the feedback left the command.

use crate::fit::drive::lagged_command::LaggedCommand;
use crate::signal::{Series, median, noise_std};

/// Least difference that counts, as a share of the largest command.
const LEAST_SHARE: f64 = 0.03;
/// Least difference in standard deviations of a mean over the window.
const LEAST_STD: f64 = 4.0;
/// Readings of a mean.
const WINDOW: usize = 5;
/// A difference is judged from this time after a change of the command on, in mean lags and in seconds.
const SETTLED: (f64, f64) = (6.0, 0.5);
/// Shortest interval [s], and the margin at both its ends.
const SHORTEST_S: f64 = 0.15;
const MARGIN_S: f64 = 0.06;

/// After the interval the command is not the torque until the drive no longer depends on its earlier torque, in lags.
const FORGOTTEN: f64 = 5.0;

/// An interval without the commanded torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Undelivered {
    /// First and last moment on the command's clock [s].
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
    /// End of the time in which the torque depends on the torque delivered in it [s].
    pub(crate) forgotten_s: f64,
    /// Median torque delivered in it [N·m].
    pub(crate) torque_nm: f64,
    /// Median share of the commanded torque that was delivered.
    pub(crate) share: f64,
}

/// The intervals of one log in order. `feedback` is corrected by its scale and offset; it shows the command `dead_time_s` late and lagged.
pub(crate) fn undelivered(command: &Series, feedback: &Series, delays_s: (f64, f64)) -> Vec<Undelivered> {
    departures(command, feedback, delays_s, 1.0)
}

/// Time for which the feedback shows more torque than was asked for [s].
pub(crate) fn exceeded_s(command: &Series, feedback: &Series, delays_s: (f64, f64)) -> f64 {
    departures(command, feedback, delays_s, -1.0).iter().map(|d| d.to_s - d.from_s).sum()
}

/// The intervals in which the feedback is on one side of the command: 1 below its magnitude, −1 above.
fn departures(command: &Series, feedback: &Series, (dead_time_s, lag_s): (f64, f64), side: f64) -> Vec<Undelivered> {
    let largest = command.value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let asked = LaggedCommand::new(command, lag_s);
    let settled_s = (SETTLED.0 * lag_s).max(SETTLED.1);
    let least_nm = (LEAST_STD * noise_std(&feedback.value) / (WINDOW as f64).sqrt()).max(LEAST_SHARE * largest);
    let short_nm = |i: usize| {
        let asked_nm = asked.at(feedback.t_s[i] - dead_time_s).torque_nm;
        (asked_nm - feedback.value[i]) * asked_nm.signum() * side
    };
    let count = feedback.len();
    let short: Vec<f64> = (0..count).map(short_nm).collect();
    let mean = |i: usize| {
        let window = &short[i.saturating_sub(WINDOW / 2)..(i + WINDOW / 2 + 1).min(count)];
        window.iter().sum::<f64>() / window.len() as f64
    };
    let lacks: Vec<bool> = (0..count).map(|i| mean(i) > least_nm).collect();
    let mut settled = vec![false; count];
    let changes = asked.steps(1e-3 * largest);
    for (i, settled) in settled.iter_mut().enumerate() {
        let t = feedback.t_s[i] - dead_time_s;
        let last = changes[..changes.partition_point(|c| *c <= t)].last();
        *settled = last.is_none_or(|c| t - c > settled_s);
    }
    let mut found = Vec::new();
    let mut i = 0;
    while i < count {
        if !lacks[i] {
            i += 1;
            continue;
        }
        let first = i;
        while i < count && lacks[i] {
            i += 1;
        }
        let of_settled: Vec<usize> = (first..i).filter(|k| settled[*k]).collect();
        let (Some(a), Some(b)) = (of_settled.first(), of_settled.last()) else { continue };
        if feedback.t_s[*b] - feedback.t_s[*a] >= SHORTEST_S {
            let delivered: Vec<f64> = of_settled.iter().map(|k| feedback.value[*k]).collect();
            let shares: Vec<f64> =
                of_settled.iter().map(|k| feedback.value[*k] / asked.at(feedback.t_s[*k] - dead_time_s).torque_nm).collect();
            let (from_s, to_s) = (feedback.t_s[first] - dead_time_s - MARGIN_S, feedback.t_s[i - 1] - dead_time_s);
            found.push(Undelivered {
                from_s,
                to_s,
                forgotten_s: to_s + FORGOTTEN * lag_s,
                torque_nm: median(&delivered),
                share: median(&shares),
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torque_that_falls_behind_long_after_a_step_is_found_and_a_ramp_is_not() {
        let t_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.02).collect();
        let value = t_s.iter().map(|t| if (2.0..6.0).contains(t) || (10.0..14.0).contains(t) { 30.0 } else { 0.0 }).collect();
        let command = Series { t_s: t_s.clone(), value };
        let lagged = LaggedCommand::new(&command, 0.05);
        let noise = |k: usize| 0.3 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
        let read = |(k, t): (usize, &f64)| {
            let u = lagged.at(t - 0.04).torque_nm;
            // a governor from 12 s on
            noise(k) + if (12.0..14.2).contains(t) { u.min(20.0) } else { u }
        };
        let feedback = Series { value: t_s.iter().enumerate().map(read).collect(), t_s };
        let found = undelivered(&command, &feedback, (0.04, 0.05));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!((found[0].from_s - 11.9).abs() < 0.08 && (found[0].to_s - 14.1).abs() < 0.15 && (found[0].torque_nm - 20.0).abs() < 0.2);
        assert!((found[0].share - 20.0 / 30.0).abs() < 0.01, "{found:?}");
        assert_eq!(exceeded_s(&command, &feedback, (0.04, 0.05)), 0.0);
        let clipped = Series { t_s: command.t_s.clone(), value: command.value.iter().map(|u| u.min(24.0)).collect() };
        assert!((exceeded_s(&clipped, &feedback, (0.04, 0.05)) - 5.5).abs() < 1.5, "{}", exceeded_s(&clipped, &feedback, (0.04, 0.05)));
    }
}
