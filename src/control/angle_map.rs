//! The maps of several wheel angles as the controller reads them: Table 2 of every angle, and what changes between them.
//!
//! Between two measured angles each table is asked for the acceleration that needs, at its own angle, the torque that is wanted here
//! ([`AngleTerms`]), and the two torques are weighted by how near their angles are. At a measured angle the answer is its table's.

use crate::angle::RAD_PER_DEG;
use crate::angle_lookup::{AngleTerms, Between, between};
use crate::numeric::sin_cos;
use crate::{Gear, TableView};

/// Table 2 of a gear at one wheel angle.
#[derive(Debug, Clone, Copy)]
pub struct AngleTable<'a> {
    /// Gear.
    pub gear: Gear,
    /// Wheel angle [rad], left positive.
    pub wheel_angle_rad: f64,
    /// The table.
    pub table: TableView<'a>,
}

/// Inertia and friction of a gear over the wheel angle, to one side.
#[derive(Debug, Clone, Copy)]
pub struct GearTerms<'a> {
    /// Gear.
    pub gear: Gear,
    /// Whether they hold for the wheel turned to the left.
    pub left: bool,
    /// The terms.
    pub terms: AngleTerms<'a>,
}

/// Maps at several wheel angles, borrowed, in any order. Without the terms of a gear and side the tables are mixed as they are.
#[derive(Debug, Clone, Copy)]
pub struct AngleTables<'a> {
    /// The tables.
    pub tables: &'a [AngleTable<'a>],
    /// What changes with the angle.
    pub terms: &'a [GearTerms<'a>],
}

/// A torque, and what it was not measured for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngleLookup {
    /// Torque [N·m], gear frame.
    pub torque_nm: f64,
    /// Whether speed or acceleration lay outside a table that was asked, so that its edge answered.
    pub outside: bool,
    /// Whether the wheel angle lay beyond all measured ones of its side, so that the nearest one answered.
    pub beyond_angles: bool,
    /// Whether the other side answered, since no angle of this one was measured: symmetry is assumed.
    pub mirrored: bool,
}

/// Wheel angles nearer than this are the same one [rad].
const SAME_ANGLE_RAD: f64 = RAD_PER_DEG;

impl AngleTables<'_> {
    /// Torque [N·m] in the gear's frame for a speed [m/s], a desired acceleration [m/s²] and a wheel angle [rad]; `None` outside the measured
    /// angles of the wheel's side, outside a table, without a table of the gear, and for what is not a number.
    pub fn torque(&self, gear: Gear, speed_mps: f64, accel_mps2: f64, wheel_angle_rad: f64) -> Option<f64> {
        let found = self.torque_clamped(gear, speed_mps, accel_mps2, wheel_angle_rad)?;
        (!found.outside && !found.beyond_angles && !found.mirrored).then_some(found.torque_nm)
    }

    /// The same with speed, acceleration and angle held at the edges of what was measured, and the other side's tables where none of this
    /// side's was: the answer tells which. `None` without a table of the gear, and for what is not a number.
    pub fn torque_clamped(&self, gear: Gear, speed_mps: f64, accel_mps2: f64, wheel_angle_rad: f64) -> Option<AngleLookup> {
        let mirrored = self.is_untested(gear, wheel_angle_rad);
        let angle_rad = if mirrored { -wheel_angle_rad } else { wheel_angle_rad };
        let left = angle_rad >= 0.0;
        let of_side = |at: f64| if left { at >= -SAME_ANGLE_RAD } else { at <= SAME_ANGLE_RAD };
        let own = self.tables.iter().enumerate().filter(|(_, t)| t.gear == gear && of_side(t.wheel_angle_rad));
        let place = between(own.map(|(k, t)| (k, t.wheel_angle_rad)), angle_rad, SAME_ANGLE_RAD)?;
        let terms = self.terms.iter().find(|t| t.gear == gear && t.left == left).map(|t| &t.terms).filter(|_| place.below != place.above);
        let (torque_nm, outside) = self.mix(&place, terms, (speed_mps, accel_mps2, angle_rad))?;
        Some(AngleLookup { torque_nm, outside, beyond_angles: place.outside, mirrored })
    }

    /// Whether the wheel is turned to a side that no table of `gear` was measured on, and one was on the other.
    fn is_untested(&self, gear: Gear, angle_rad: f64) -> bool {
        let turned = |at: f64| at * angle_rad > 0.0 && at.abs() > SAME_ANGLE_RAD;
        let any = |side: &dyn Fn(f64) -> bool| self.tables.iter().any(|t| t.gear == gear && side(t.wheel_angle_rad));
        angle_rad.abs() > SAME_ANGLE_RAD && !any(&turned) && any(&|at| turned(-at))
    }

    /// Torque from the two neighbours, and whether a table's edge answered.
    fn mix(&self, place: &Between, terms: Option<&AngleTerms>, (speed_mps, accel_mps2, angle_rad): (f64, f64, f64)) -> Option<(f64, bool)> {
        let here = sin_cos(angle_rad).0;
        let asked = |k: usize| {
            let at = self.tables.get(k)?;
            let accel = terms.map_or(accel_mps2, |t| t.accel_elsewhere_mps2(speed_mps, accel_mps2, here, sin_cos(at.wheel_angle_rad).0));
            match at.table.torque(speed_mps, accel) {
                Some(torque) => Some((torque, false)),
                None => Some((at.table.torque_clamped(speed_mps, accel)?, true)),
            }
        };
        let ((low, low_outside), (high, high_outside)) = (asked(place.below)?, asked(place.above)?);
        // one that was measured there knows better than an edge
        if terms.is_some() && low_outside != high_outside {
            return Some(if low_outside { (high, true) } else { (low, true) });
        }
        Some(((1.0 - place.share) * low + place.share * high, low_outside || high_outside))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    const TERMS: AngleTerms = AngleTerms { inertia: [20.0, -8.0], speed_mps: &[0.0, 1.0], friction_nm: [&[4.0, 9.0], &[2.0, 2.0], &[]] };

    /// What the terms say at an angle, without losses in the drive.
    fn needed(speed_mps: f64, accel_mps2: f64, angle_deg: f64) -> f64 {
        let sin = (angle_deg * RAD_PER_DEG).sin();
        TERMS.inertia(sin) * accel_mps2 + TERMS.friction_nm(speed_mps, sin)
    }

    const SPEED_MPS: [f64; 3] = [0.0, 0.5, 1.0];
    const ACCEL_MPS2: [f64; 3] = [-2.0, 0.0, 2.0];

    fn torques_nm(angle_deg: f64) -> Vec<f64> {
        SPEED_MPS.iter().flat_map(|v| ACCEL_MPS2.map(|a| needed(*v, a, angle_deg))).collect()
    }

    fn with_tables<T>(angles_deg: &[f64], look: impl FnOnce(&AngleTables) -> T) -> T {
        let torques_nm: Vec<Vec<f64>> = angles_deg.iter().map(|a| torques_nm(*a)).collect();
        let tables: Vec<AngleTable> = angles_deg
            .iter()
            .zip(&torques_nm)
            .map(|(angle, torque_nm)| {
                let table = TableView { speed_mps: &SPEED_MPS, accel_mps2: &ACCEL_MPS2, torque_nm };
                AngleTable { gear: Gear::Forward, wheel_angle_rad: angle * RAD_PER_DEG, table }
            })
            .collect();
        let terms = [GearTerms { gear: Gear::Forward, left: true, terms: TERMS }];
        look(&AngleTables { tables: &tables, terms: &terms })
    }

    #[test]
    fn between_two_angles_the_answer_is_what_inertia_and_friction_say() {
        with_tables(&[90.0, 0.0], |maps| {
            for (v, a, angle_deg) in [(0.3, 0.4, 20.0), (0.7, -0.6, 45.0), (0.0, 0.1, 80.0)] {
                let torque = maps.torque(Gear::Forward, v, a, angle_deg * RAD_PER_DEG).unwrap();
                assert!((torque - needed(v, a, angle_deg)).abs() < 1e-9, "{angle_deg}: {torque}");
            }
        });
    }

    #[test]
    fn beyond_the_angles_and_on_the_side_not_tested_only_the_clamped_look_up_answers_and_says_so() {
        with_tables(&[30.0, 60.0], |maps| {
            let at = |angle_deg: f64| (Gear::Forward, 0.3, 0.4, angle_deg * RAD_PER_DEG);
            let (gear, v, a, low) = at(10.0);
            assert_eq!(maps.torque(gear, v, a, low), None);
            let found = maps.torque_clamped(gear, v, a, low).unwrap();
            assert!((found.torque_nm - needed(0.3, 0.4, 30.0)).abs() < 1e-9 && found.beyond_angles && !found.mirrored && !found.outside);
            let right = at(-45.0).3;
            assert_eq!(maps.torque(gear, v, a, right), None);
            let found = maps.torque_clamped(gear, v, a, right).unwrap();
            assert!((found.torque_nm - needed(0.3, 0.4, 45.0)).abs() < 1e-9 && found.mirrored && !found.beyond_angles);
            // within the tolerance of the outermost angle
            assert!(maps.torque(gear, v, a, at(60.5).3).is_some());
            assert!(maps.torque(Gear::Reverse, v, a, at(45.0).3).is_none());
            assert!(maps.torque_clamped(gear, 1.5, a, at(45.0).3).unwrap().outside);
        });
    }

    proptest! {
        #[test]
        fn no_look_up_panics_and_none_gives_what_is_no_number(speed in any::<f64>(), accel in any::<f64>(), angle in any::<f64>()) {
            with_tables(&[0.0, 30.0, 90.0], |maps| {
                for gear in Gear::ALL {
                    let found = maps.torque_clamped(gear, speed, accel, angle);
                    if gear == Gear::Forward && speed.is_finite() && accel.abs() < 1e100 && angle.abs() < 1e3 {
                        prop_assert!(found.is_some_and(|f| f.torque_nm.is_finite()));
                    }
                    prop_assert!(found.is_none_or(|f| !f.torque_nm.is_nan()));
                }
                Ok(())
            })?;
        }
    }
}
