//! The breaks of one axis of a table: finite, strictly increasing, at least two.

use crate::map::{Error, Result};

/// Grid positions along one axis, strictly increasing.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    breaks: Vec<f64>,
}

impl Axis {
    /// Takes over `breaks`; `name` (with its unit) is used in errors only.
    ///
    /// # Errors
    /// Fewer than two breaks, a break that is not finite, or breaks that do not increase strictly.
    pub fn new(name: &'static str, breaks: Vec<f64>) -> Result<Self> {
        if breaks.len() < 2 {
            return Err(Error::AxisTooShort { axis: name, found: breaks.len() });
        }
        for (index, &value) in breaks.iter().enumerate() {
            if !value.is_finite() {
                return Err(Error::AxisNotFinite { axis: name, index, value });
            }
            if index > 0 && value <= breaks[index - 1] {
                return Err(Error::AxisNotIncreasing { axis: name, index, previous: breaks[index - 1], value });
            }
        }
        Ok(Self { breaks })
    }

    /// Breaks from `start` to `stop` (reached exactly when it is a whole number of steps away) every `step`, each computed as
    /// `start + k·step` and rounded to 1e-9 so that 0.15 is 0.15 and not 0.15000000000000002.
    ///
    /// # Errors
    /// As [`Axis::new`]; a step that is not positive gives an axis that is too short.
    pub fn uniform(name: &'static str, start: f64, step: f64, stop: f64) -> Result<Self> {
        let steps = ((stop - start) / step + 1e-6).floor();
        if step <= 0.0 || !(1.0..1e6).contains(&steps) {
            return Err(Error::AxisTooShort { axis: name, found: 1 });
        }
        Self::new(name, (0..=steps as usize).map(|k| ((start + k as f64 * step) * 1e9).round() / 1e9).collect())
    }

    /// The breaks, strictly increasing.
    pub fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    /// Number of breaks, at least two.
    #[allow(clippy::len_without_is_empty)] // an axis is never empty
    pub fn len(&self) -> usize {
        self.breaks.len()
    }

    /// Smallest break.
    pub fn first(&self) -> f64 {
        self.breaks[0]
    }

    /// Largest break.
    pub fn last(&self) -> f64 {
        self.breaks[self.breaks.len() - 1]
    }

    /// Whether `value` lies between the first and the last break, both included. NaN does not.
    pub fn contains(&self, value: f64) -> bool {
        value >= self.first() && value <= self.last()
    }

    /// Index of the break nearest to `value` (the lower one at a tie).
    pub fn nearest(&self, value: f64) -> usize {
        let upper = self.breaks.partition_point(|&b| b < value).min(self.breaks.len() - 1);
        if upper > 0 && value - self.breaks[upper - 1] <= self.breaks[upper] - value { upper - 1 } else { upper }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn uniform_breaks_are_the_decimals_a_person_would_write() {
        let axis = Axis::uniform("speed [m/s]", 0.0, 0.05, 0.3).unwrap();
        assert_eq!(axis.breaks(), [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3]);
    }

    #[test]
    fn an_axis_that_does_not_increase_is_refused_with_its_place() {
        let error = Axis::new("speed [m/s]", vec![0.0, 0.2, 0.2]).unwrap_err();
        assert!(matches!(error, Error::AxisNotIncreasing { index: 2, .. }), "{error}");
        assert!(Axis::new("speed [m/s]", vec![0.0, f64::NAN]).is_err());
        assert!(Axis::new("speed [m/s]", vec![0.0]).is_err());
    }
}
