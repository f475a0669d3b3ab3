//! Scale and offset of a torque feedback against the command: feedback = scale·command + offset where the drive delivers the commanded
//! torque.
//!
//! A limited torque, a governor or a stalled drive bend a line through all readings, and may affect most of them. So the scale is the
//! largest ratio of single readings that many of them share: a drive that does not deliver only lowers them. The offset is the median at no
//! command.

use crate::signal::{Series, median};

/// A reading counts from this time after the last change of the command on [s].
const SETTLED_S: f64 = 0.3;
/// Commands below this share of the largest count as zero.
const NONE: f64 = 0.01;
/// Commands above this share of the largest show the scale.
const LARGE: f64 = 0.2;
/// Fewest readings of either kind.
const FEWEST: usize = 20;
/// Ratios within this distance of one…
const NEAR_ONE: f64 = 0.03;
/// … give the scale if at least this share of all ratios is among them.
const SHARE_NEAR_ONE: f64 = 0.2;
/// Otherwise the scale is the largest ratio that this share of all has within this width.
const SHARE_OF_MODE: f64 = 0.15;
const WIDTH_OF_MODE: f64 = 0.06;
/// Number of iterations of a group's centre from the readings around it.
const CENTRINGS: usize = 3;
/// More ratios than this do not make it more accurate.
const ENOUGH: usize = 20_000;

/// Scale and offset of a feedback.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FeedbackScale {
    /// Feedback over command.
    pub(crate) scale: f64,
    /// Feedback at zero command [N·m].
    pub(crate) offset_nm: f64,
}

impl FeedbackScale {
    /// From a command and its feedback; `None` without enough readings at large commands.
    pub(crate) fn of(command: &Series, feedback: &Series) -> Option<Self> {
        let largest = command.value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let (mut none, mut large) = (Vec::new(), Vec::new());
        let (mut k, mut changed_s, mut until_s) = (0, f64::NEG_INFINITY, f64::NEG_INFINITY);
        for (t, f) in feedback.t_s.iter().zip(&feedback.value) {
            while k + 1 < command.len() && command.t_s[k + 1] <= *t {
                k += 1;
                if command.value[k] != command.value[k - 1] {
                    changed_s = command.t_s[k];
                }
            }
            if *t > until_s {
                until_s = next_change_s(command, k);
            }
            let asked_nm = command.value.get(k).copied().unwrap_or(0.0);
            // a slow drive has not settled in the first half of a hold
            if *t - changed_s < SETTLED_S.max(0.5 * (until_s - changed_s)) {
                continue;
            }
            if asked_nm.abs() <= NONE * largest {
                none.push(*f);
            } else if asked_nm.abs() > LARGE * largest {
                large.push((asked_nm, *f));
            }
        }
        if large.len() < FEWEST {
            return None;
        }
        let offset_nm = if none.len() < FEWEST { 0.0 } else { median(&none) };
        let stride = large.len().div_ceil(ENOUGH);
        let ratios: Vec<f64> = large.iter().step_by(stride).map(|(asked, f)| (f - offset_nm) / asked).collect();
        let near_one: Vec<f64> = ratios.iter().copied().filter(|r| (r - 1.0).abs() < NEAR_ONE).collect();
        let agrees = near_one.len() as f64 > SHARE_NEAR_ONE * ratios.len() as f64;
        let about = if agrees { median(&near_one) } else { largest_shared(&ratios) };
        let scale = centred(&ratios, about);
        Some(Self { scale, offset_nm })
    }

    /// The torque that a reading means [N·m].
    pub(crate) fn torque_nm(&self, reading_nm: f64) -> f64 {
        (reading_nm - self.offset_nm) / self.scale
    }

    /// The feedback as the torque that it means; `None` where the scale is of no use.
    pub(crate) fn corrected(&self, feedback: &Series) -> Option<Series> {
        (self.scale.abs() > 1e-3)
            .then(|| Series { t_s: feedback.t_s.clone(), value: feedback.value.iter().map(|f| self.torque_nm(*f)).collect() })
    }
}

/// When the command of message `k` changes, or the last message [s].
fn next_change_s(command: &Series, k: usize) -> f64 {
    let change = command.value[k..].windows(2).position(|pair| pair[0] != pair[1]);
    change.map_or_else(|| command.t_s.last().copied().unwrap_or(0.0), |n| command.t_s[k + n + 1])
}

/// The largest ratio that many readings share, or a little more: a drive that does not deliver only lowers them.
fn largest_shared(values: &[f64]) -> f64 {
    let sign = median(values).signum();
    let mut values: Vec<f64> = values.iter().map(|v| sign * v).collect();
    values.sort_unstable_by(|a, b| b.total_cmp(a));
    let enough = (SHARE_OF_MODE * values.len() as f64).ceil().max(1.0) as usize;
    let group = (0..values.len()).find_map(|k| {
        let to = k + values[k..].partition_point(|v| *v > values[k] * (1.0 - WIDTH_OF_MODE));
        (to - k >= enough).then_some(k..to)
    });
    sign * median(&values[group.unwrap_or(0..values.len())])
}

/// The centre of the readings around one of them. The first group of the largest readings leans upward with their noise.
fn centred(values: &[f64], about: f64) -> f64 {
    (0..CENTRINGS).fold(about, |centre, _| {
        let near: Vec<f64> = values.iter().copied().filter(|v| (v - centre).abs() < 0.5 * WIDTH_OF_MODE * centre.abs()).collect();
        if near.is_empty() { centre } else { median(&near) }
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Holds of 2 s at some torques, with noise that repeats.
    fn driven(read: impl Fn(f64) -> f64) -> (Series, Series) {
        let t_s: Vec<f64> = (0..4000).map(|k| f64::from(k) * 0.02).collect();
        let levels = [0.0, 12.0, 0.0, 20.0, 0.0, 32.0, 0.0, 40.0];
        let command: Vec<f64> = t_s.iter().map(|t| levels[(t / 2.0) as usize % 8]).collect();
        let noise = |k: usize| 0.2 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
        let feedback = command.iter().enumerate().map(|(k, c)| read(*c) + noise(k)).collect();
        (Series { t_s: t_s.clone(), value: command }, Series { t_s, value: feedback })
    }

    #[test]
    fn scale_and_offset_are_found_although_half_of_the_torques_are_not_delivered() {
        for (scale, offset) in [(1.0, 0.08), (0.8, -0.3), (0.31, 0.0), (-1.0, 0.1)] {
            let (command, feedback) = driven(|u| scale * u.min(21.0) + offset);
            let found = FeedbackScale::of(&command, &feedback).unwrap();
            assert!((found.scale - scale).abs() < 0.006, "{scale}: {found:?}");
            assert!((found.offset_nm - offset).abs() < 0.05, "{offset}: {found:?}");
        }
        let (command, feedback) = driven(|u| 0.5 * u);
        let corrected = FeedbackScale::of(&command, &feedback).unwrap().corrected(&feedback).unwrap();
        assert!(corrected.value.iter().zip(&command.value).all(|(f, c)| (f - c).abs() < 1.5));
    }
}
