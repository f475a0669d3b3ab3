//! Raw integers of a controller: value = scale · raw + offset, with raw in 16 bits.

use serde::{Deserialize, Serialize};

/// What one count of a raw 16-bit integer is worth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawUnit {
    /// Value of one count, above 0.
    pub scale: f64,
    /// Value of the raw 0.
    #[serde(default)]
    pub offset: f64,
}

/// Share of the raw range that an automatic scale uses at most: the limits of a value may be a little beyond its table.
const USED: f64 = 0.98;

impl RawUnit {
    /// Without an offset, the finest scale of the form 1, 2 or 5 · 10ⁿ that holds −`largest` to `largest`.
    pub fn finest(largest: f64) -> Self {
        let least = (largest / (USED * f64::from(i16::MAX))).max(1e-9);
        let power = 10f64.powi(least.log10().floor() as i32);
        let rung = [1.0, 2.0, 5.0, 10.0].into_iter().find(|rung| rung * power >= least * (1.0 - 1e-12)).unwrap_or(10.0);
        // as the decimal that a person would write
        let digits = (3 - power.log10().floor() as i32).max(0) as usize;
        let scale = format!("{:.digits$}", rung * power).parse().unwrap_or(rung * power);
        Self { scale, offset: 0.0 }
    }

    /// Whether scale and offset are numbers, and the scale is above 0.
    pub fn is_valid(self) -> bool {
        self.scale.is_finite() && self.scale > 0.0 && self.offset.is_finite()
    }

    /// The value of a raw integer, as the controller computes it: one product, one sum.
    pub fn value(self, raw: i16) -> f64 {
        self.scale * f64::from(raw) + self.offset
    }

    /// The raw integer nearest to a value; `None` if it does not fit into 16 bits.
    pub fn raw(self, value: f64) -> Option<i16> {
        let raw = ((value - self.offset) / self.scale).round();
        (raw >= f64::from(i16::MIN) && raw <= f64::from(i16::MAX)).then_some(raw as i16)
    }

    /// Least and largest value.
    pub fn range(self) -> [f64; 2] {
        [self.value(i16::MIN), self.value(i16::MAX)]
    }
}

/// Raw units of a Table 2; an axis without one has any number.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawUnits {
    /// Of the speed breaks [m/s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_mps: Option<RawUnit>,
    /// Of the breaks of the desired acceleration [m/s²].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_mps2: Option<RawUnit>,
    /// Of the torques [N·m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_nm: Option<RawUnit>,
}

impl RawUnits {
    /// Whether no axis has one.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_finest_scale_holds_the_largest_value_and_half_of_it_would_not() {
        for (largest, scale) in [(44.0, 0.002), (1.1, 0.00005), (90.0, 0.005), (3.0, 0.0001), (320.0, 0.01)] {
            let unit = RawUnit::finest(largest);
            assert_eq!(unit, RawUnit { scale, offset: 0.0 });
            assert!(unit.raw(largest).is_some() && unit.raw(-largest).is_some());
        }
    }

    #[test]
    fn a_value_comes_back_within_half_a_count_and_what_does_not_fit_is_none() {
        let unit = RawUnit { scale: 0.01, offset: -100.0 };
        assert!((unit.value(unit.raw(12.344).unwrap()) - 12.344).abs() <= 0.005 + 1e-12);
        assert_eq!((unit.raw(-100.0), unit.raw(300.0), unit.raw(f64::NAN)), (Some(0), None, None));
    }
}
