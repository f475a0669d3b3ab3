//! Square root, sine, cosine and arctangent by `libm`, so that the controller gives the same bits on every processor, and whole turns.

use core::f64::consts::{PI, TAU};

/// (sin x, cos x); NaN for NaN and infinities.
pub fn sin_cos(x_rad: f64) -> (f64, f64) {
    libm::sincos(x_rad)
}

/// √x; 0 for x ≤ 0 and for NaN.
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(x.max(0.0))
}

/// `angle_rad` moved into −π…π by whole turns.
pub fn wrapped(angle_rad: f64) -> f64 {
    let turns = (angle_rad / TAU + if angle_rad < 0.0 { -0.5 } else { 0.5 }) as i64;
    (angle_rad - turns as f64 * TAU).clamp(-PI, PI)
}

/// The angle of the point (x, y) [rad], −π…π; 0 for the origin, for NaN and for infinities.
pub fn atan2(y: f64, x: f64) -> f64 {
    if x.is_finite() && y.is_finite() { libm::atan2(y, x) } else { 0.0 }
}

/// arctan x [rad]; 0 for NaN.
pub fn atan(x: f64) -> f64 {
    if x.is_nan() { 0.0 } else { libm::atan(x) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn whole_turns_leave_the_direction(x in -1e4..1e4f64) {
            prop_assert!((wrapped(x).sin() - x.sin()).abs() < 1e-11 && wrapped(x).abs() <= PI);
        }

        #[test]
        fn no_number_panics_and_none_gives_a_root_or_an_angle_that_is_not_one(x in any::<f64>()) {
            let _ = (sin_cos(x), wrapped(x));
            prop_assert!(!sqrt(x).is_nan() && !atan(x).is_nan() && !atan2(x, 1.0).is_nan() && !atan2(1.0, x).is_nan());
        }
    }
}
