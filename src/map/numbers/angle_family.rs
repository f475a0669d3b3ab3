//! What the maps of one gear at several wheel angles have in common, and what changes with the angle: the `families` of `table1.json` and
//! `table2.json`.

use crate::map::angle_lookup::AngleTerms;
use crate::map::{Error, Gear, Result, Side};
use serde::{Deserialize, Serialize};

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
    /// Where that comes from.
    pub departure_from: DepartureFrom,
    /// What the others say of each angle that lies between two of them.
    pub left_out: Vec<LeftOutAngle>,
}

/// Where the departure of a family comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum DepartureFrom {
    /// Each angle between two others was left out, predicted from the others and compared with its own map.
    #[serde(rename = "angles left out")]
    AnglesLeftOut,
    /// No angle lies between two others, so a share of the friction's change is assumed.
    #[serde(rename = "assumed")]
    Assumed,
}

impl std::fmt::Display for DepartureFrom {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if *self == Self::AnglesLeftOut { "angles left out" } else { "assumed" })
    }
}

/// What the other angles say of one angle, against its own map.
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn family() -> AngleFamily {
        AngleFamily {
            gear: Gear::Forward,
            side: Side::Left,
            wheel_angle_deg: vec![0.0, 90.0],
            inertia: [20.0, -8.0],
            speed_mps: vec![0.0, 1.0],
            friction_nm: [vec![4.0, 9.0], vec![2.0, 2.0], Vec::new()],
            departure_nm: 0.5,
            departure_from: DepartureFrom::Assumed,
            left_out: Vec::new(),
        }
    }

    #[test]
    fn a_family_without_its_third_term_is_sound() {
        family().check().unwrap();
    }

    #[test]
    fn a_term_that_is_too_short_or_no_number_is_refused_with_its_place() {
        let short = AngleFamily { friction_nm: [vec![4.0, 9.0], vec![2.0], Vec::new()], ..family() };
        assert!(matches!(short.check(), Err(Error::WrongShape { columns: 2, found: 1, .. })));
        let missing = AngleFamily { friction_nm: [Vec::new(), vec![2.0, 2.0], Vec::new()], ..family() };
        assert!(matches!(missing.check(), Err(Error::WrongShape { found: 0, .. })), "the constant term cannot be left out");
        let broken = AngleFamily { friction_nm: [vec![4.0, f64::NAN], vec![2.0, 2.0], Vec::new()], ..family() };
        assert!(matches!(broken.check(), Err(Error::NotFinite { row: 0, column: 1, .. })));
    }

    #[test]
    fn an_inertia_that_vanishes_at_90_degrees_is_refused() {
        let family = AngleFamily { inertia: [20.0, -20.0], ..family() };
        assert!(matches!(family.check(), Err(Error::BadInertia { .. })));
    }
}
