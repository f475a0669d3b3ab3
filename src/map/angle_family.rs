//! What the maps of one gear at several wheel angles have in common, and what changes with the angle: the `families` of `table1.json` and
//! `table2.json`, and the names of the maps' files.

use crate::map::angle_lookup::AngleTerms;
use crate::map::{Error, Gear, Result};
use serde::{Deserialize, Serialize};

/// Two wheel angles nearer than this are the same one [°].
pub const SAME_ANGLE_DEG: f64 = 1.0;

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

/// Inertia and friction over the wheel angle, of one gear and side: M(δ)·a = H(V, U) − F(V, δ) with M = m₀ + m₁·sin²δ and
/// F = f₀(V) + f₁(V)·sin²δ + f₂(V)·|sin δ|, all at the wheel, in the gear's frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AngleFamily {
    /// Gear.
    pub gear: Gear,
    /// Side.
    pub side: Side,
    /// The wheel angles of its maps [°], by rising magnitude.
    pub wheel_angle_deg: Vec<f64>,
    /// m₀ and m₁ [N·m per m/s²].
    pub inertia: [f64; 2],
    /// Speed breaks of the friction [m/s]: those that every angle covers; beyond them friction is held.
    pub speed_mps: Vec<f64>,
    /// f₀, f₁ and f₂ [N·m] at the speed breaks; f₂ is empty where no angle asks for it.
    pub friction_nm: [Vec<f64>; 3],
    /// Standard deviation [N·m] of what the family does not know half way between two measured angles.
    pub departure_nm: f64,
    /// Where that comes from: `angles left out`, or `assumed` where no angle lies between two others.
    pub departure_from: String,
    /// What the others tell of each angle that lies between two of them.
    pub left_out: Vec<LeftOutAngle>,
}

/// An angle as the others tell it, against its own map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LeftOutAngle {
    /// Wheel angle [°].
    pub wheel_angle_deg: f64,
    /// Root mean square difference over the cells that its runs covered [N·m].
    pub rms_nm: f64,
    /// The same that the standard errors of the maps alone would make [N·m].
    pub expected_nm: f64,
}

impl AngleFamily {
    /// What a look-up needs of it.
    pub fn terms(&self) -> AngleTerms<'_> {
        AngleTerms { inertia: self.inertia, speed_mps: &self.speed_mps, friction_nm: [0, 1, 2].map(|k| self.friction_nm[k].as_slice()) }
    }

    /// Checks that its numbers can be looked up.
    ///
    /// # Errors
    /// Fewer than two speed breaks, breaks that do not rise, terms of another length, numbers that are not finite, or an inertia that is not
    /// positive.
    pub fn check(&self) -> Result<()> {
        crate::map::Axis::new("families.speed_mps", self.speed_mps.clone())?;
        for (row, term) in self.friction_nm.iter().enumerate() {
            if !(term.len() == self.speed_mps.len() || (row > 0 && term.is_empty())) {
                return Err(Error::WrongShape { table: "families.friction_nm", rows: 1, columns: self.speed_mps.len(), found: term.len() });
            }
            if let Some(column) = term.iter().position(|v| !v.is_finite()) {
                return Err(Error::NotFinite { table: "families.friction_nm", row, column, value: term[column] });
            }
        }
        let [straight, turned] = [self.inertia[0], self.inertia[0] + self.inertia[1]];
        if !(straight.is_finite() && turned.is_finite() && straight > 0.0 && turned > 0.0) {
            return Err(Error::BadInertia { m0: self.inertia[0], m1: self.inertia[1] });
        }
        Ok(())
    }
}

/// Name of a map's CSV: `table1.csv` at the test angle, `table1.angle30.csv` elsewhere, with `.reverse` before `.csv` for reverse gear.
pub fn csv_name(table: &str, gear: Gear, wheel_angle_deg: f64, test_angle_deg: f64) -> String {
    let angle = if (wheel_angle_deg - test_angle_deg).abs() < SAME_ANGLE_DEG {
        String::new()
    } else {
        format!(".angle{}", crate::map::decimal(wheel_angle_deg))
    };
    format!("{table}{angle}{}.csv", gear.file_infix())
}

/// Whether `name` is one of those that [`csv_name`] gives for `table`.
pub fn is_csv_name(name: &str, table: &str) -> bool {
    let Some(middle) = name.strip_prefix(table).and_then(|rest| rest.strip_suffix(".csv")) else { return false };
    let middle = middle.strip_suffix(Gear::Reverse.file_infix()).unwrap_or(middle);
    middle.is_empty() || middle.strip_prefix(".angle").is_some_and(|angle| angle.parse::<f64>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_angle_has_the_plain_names_and_others_tell_their_angle() {
        let name = |gear, angle| csv_name("table1", gear, angle, 90.0);
        assert_eq!(name(Gear::Forward, 90.0), "table1.csv");
        assert_eq!(name(Gear::Reverse, 90.0), "table1.reverse.csv");
        assert_eq!(name(Gear::Forward, 30.0), "table1.angle30.csv");
        assert_eq!(name(Gear::Reverse, -22.5), "table1.angle-22.5.reverse.csv");
        for name in ["table1.csv", "table1.reverse.csv", "table1.angle30.csv", "table1.angle-22.5.reverse.csv"] {
            assert!(is_csv_name(name, "table1") && !is_csv_name(name, "table2"), "{name}");
        }
        for name in ["table1.json", "table1.old.csv", "table1.anglex.csv", "my_table1.csv"] {
            assert!(!is_csv_name(name, "table1"), "{name}");
        }
    }

    #[test]
    fn straight_ahead_is_of_both_sides_and_left_is_not_right() {
        assert!(Side::ALL.into_iter().all(|s| s.holds(0.0)));
        assert!(Side::Left.holds(30.0) && !Side::Right.holds(30.0) && Side::Right.holds(-30.0) && !Side::Left.holds(-30.0));
    }
}
