//! Square root, sine and cosine with `core` arithmetic alone, so that the controller gives the same bits on every processor.
//!
//! Sine and cosine: reduction to |r| ≤ π/4 by a two-part π/2, then Taylor polynomials to r¹³ and r¹⁴ (truncation below 3e-14).
//! Square root: Newton's iteration from an estimate by halving the exponent. Source: Muller, *Elementary Functions*, 3rd ed., §11.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// What double precision leaves out of π/2.
const FRAC_PI_2_LOW: f64 = 6.123_233_995_736_766e-17;

/// (sin x, cos x), to 1e-13 for |x| below 1e6 rad; NaN for NaN and infinities.
pub(crate) fn sin_cos(x_rad: f64) -> (f64, f64) {
    let quarter = (x_rad * FRAC_2_PI + if x_rad < 0.0 { -0.5 } else { 0.5 }) as i64;
    let k = quarter as f64;
    let r = (x_rad - k * FRAC_PI_2) - k * FRAC_PI_2_LOW;
    let r2 = r * r;
    let sin = r
        * (1.0
            + r2 * (-1.0 / 6.0
                + r2 * (1.0 / 120.0 + r2 * (-1.0 / 5_040.0 + r2 * (1.0 / 362_880.0 + r2 * (-1.0 / 39_916_800.0 + r2 / 6_227_020_800.0))))));
    let cos = 1.0
        + r2 * (-0.5
            + r2 * (1.0 / 24.0
                + r2 * (-1.0 / 720.0
                    + r2 * (1.0 / 40_320.0 + r2 * (-1.0 / 3_628_800.0 + r2 * (1.0 / 479_001_600.0 - r2 / 87_178_291_200.0))))));
    match quarter & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// √x; 0 for x ≤ 0 and for NaN.
pub(crate) fn sqrt(x: f64) -> f64 {
    if !x.is_finite() || x < f64::MIN_POSITIVE {
        return if x == f64::INFINITY { x } else { 0.0 };
    }
    let mut root = f64::from_bits((x.to_bits() >> 1) + (1023 << 51));
    for _ in 0..5 {
        root = 0.5 * (root + x / root);
    }
    root
}

/// `angle_rad` moved into −π…π by whole turns.
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    use core::f64::consts::{PI, TAU};
    let turns = (angle_rad / TAU + if angle_rad < 0.0 { -0.5 } else { 0.5 }) as i64;
    (angle_rad - turns as f64 * TAU).clamp(-PI, PI)
}

/// The angle of the point (x, y) [rad], −π…π; 0 for the origin and for NaN. To 1e-15: a rational start (error below 0.005 rad) and two
/// corrections by tan(a − b) = (tan a − tan b)/(1 + tan a tan b), each with its Taylor series to the third power.
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    use core::f64::consts::{FRAC_PI_2, PI};
    if !(x.is_finite() && y.is_finite()) || (x == 0.0 && y == 0.0) {
        return 0.0;
    }
    let (ax, ay) = (x.abs(), y.abs());
    let t = if ay > ax { ax / ay } else { ay / ax };
    // Source: Rajan et al. (2006), Efficient Approximations for the Arctangent Function, IEEE Signal Processing Magazine 23(3), eq. (9)
    let mut angle = t * (core::f64::consts::FRAC_PI_4 + (1.0 - t) * (0.2447 + 0.0663 * t));
    for _ in 0..2 {
        let (sin, cos) = sin_cos(angle);
        let d = (t * cos - sin) / (cos + t * sin);
        angle += d * (1.0 - d * d / 3.0);
    }
    let first = if ay > ax { FRAC_PI_2 - angle } else { angle };
    let half = if x < 0.0 { PI - first } else { first };
    if y < 0.0 { -half } else { half }
}

/// arctan x [rad].
pub(crate) fn atan(x: f64) -> f64 {
    if x.is_infinite() { core::f64::consts::FRAC_PI_2.copysign(x) } else { atan2(x, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sine_cosine_and_root_are_those_of_the_standard_library(x in -1e4..1e4f64) {
            let (sin, cos) = sin_cos(x);
            // 1e4 rad are 6366 quarter turns: the reduction itself leaves about 1e-12
            prop_assert!((sin - x.sin()).abs() < 1e-11 && (cos - x.cos()).abs() < 1e-11);
            // five Newton steps from a 6 % estimate end at the last bits
            prop_assert!((sqrt(x.abs()) - x.abs().sqrt()).abs() <= 4.0 * f64::EPSILON * x.abs().sqrt());
            prop_assert!((wrapped(x).sin() - x.sin()).abs() < 1e-11 && wrapped(x).abs() <= core::f64::consts::PI);
        }

        #[test]
        fn the_arctangent_is_that_of_the_standard_library(x in -1e3..1e3f64, y in -1e3..1e3f64) {
            prop_assert!((atan2(y, x) - y.atan2(x)).abs() < 1e-13);
            prop_assert!((atan(x) - x.atan()).abs() < 1e-13);
        }

        #[test]
        fn no_number_panics(x in any::<f64>()) {
            let _ = (sin_cos(x), sqrt(x), wrapped(x), atan(x), atan2(x, 1.0), atan2(1.0, x));
        }
    }
}
