//! Between which values a signal lies, in which steps, and how often it is at an end.

use serde::Serialize;

/// The values of a signal, in its own unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ValueRange {
    /// The lowest value.
    pub lowest: f64,
    /// The highest value.
    pub highest: f64,
    /// The step of which all differences are multiples, if the values repeat: the resolution of the sensor, or of its message.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// Share of the values at the lowest or the highest, if the values between them are many: a sensor or an amplifier at its limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_limit_share: Option<f64>,
}

/// Fewest messages for each different value from which a step is looked for.
const REPEATS: usize = 4;
/// Largest departure of a difference from a multiple of the step, as a share of the step.
const MULTIPLE: f64 = 0.05;
/// Fewest different values of a signal that is no sequence of levels.
const MANY: usize = 30;
/// Smallest share at an end that counts: a moving signal passes its largest value, and does not stay there.
const LEAST_AT_LIMIT: f64 = 0.02;

impl ValueRange {
    /// Of finite values; `None` without any.
    pub(crate) fn of(values: &[f64]) -> Option<Self> {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let (lowest, highest) = (*sorted.first()?, *sorted.last()?);
        let count = sorted.len();
        // values that differ by the rounding of a unit's factor alone are one
        let same = 1e-9 * (highest - lowest);
        let at = |end: f64| sorted.iter().filter(|value| (*value - end).abs() <= same).count();
        let ends = if highest > lowest { at(lowest).max(at(highest)) } else { 0 };
        let mut levels = sorted.clone();
        levels.dedup_by(|next, kept| *next - *kept <= same);
        let share = ends as f64 / count as f64;
        Some(Self {
            lowest,
            highest,
            step: (levels.len() * REPEATS <= count).then(|| step(&levels)).flatten(),
            at_limit_share: (levels.len() >= MANY && share >= LEAST_AT_LIMIT).then_some(share),
        })
    }
}

/// The step of levels in ascending order, if all differences are multiples of it.
fn step(levels: &[f64]) -> Option<f64> {
    let gaps = || levels.windows(2).map(|pair| pair[1] - pair[0]);
    let smallest = gaps().min_by(f64::total_cmp)?;
    let is_multiple = |gap: f64| (gap / smallest - (gap / smallest).round()).abs() <= MULTIPLE;
    (levels.len() > 2 && gaps().all(is_multiple)).then_some(smallest)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_reading_in_steps_shows_them_and_a_smooth_one_does_not() {
        let coarse: Vec<f64> = (0..400).map(|k| (f64::from(k) * 0.05).sin().mul_add(20.0, 0.0).round() * 0.05).collect();
        let found = ValueRange::of(&coarse).unwrap();
        assert!((found.step.unwrap() - 0.05).abs() < 1e-9 && (found.highest - 1.0).abs() < 1e-9, "{found:?}");
        let smooth: Vec<f64> = (0..400).map(|k| (f64::from(k) * 0.05).sin()).collect();
        assert_eq!(ValueRange::of(&smooth).unwrap().step, None);
        assert_eq!(ValueRange::of(&[]), None);
    }

    #[test]
    fn a_signal_that_is_cut_off_stays_at_its_limit_and_levels_are_no_limit() {
        let cut: Vec<f64> = (0..400).map(|k| (f64::from(k) * 0.05).sin().min(0.8)).collect();
        let share = ValueRange::of(&cut).unwrap().at_limit_share.unwrap();
        assert!((0.1..0.5).contains(&share), "{share}");
        let levels: Vec<f64> = (0..400).map(|k| f64::from(k / 100) * 6.0).collect();
        let found = ValueRange::of(&levels).unwrap();
        assert_eq!((found.at_limit_share, found.step), (None, Some(6.0)));
    }
}
