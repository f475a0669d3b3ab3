//! Scale and delay between two sources of one speed.

use crate::signal::{Series, median};

/// signal(t) ≈ scale · reference(t − `delay_s`): scale and delay of a signal relative to a reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Alignment {
    /// Signal over reference.
    pub scale: f64,
    /// Delay of the signal after the reference [s].
    pub delay_s: f64,
}

/// Range of the delay search [s].
const DELAY_RANGE_S: f64 = 0.3;

/// Scales of one speed in two units, such as degrees for radians or revolutions per minute for radians per second, and of a wrong radius
/// with it. A scale outside of it is no scale.
const SCALES: std::ops::Range<f64> = 0.005..200.0;

impl Alignment {
    /// No difference.
    pub(crate) const SAME: Self = Self { scale: 1.0, delay_s: 0.0 };

    /// Compares `signal` with `reference` over the samples for which `usable(t)` holds. The result is the delay within ±0.3 s, to 1 ms,
    /// with the smallest median absolute difference after scaling (a cross-correlation that is robust to outliers such as slip).
    ///
    /// `None` with fewer than 50 usable moving samples, or if the speed is too low to compare (0.1 m/s).
    pub(crate) fn of(signal: &Series, reference: &Series, usable: impl Fn(f64) -> bool) -> Option<Self> {
        let mut points: Vec<(f64, f64)> =
            signal.t_s.iter().zip(&signal.value).filter(|(t, v)| v.abs() > 0.1 && usable(**t)).map(|(t, v)| (*t, *v)).collect();
        if points.len() < 50 || reference.len() < 50 {
            return None;
        }
        // 4000 points determine a delay to well below a millisecond
        let stride = points.len().div_ceil(4000);
        points = points.into_iter().step_by(stride).collect();
        let smooth = Series { t_s: reference.t_s.clone(), value: reference.smoothed(0.02) };
        let judge = |delay_s: f64| {
            let mut reference = smooth.cursor();
            let pairs: Vec<(f64, f64)> = points
                .iter()
                .filter_map(|&(t, v)| reference.interpolated(t - delay_s).filter(|r| r.abs() > 0.05).map(|r| (v, r)))
                .collect();
            if pairs.len() < 50 {
                return (f64::INFINITY, 1.0);
            }
            let ratios: Vec<f64> = pairs.iter().map(|(v, r)| v / r).collect();
            let scale = median(&ratios);
            let misses: Vec<f64> = pairs.iter().map(|(v, r)| (v - scale * r).abs()).collect();
            (misses.iter().map(|m| m.min(0.1)).sum::<f64>() / misses.len() as f64, scale)
        };
        let mut best = (f64::INFINITY, Self::SAME);
        let mut try_delay = |delay_s: f64| {
            let (miss, scale) = judge(delay_s);
            if miss < best.0 {
                best = (miss, Self { scale, delay_s });
            }
            best.1.delay_s
        };
        let mut centre = 0.0;
        for k in -30..=30 {
            centre = try_delay(f64::from(k) * DELAY_RANGE_S / 30.0);
        }
        for k in -9..=9 {
            try_delay(centre + f64::from(k) * 1e-3);
        }
        (best.0.is_finite() && SCALES.contains(&best.1.scale)).then_some(best.1)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_known_scale_and_delay_are_found() {
        let speed = |t: f64| 0.5 + 0.4 * (1.7 * t).sin();
        let reference = Series {
            t_s: (0..4000).map(|k| f64::from(k) * 0.01).collect(),
            value: (0..4000).map(|k| speed(f64::from(k) * 0.01)).collect(),
        };
        let signal = Series {
            t_s: (0..2000).map(|k| f64::from(k) * 0.02).collect(),
            value: (0..2000).map(|k| 1.012 * speed(f64::from(k) * 0.02 - 0.009)).collect(),
        };
        let found = Alignment::of(&signal, &reference, |_| true).unwrap();
        assert!((found.delay_s - 0.009).abs() < 0.0011, "{found:?}");
        assert!((found.scale - 1.012).abs() < 0.002, "{found:?}");
    }
}
