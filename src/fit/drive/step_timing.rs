//! The true time of a torque step. A log shows a change of the command by the first message after it. That message is late by
//! the sampling phase, which is part of the dead time, and by its jitter; where messages were lost, it is late by up to as many periods
//! more.
//!
//! A step of the acceleration by Δa that is δ late leaves a permanent speed error δ·Δa. That is a random step of the speed, which builds up
//! as the drive's lag does, and not a disturbance that fades: if it is ignored, a single lost message bends the surface and the offsets of
//! a whole run. The filter treats it as noise that enters while the torque moves, (δ·Δa)²·(1 − e^(−x/T_c))² after a time x. The messages'
//! own intervals give the usual size of δ. (The likelihood does not: with δ free, it assigns to δ the part of a power limit that the
//! surface does not hold.)

use crate::fit::noise::model::Reading;
use crate::log::MessageKind;
use crate::signal::{Series, median};
use std::f64::consts::SQRT_2;

/// A command is periodic when this share of its intervals lies within half a period of their median.
const PERIODIC_SHARE: f64 = 0.8;
/// A command with a longer period was thinned out for the log: the drive received it up to a period earlier [s].
const THINNED_S: f64 = 0.08;
/// A step is over after this many time constants of the lag.
const OVER: f64 = 6.0;
/// Changes smaller than this share of the largest command are ignored.
const LEAST_SHARE: f64 = 1e-3;

/// A change of the command.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Change {
    /// Earliest time of the change [s]: a period after the message before.
    from_s: f64,
    from_nm: f64,
    to_nm: f64,
    /// Largest delay of the message that shows it, when messages are missing [s].
    most_s: f64,
    /// Mean square delay beyond that of all messages [s²].
    late_s2: f64,
}

/// The changes of one log's command.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct StepTiming {
    changes: Vec<Change>,
}

impl StepTiming {
    /// From a command. If messages come only when it changes, they count as in time, and none can be seen to be missing.
    pub(crate) fn new(command: &Series) -> Self {
        let t = &command.t_s;
        let period_s = command.median_period_s();
        let regular = t.windows(2).filter(|w| (w[1] - w[0] - period_s).abs() <= 0.5 * period_s).count();
        let is_regular = period_s > 0.0 && regular as f64 >= PERIODIC_SHARE * (t.len().max(2) - 1) as f64;
        // the holds of a campaign may be equally long
        let periodic = is_regular && !MessageKind::of(t, &command.value).is_held();
        // an interval has the jitter of both its ends
        let strays: Vec<f64> = t.windows(2).map(|w| (w[1] - w[0] - period_s).abs()).collect();
        let jitter_s = if periodic { 1.4826 * median(&strays) / SQRT_2 } else { 0.0 };
        let late = |k: usize| {
            let periods = if periodic { ((t[k] - t[k - 1]) / period_s).round().max(1.0) } else { 1.0 };
            // equally likely in any of the periods: late by none, by one, ... by all but one
            let thinned_s2 = if periodic && period_s > THINNED_S { period_s * period_s / 12.0 } else { 0.0 };
            let late_s2 = thinned_s2 + jitter_s * jitter_s + period_s * period_s * (periods - 1.0) * (2.0 * periods - 1.0) / 6.0;
            ((periods - 1.0) * period_s, late_s2)
        };
        Self::of_changes(command, late)
    }

    /// From a command whose changes are all shown late by this root mean square [s].
    pub(crate) fn late(command: &Series, late_s: f64) -> Self {
        Self::of_changes(command, |_| (0.0, late_s * late_s))
    }

    /// The same, for a command whose times have the standard deviation `std_s` [s].
    pub(crate) fn unsure(mut self, std_s: f64) -> Self {
        self.changes.iter_mut().for_each(|change| change.late_s2 += std_s * std_s);
        self
    }

    /// `late` gives the largest and the mean square delay of a sample [s, s²].
    fn of_changes(Series { t_s, value }: &Series, late: impl Fn(usize) -> (f64, f64)) -> Self {
        let least_nm = LEAST_SHARE * value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let change = |k: usize| {
            let (most_s, late_s2) = late(k);
            Change { from_s: t_s[k] - most_s, most_s, from_nm: value[k - 1], to_nm: value[k], late_s2 }
        };
        Self { changes: (1..t_s.len()).filter(|&k| (value[k] - value[k - 1]).abs() > least_nm).map(change).collect() }
    }

    /// Whether messages are missing before the one at `t_s` that shows a change.
    pub(crate) fn follows_a_gap(&self, t_s: f64) -> bool {
        let at = |c: &&Change| (c.from_s + c.most_s - t_s).abs() < 1e-6;
        let near = self.changes.partition_point(|c| c.from_s < t_s + 1e-6);
        self.changes[..near].iter().rev().take(2).find(at).is_some_and(|c| c.most_s > 0.0)
    }

    /// Adds to `readings`, in order of time and first reached from `start_s`, the variance of the speed due to the steps. `sign` turns a
    /// command into the gear's frame; `accel_mps2` is the acceleration at a speed and a torque.
    pub(crate) fn add_to(
        &self,
        readings: &mut [Reading],
        start_s: f64,
        (sign, dead_time_s, lag_s): (f64, f64, f64),
        accel_mps2: impl Fn(f64, f64) -> f64,
    ) {
        let Some(last_s) = readings.last().map(|r| r.t_s) else { return };
        let over_s = OVER * lag_s;
        let first = self.changes.partition_point(|c| c.from_s + dead_time_s + over_s < start_s);
        for change in self.changes[first..].iter().take_while(|c| c.from_s + dead_time_s < last_s) {
            let from_s = change.from_s + dead_time_s;
            // share of the step's speed that has built up
            let come = |t: f64| if lag_s > 1e-4 { 1.0 - (-(t - from_s).max(0.0) / lag_s).exp() } else { f64::from(t > from_s) };
            let k = readings.partition_point(|r| r.t_s <= from_s);
            let mut before = come(if k > 0 { readings[k - 1].t_s } else { start_s });
            for reading in readings[k..].iter_mut().take_while(|r| r.t_s <= from_s + over_s.max(0.05)) {
                let now = come(reading.t_s);
                let v = reading.speed_mps.max(0.0);
                let jump_mps2 = accel_mps2(v, sign * change.to_nm) - accel_mps2(v, sign * change.from_nm);
                reading.shaken_mps_2 += jump_mps2 * jump_mps2 * (now * now - before * before) * change.late_s2;
                before = now;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Every 20 ms and up to `jitter_s` more or less, uniform, 10 N·m from 1 s on, without the messages numbered in `lost`.
    fn command(jitter_s: f64, lost: &[usize]) -> Series {
        let kept = (0..100).filter(|k| !lost.contains(k));
        kept.fold(Series::default(), |mut series, k| {
            series.t_s.push(k as f64 * 0.02 + jitter_s * ((k * k * 7919 % 101) as f64 / 50.0 - 1.0));
            series.value.push(if k >= 50 { 10.0 } else { 0.0 });
            series
        })
    }

    fn timed(command: &Series, start_s: f64) -> Vec<Reading> {
        let mut readings: Vec<Reading> = (0..200u32).map(|k| Reading::single(0.5 + 0.01 * f64::from(k), 0.2, 0, k)).collect();
        readings.retain(|r| r.t_s > start_s);
        StepTiming::new(command).add_to(&mut readings, start_s, (1.0, 0.05, 0.04), |_, u| 0.03 * u);
        readings
    }

    fn sum(readings: &[Reading]) -> f64 {
        readings.iter().map(|r| r.shaken_mps_2).sum()
    }

    #[test]
    fn a_step_makes_the_speed_uncertain_while_the_torque_moves_and_only_then() {
        let readings = timed(&command(2e-3, &[]), 0.5);
        let whole = sum(&readings);
        // a uniform spread of ±2 ms has a standard deviation of 2 ms/√3; a median deviation, scaled as for a normal one, is close to it
        let jitter_s = (whole / 0.09).sqrt();
        assert!((0.9e-3..1.5e-3).contains(&jitter_s), "{jitter_s}");
        let moves = |r: &&Reading| r.shaken_mps_2 > 0.0;
        let (first, last) = (readings.iter().find(moves).unwrap(), readings.iter().rfind(moves).unwrap());
        assert!((first.t_s - 1.05).abs() < 0.0121 && last.t_s < 1.05 + 6.0 * 0.04 + 0.01, "{} {}", first.t_s, last.t_s);
        // the part before the start belongs to the start
        let share = sum(&timed(&command(2e-3, &[]), 1.09)) / whole;
        assert!((share - (1.0 - (1.0 - (-1.0f64).exp()).powi(2))).abs() < 0.05, "{share}");
    }

    #[test]
    fn a_lost_message_makes_the_step_uncertain_by_a_period() {
        let shaken = |lost: &[usize]| sum(&timed(&command(0.0, lost), 0.5));
        // zero or one period late: half of 20 ms squared
        assert!((shaken(&[50]) - 0.09 * 0.5 * 0.02f64.powi(2)).abs() < 1e-7);
        assert!((shaken(&[49, 50]) - 0.09 * 5.0 / 3.0 * 0.02f64.powi(2)).abs() < 3e-7);
        assert!(shaken(&[30, 60]) < 1e-12);
        let late = |lost: &[usize], t_s: f64| StepTiming::new(&command(0.0, lost)).follows_a_gap(t_s);
        assert!(late(&[50], 1.02) && !late(&[50], 1.0) && !late(&[30], 1.0) && !late(&[], 1.0));
        // messages only at changes
        let sparse = Series { t_s: vec![0.0, 1.0, 5.0], value: vec![0.0, 10.0, 0.0] };
        assert!(sum(&timed(&sparse, 0.5)) == 0.0);
        assert_eq!(StepTiming::new(&Series::default()), StepTiming::default());
    }
}
