//! The wheel angle of a map: when two are the same, and to which side one belongs.

use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// Two wheel angles nearer than this are the same one [°].
pub(crate) const SAME_ANGLE_DEG: f64 = 1.0;

/// A wheel angle, left positive. Two angles of one map differ by the steering's error, so they are compared with [`WheelAngle::is_same`]
/// and never with `==`.
#[derive(Debug, Clone, Copy)]
pub struct WheelAngle {
    deg: f64,
}

impl WheelAngle {
    /// From degrees, left positive.
    pub const fn from_deg(deg: f64) -> Self {
        Self { deg }
    }

    /// In degrees, left positive.
    pub const fn deg(self) -> f64 {
        self.deg
    }

    /// In radians, left positive.
    pub fn rad(self) -> f64 {
        self.deg * RAD_PER_DEG
    }

    /// Whether both are the same angle: nearer to each other than 1°. Nothing is the same as NaN.
    pub fn is_same(self, other: Self) -> bool {
        self.is_same_deg(other.deg)
    }

    /// The same for an angle in degrees.
    pub fn is_same_deg(self, other_deg: f64) -> bool {
        (self.deg - other_deg).abs() < SAME_ANGLE_DEG
    }

    /// Whether the angles [°] are more than one angle.
    pub fn several(angles_deg: impl IntoIterator<Item = f64>) -> bool {
        let mut angles = angles_deg.into_iter();
        angles.next().is_some_and(|first| angles.any(|angle| !Self::from_deg(first).is_same_deg(angle)))
    }
}

/// Side to which the wheel is turned. Maps of the two sides are never pooled: a vehicle need not be symmetric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Wheel angles from 0 up.
    Left,
    /// Wheel angles from 0 down.
    Right,
}

impl Side {
    /// Both sides.
    pub const ALL: [Self; 2] = [Self::Left, Self::Right];

    /// Whether a wheel angle belongs to this side; straight ahead belongs to both.
    pub fn holds(self, wheel_angle_deg: f64) -> bool {
        let toward = if self == Self::Left { wheel_angle_deg } else { -wheel_angle_deg };
        toward >= -SAME_ANGLE_DEG
    }
}

impl std::fmt::Display for Side {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if *self == Self::Left { "left" } else { "right" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_less_than_a_degree_apart_are_the_same() {
        let thirty = WheelAngle::from_deg(30.0);
        assert!(thirty.is_same_deg(30.9) && thirty.is_same_deg(29.1) && thirty.is_same(thirty));
        assert!(!thirty.is_same_deg(31.0) && !thirty.is_same_deg(29.0) && !thirty.is_same_deg(f64::NAN));
        assert!(!WheelAngle::from_deg(-30.0).is_same(thirty), "left is not right");
    }

    #[test]
    fn several_angles_are_more_than_one_repeated() {
        assert!(!WheelAngle::several([]) && !WheelAngle::several([90.0]) && !WheelAngle::several([90.0, 90.0, 89.5]));
        assert!(WheelAngle::several([90.0, 90.0, 60.0]));
    }

    #[test]
    fn straight_ahead_is_of_both_sides_and_left_is_not_right() {
        assert!(Side::ALL.into_iter().all(|s| s.holds(0.0)));
        assert!(Side::Left.holds(30.0) && !Side::Right.holds(30.0) && Side::Right.holds(-30.0) && !Side::Left.holds(-30.0));
    }
}
