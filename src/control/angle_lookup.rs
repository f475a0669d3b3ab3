//! What changes with the wheel angle, as a controller reads it: no allocation, no panic, no transcendental function.
//!
//! A vehicle with inertia M(δ) [N·m per m/s²] and friction F(V, δ) [N·m], both at the wheel, answers a torque U, of which the drive makes the
//! driving torque H(V, U), with M(δ)·a = H(V, U) − F(V, δ). With
//!
//! M(δ) = m₀ + m₁·sin²δ, F(V, δ) = f₀(V) + f₁(V)·sin²δ + f₂(V)·|sin δ|,
//!
//! a table of the angle δ' answers for δ, too, when it is asked for the acceleration a' that needs the same torque there:
//! M(δ')·a' + F(V, δ') = M(δ)·a + F(V, δ). H never has to be known. The inertia is exact for a rigid vehicle (its reference point moves with
//! v·cos δ and turns with v·sin δ/L); the friction is what torque steps at several angles show.
//!
//! This file uses `core` only and can be carried to a microcontroller as it is.

use crate::lookup::bracket;

/// Inertia and friction over the wheel angle, borrowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngleTerms<'a> {
    /// m₀ and m₁ [N·m per m/s²].
    pub inertia: [f64; 2],
    /// Speed breaks [m/s] of the friction; beyond them it is held.
    pub speed_mps: &'a [f64],
    /// f₀, f₁ and f₂ [N·m] at the speed breaks; an empty one is zero.
    pub friction_nm: [&'a [f64]; 3],
}

impl AngleTerms<'_> {
    /// M(δ) [N·m per m/s²], by sin δ.
    pub fn inertia(&self, sin: f64) -> f64 {
        self.inertia[0] + self.inertia[1] * sin * sin
    }

    /// F(V, δ) [N·m], by sin δ; 0 without breaks, and for a speed that is not a number.
    pub fn friction_nm(&self, speed_mps: f64, sin: f64) -> f64 {
        let Some((i, share)) = bracket(self.speed_mps, speed_mps) else { return 0.0 };
        let at = |term: &[f64]| match (term.get(i), term.get(i + 1)) {
            (Some(low), Some(high)) => (1.0 - share) * low + share * high,
            _ => 0.0,
        };
        let [constant, square, linear] = self.friction_nm;
        at(constant) + at(square) * sin * sin + at(linear) * sin.abs()
    }

    /// The acceleration [m/s²] that needs at the angle with sine `there` the torque that `accel_mps2` needs at the angle with sine `here`.
    pub fn accel_elsewhere_mps2(&self, speed_mps: f64, accel_mps2: f64, here: f64, there: f64) -> f64 {
        let needed = self.inertia(here) * accel_mps2 + self.friction_nm(speed_mps, here);
        (needed - self.friction_nm(speed_mps, there)) / self.inertia(there)
    }
}

/// Where an angle lies among others: between two of them, `share` of the way from the first to the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Between {
    /// Number of the angle below, or of the nearest one.
    pub below: usize,
    /// Number of the angle above, or of the nearest one.
    pub above: usize,
    /// 0 at the lower, 1 at the upper.
    pub share: f64,
    /// Whether the angle lies outside of all, so that the nearest is meant.
    pub outside: bool,
}

/// Places `angle` among `angles`, which come in any order, each with its number. Beyond all of them by no more than `tolerance` is not yet
/// outside. `None` without angles, and for what is not a number.
pub fn between(angles: impl Iterator<Item = (usize, f64)>, angle: f64, tolerance: f64) -> Option<Between> {
    if angle.is_nan() {
        return None;
    }
    let mut below: Option<(usize, f64)> = None;
    let mut above: Option<(usize, f64)> = None;
    for (number, at) in angles {
        if at <= angle && below.is_none_or(|(_, b)| at > b) {
            below = Some((number, at));
        }
        if at >= angle && above.is_none_or(|(_, a)| at < a) {
            above = Some((number, at));
        }
    }
    match (below, above) {
        (Some((below, low)), Some((above, high))) => {
            let share = if high > low { (angle - low) / (high - low) } else { 0.0 };
            Some(Between { below, above, share, outside: false })
        }
        (Some((nearest, at)), None) | (None, Some((nearest, at))) => {
            Some(Between { below: nearest, above: nearest, share: 0.0, outside: (angle - at).abs() > tolerance })
        }
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const TERMS: AngleTerms = AngleTerms { inertia: [20.0, -8.0], speed_mps: &[0.0, 1.0], friction_nm: [&[4.0, 9.0], &[2.0, 2.0], &[]] };

    #[test]
    fn a_table_elsewhere_is_asked_for_the_acceleration_of_the_same_torque() {
        let (here, there) = (0.5, 1.0);
        let a = TERMS.accel_elsewhere_mps2(0.5, 0.4, here, there);
        let torque = |a: f64, sin: f64| TERMS.inertia(sin) * a + TERMS.friction_nm(0.5, sin);
        assert!((torque(0.4, here) - torque(a, there)).abs() < 1e-12);
        assert!((torque(0.4, here) - (18.0 * 0.4 + 6.5 + 0.5)).abs() < 1e-12);
        assert!((TERMS.accel_elsewhere_mps2(0.5, 0.4, here, here) - 0.4).abs() < 1e-12);
    }

    #[test]
    fn an_angle_lies_between_its_neighbours_or_outside_of_all() {
        let angles = [90.0, 0.0, 30.0];
        let place = |angle: f64| between(angles.into_iter().enumerate(), angle, 0.5).unwrap();
        assert_eq!(place(45.0), Between { below: 2, above: 0, share: 0.25, outside: false });
        assert_eq!(place(30.0), Between { below: 2, above: 2, share: 0.0, outside: false });
        assert_eq!(place(90.4), Between { below: 0, above: 0, share: 0.0, outside: false });
        assert_eq!(place(-5.0), Between { below: 1, above: 1, share: 0.0, outside: true });
        assert!(between(angles.into_iter().enumerate(), f64::NAN, 0.5).is_none());
        assert!(between(std::iter::empty(), 1.0, 0.5).is_none());
    }
}
