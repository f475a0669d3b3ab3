//! Two publishers on one topic of commands: values that come and go from message to message.
//!
//! A command is held. A second publisher interrupts it for one or two messages, again and again, always with the same value. Its messages
//! are found, and removed where the torque feedback shows that the drive follows the rest. Otherwise it is an error.

use crate::signal::response::HeldMeans;
use crate::signal::{Error, Result, Series, median};
use std::collections::BTreeMap;

/// Longest interruption: of messages, and of time [s].
const LONGEST: usize = 3;
const LONGEST_S: f64 = 0.3;
/// Fewest interruptions, and their least share of all changes, that show a second publisher.
const FEWEST: usize = 20;
const MOSTLY: f64 = 0.5;
/// Share of the interruptions with one value.
const ONE_VALUE: f64 = 0.9;

/// A command of two publishers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TwoPublishers {
    /// Number of interruptions.
    pub interruptions: usize,
    /// The value of the second publisher [N·m]; absent if there are several.
    pub value_nm: Option<f64>,
    /// The command without the second publisher.
    pub first: Series,
    /// The time between interruptions [s].
    pub period_s: f64,
}

/// Finds a second publisher in a command.
pub(crate) fn two_publishers(command: &Series) -> Option<TwoPublishers> {
    let values = &command.value;
    let mut values_of: BTreeMap<u64, usize> = BTreeMap::new();
    let mut interrupting = vec![false; values.len()];
    let (mut interruptions, mut changes, mut starts) = (0, 0, Vec::new());
    let mut k = 1;
    while k < values.len() {
        if values[k] == values[k - 1] {
            k += 1;
            continue;
        }
        changes += 1;
        let end = (k + 1..(k + 1 + LONGEST).min(values.len())).find(|&n| values[n] != values[k]);
        if let Some(end) = end.filter(|&n| values[n] == values[k - 1] && command.t_s[n] - command.t_s[k - 1] < LONGEST_S) {
            interruptions += 1;
            changes += 1;
            starts.push(command.t_s[k]);
            *values_of.entry(values[k].to_bits()).or_default() += 1;
            interrupting[k..end].fill(true);
            k = end;
        }
        k += 1;
    }
    if interruptions < FEWEST || (2 * interruptions) as f64 <= MOSTLY * f64::from(changes) {
        return None;
    }
    let (bits, count) = values_of.iter().max_by_key(|(_, count)| **count)?;
    let value = f64::from_bits(*bits);
    let is_one = *count as f64 > ONE_VALUE * interruptions as f64;
    // next to a step, an interruption has another value on each side
    let is_second = |k: usize| {
        let short = || {
            let from = (0..k).rev().take(LONGEST).find(|&n| values[n] != value).map_or(usize::MAX, |n| n);
            let to = (k + 1..values.len()).take(LONGEST).find(|&n| values[n] != value);
            to.is_some_and(|to| from < k && to - from <= LONGEST + 1 && command.t_s[to] - command.t_s[from] < LONGEST_S)
        };
        interrupting[k] || (values[k] == value && short())
    };
    let kept = (0..values.len()).filter(|&k| !is_second(k));
    let first = kept.fold(Series::default(), |mut first, k| {
        first.t_s.push(command.t_s[k]);
        first.value.push(values[k]);
        first
    });
    let between: Vec<f64> = starts.windows(2).map(|t| t[1] - t[0]).collect();
    Some(TwoPublishers { interruptions, value_nm: is_one.then_some(value), first, period_s: median(&between) })
}

/// A held command counts from this time after its step [s]: the drive has settled.
const SETTLED_S: f64 = 0.5;
/// Fewest readings of the feedback that show which command the drive follows.
const FEWEST_READINGS: usize = 50;
/// The feedback decides when its distance from one command is less than this share of their difference.
const NEARER: f64 = 0.25;

impl TwoPublishers {
    /// The command that the wheel follows, with a note: the torque feedback shows whether the drive follows the first publisher or always
    /// the last message. (The motion does not: an interrupted torque acts as a smaller one, and that would move another vehicle alike.)
    ///
    /// # Errors
    /// There is no feedback, or it follows neither.
    pub(crate) fn followed(self, whole: &Series, feedback: Option<&Series>, notes: &mut Vec<String>) -> Result<Series> {
        let found = self.value_nm.map_or_else(|| "several values".to_owned(), |v| format!("{v} N·m"));
        let doubt = || Error::TwoPublishers { interruptions: self.interruptions, found: found.clone() };
        let value = self.value_nm.ok_or_else(doubt)?;
        let (by_feedback, by_last) = feedback.and_then(|feedback| self.shares(whole, feedback, value)).ok_or_else(doubt)?;
        let apart = 1.0 - by_last;
        let (is_first, is_last) = ((by_feedback - 1.0).abs() < NEARER * apart, (by_feedback - by_last).abs() < NEARER * apart);
        let (command, how) = match (is_first, is_last) {
            (true, _) => (self.first.clone(), "the drive follows the command without it"),
            (false, true) => (whole.clone(), "the drive follows the last message of either"),
            (false, false) => return Err(doubt()),
        };
        notes.push(format!(
            "torque has two publishers: {found} interrupts the command {} times, every {:.0} ms. The torque feedback shows that {how}; that command is used",
            self.interruptions,
            1e3 * self.period_s
        ));
        Ok(command)
    }

    /// The share of the first publisher's command that the feedback shows, and that of the last message's.
    fn shares(&self, whole: &Series, feedback: &Series, value: f64) -> Option<(f64, f64)> {
        let last = HeldMeans::of(whole)?;
        let (mut xx, mut by_feedback, mut by_last, mut count) = (0.0, 0.0, 0.0, 0);
        for (t_s, torque) in feedback.t_s.iter().zip(&feedback.value) {
            let Some(first) = self.first.held(*t_s).filter(|c| self.first.held(t_s - SETTLED_S) == Some(*c)) else { continue };
            let x = first - value;
            xx += x * x;
            by_feedback += x * (torque - value);
            by_last += x * (last.mean(*t_s) - value);
            count += usize::from(x != 0.0);
        }
        (count >= FEWEST_READINGS && xx > 0.0).then(|| (by_feedback / xx, by_last / xx))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn campaign(second: impl Fn(usize) -> Option<f64>) -> Series {
        let mut command = Series::default();
        for k in 0..5000 {
            let t = k as f64 * 0.02;
            command.t_s.push(t);
            command.value.push([0.0, 12.0, 20.0, -8.0, 0.0, -16.0][(t / 2.0) as usize % 6]);
            if let Some(value) = second(k) {
                command.t_s.push(t + 0.005);
                command.value.push(value);
            }
        }
        command
    }

    #[test]
    fn a_second_publisher_is_found_and_removed_and_steps_are_not() {
        assert!(two_publishers(&campaign(|_| None)).is_none());
        let found = two_publishers(&campaign(|k| (k % 5 == 0).then_some(0.0))).unwrap();
        assert_eq!(found.value_nm, Some(0.0));
        let alone = campaign(|_| None);
        let differs =
            (0..5000).filter(|k| found.first.held(f64::from(*k) * 0.02 + 0.012) != alone.held(f64::from(*k) * 0.02 + 0.012)).count();
        assert!(differs <= 50, "{differs}");
        let both = campaign(|k| (k % 5 == 0).then_some(0.0));
        let mut notes = Vec::new();
        let used = found.clone().followed(&both, Some(&alone), &mut notes).unwrap();
        assert!(used == found.first && notes[0].contains("two publishers"));
        let slow =
            Series { t_s: alone.t_s.clone(), value: HeldMeans::of(&both).map(|m| alone.t_s.iter().map(|t| m.mean(*t)).collect()).unwrap() };
        assert_eq!(found.clone().followed(&both, Some(&slow), &mut notes).unwrap(), both);
        assert!(found.followed(&both, None, &mut notes).is_err());
    }

    #[test]
    fn two_campaigns_at_once_have_no_command() {
        let other = |k: usize| Some([3.0, 9.0, -4.0, 15.0][(k / 37) % 4]);
        let found = two_publishers(&campaign(other)).unwrap();
        assert!(found.followed(&campaign(other), Some(&campaign(|_| None)), &mut Vec::new()).is_err());
    }
}
