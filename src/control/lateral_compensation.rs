//! Lateral error compensation at run time: a small angle added to the tracking law's, so that the mean lateral error goes to zero.
//!
//! Accumulate the lateral error e over a distance or a number of periods. At the threshold take the mean m. Look up the angle whose entry
//! is −m (the entry of an angle is the mean error that it *adds*): exactly if there is such an entry, otherwise on the fitted curve. *Add*
//! it to the compensation in force. Begin again. The sum changes at a limited rate, and nothing is accumulated until the change is complete
//! and the tracking law has settled again: the slow loop never works against the fast one.
//!
//! Nothing is accumulated in a bend or within the settling distance after it: there the error is the tracking law's own.
//!
//! Forward and reverse have separate compensations: an error of the navigation's yaw has the opposite sign in reverse, an error of the
//! steering's zero does not.

use crate::angle::RAD_PER_DEG;
use crate::numeric::sqrt;
use crate::{Error, Gear, Result};

/// Largest number of entries of a table.
pub(crate) const MAX_ENTRIES: usize = 32;

/// One entry or one point of the curve: a compensation angle and the mean lateral error that it adds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CompensationEntry {
    /// Mean lateral error added [m].
    pub error_m: f64,
    /// Angle [rad], left positive.
    pub angle_rad: f64,
}

/// The table for the law: measured entries, and the fitted monotone curve through its points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensationTable {
    entries: [CompensationEntry; MAX_ENTRIES],
    entry_count: usize,
    /// Errors ascending.
    points: [CompensationEntry; MAX_ENTRIES],
    slopes: [f64; MAX_ENTRIES],
    point_count: usize,
}

impl CompensationTable {
    /// A table from entries (any order) and curve points (errors strictly ascending, angles monotone). Slopes of the cubic pieces: Fritsch
    /// & Carlson (1980), *Monotone Piecewise Cubic Interpolation*, SIAM J. Numer. Anal. 17(2).
    ///
    /// # Errors
    /// Fewer than two points, more than 32, a number that is not finite, points that are not ascending or not monotone.
    pub fn new(entries: &[CompensationEntry], points: &[CompensationEntry]) -> Result<Self> {
        let bad = |field, value: f64, allowed| Err(Error::Setting { field, value, allowed });
        if entries.len() > MAX_ENTRIES || points.len() > MAX_ENTRIES || points.len() < 2 {
            return bad("points of the compensation curve", points.len() as f64, "2 to 32");
        }
        if let Some(p) = entries.iter().chain(points).find(|p| !(p.error_m.is_finite() && p.angle_rad.is_finite())) {
            return bad("entry of the compensation table", p.error_m, "finite numbers");
        }
        let chord = |k: usize| (points[k + 1].angle_rad - points[k].angle_rad) / (points[k + 1].error_m - points[k].error_m);
        for k in 0..points.len() - 1 {
            if points[k + 1].error_m <= points[k].error_m {
                return bad("error of the compensation curve", points[k + 1].error_m, "ascending");
            }
            if chord(k) * chord(0) < 0.0 {
                return bad("angle of the compensation curve", points[k + 1].angle_rad, "monotone over the error");
            }
        }
        let mut table = Self {
            entries: [CompensationEntry::default(); MAX_ENTRIES],
            entry_count: entries.len(),
            points: [CompensationEntry::default(); MAX_ENTRIES],
            slopes: [0.0; MAX_ENTRIES],
            point_count: points.len(),
        };
        table.entries[..entries.len()].copy_from_slice(entries);
        table.points[..points.len()].copy_from_slice(points);
        let last = points.len() - 1;
        for k in 0..=last {
            table.slopes[k] = match (k.checked_sub(1).map(chord), (k < last).then(|| chord(k))) {
                (Some(before), Some(after)) if before * after > 0.0 => 0.5 * (before + after),
                (Some(_), Some(_)) | (None, None) => 0.0,
                (Some(only), None) | (None, Some(only)) => only,
            };
        }
        for k in 0..last {
            let d = chord(k);
            if d == 0.0 {
                (table.slopes[k], table.slopes[k + 1]) = (0.0, 0.0);
                continue;
            }
            let (a, b) = (table.slopes[k] / d, table.slopes[k + 1] / d);
            let size = a * a + b * b;
            if size > 9.0 {
                let shrink = 3.0 / sqrt(size);
                (table.slopes[k], table.slopes[k + 1]) = (shrink * a * d, shrink * b * d);
            }
        }
        Ok(table)
    }

    /// The measured entries.
    pub fn entries(&self) -> &[CompensationEntry] {
        &self.entries[..self.entry_count]
    }

    /// The points of the curve, errors ascending.
    pub fn points(&self) -> &[CompensationEntry] {
        &self.points[..self.point_count]
    }

    /// Slope of the monotone cubic at each point [rad/m].
    pub fn slopes(&self) -> &[f64] {
        &self.slopes[..self.point_count]
    }

    /// The angle [rad] whose entry is `error_m`: an entry within `exact_m` of it, otherwise the curve; beyond its ends the angle at the
    /// end.
    pub fn angle_rad(&self, error_m: f64, exact_m: f64) -> f64 {
        let nearest = self.entries[..self.entry_count].iter().fold(None, |best: Option<&CompensationEntry>, entry| match best {
            Some(b) if (b.error_m - error_m).abs() <= (entry.error_m - error_m).abs() => best,
            _ => Some(entry),
        });
        match nearest {
            Some(entry) if (entry.error_m - error_m).abs() <= exact_m => entry.angle_rad,
            _ => self.curve_rad(error_m),
        }
    }

    /// The curve alone; clamped to its ends, 0 for an error of NaN.
    pub fn curve_rad(&self, error_m: f64) -> f64 {
        let (points, last) = (&self.points, self.point_count - 1);
        if error_m.is_nan() {
            return 0.0;
        }
        if error_m <= points[0].error_m {
            return points[0].angle_rad;
        }
        if error_m >= points[last].error_m {
            return points[last].angle_rad;
        }
        let mut k = 0;
        while k + 1 < last && points[k + 1].error_m < error_m {
            k += 1;
        }
        let (p, q) = (points[k], points[k + 1]);
        let h = q.error_m - p.error_m;
        let t = (error_m - p.error_m) / h;
        let (t2, t3) = (t * t, t * t * t);
        p.angle_rad * (2.0 * t3 - 3.0 * t2 + 1.0)
            + h * self.slopes[k] * (t3 - 2.0 * t2 + t)
            + q.angle_rad * (3.0 * t2 - 2.0 * t3)
            + h * self.slopes[k + 1] * (t3 - t2)
    }
}

/// Averaging length of the error.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Accumulation {
    /// A distance travelled [m].
    Distance(f64),
    /// A number of control periods.
    Periods(u32),
}

/// Settings of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CompensationSettings {
    /// Averaging length of the error. Default 5 m.
    pub accumulation: Accumulation,
    /// Largest distance to an entry that is used exactly [m]. Default 0.0005, a quarter of the noise of a good navigation.
    pub exact_m: f64,
    /// Mean errors up to this are ignored [m]. Default 0.001.
    pub dead_zone_m: f64,
    /// Largest compensation in force [rad]. Default 10°.
    pub limit_rad: f64,
    /// Fastest change of the angle added to the wheel angle [rad/s]. Default 0.5 °/s, a hundredth of the steering's rate.
    pub rate_rad_s: f64,
    /// Distance after a change before the accumulation begins again [m]. Default 4: the tracking law has settled.
    pub settle_m: f64,
    /// Above this curvature nothing is accumulated [1/m]: in and after a bend the error is the tracking law's own and
    /// temporary. Default 0.02, a radius of 50 m.
    pub straight_per_m: f64,
    /// An error beyond this is an event, not an offset: the accumulation begins again [m]. Default 0.5.
    pub plausible_m: f64,
    /// Control period [s]. Default 0.02.
    pub period_s: f64,
}

impl Default for CompensationSettings {
    fn default() -> Self {
        Self {
            accumulation: Accumulation::Distance(5.0),
            exact_m: 0.0005,
            dead_zone_m: 0.001,
            limit_rad: 10.0 * RAD_PER_DEG,
            rate_rad_s: 0.5 * RAD_PER_DEG,
            settle_m: 4.0,
            straight_per_m: 0.02,
            plausible_m: 0.5,
            period_s: 0.02,
        }
    }
}

impl CompensationSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// The first out of its range.
    pub fn checked(self) -> Result<Self> {
        let check = |field, value: f64, low: f64, high: f64, allowed| {
            if value >= low && value <= high { Ok(()) } else { Err(Error::Setting { field, value, allowed }) }
        };
        match self.accumulation {
            Accumulation::Distance(distance_m) => check("accumulation distance_m", distance_m, 0.1, 1000.0, "0.1 to 1000")?,
            Accumulation::Periods(count) => check("accumulation periods", f64::from(count), 1.0, 1e6, "1 to 1000000")?,
        }
        check("exact_m", self.exact_m, 0.0, 1.0, "0 to 1")?;
        check("dead_zone_m", self.dead_zone_m, 0.0, 1.0, "0 to 1")?;
        check("limit_rad", self.limit_rad, 0.0, 1.0, "0 to 1")?;
        check("rate_rad_s", self.rate_rad_s, 1e-6, 10.0, "0.000001 to 10")?;
        check("settle_m", self.settle_m, 0.0, 1000.0, "0 to 1000")?;
        check("straight_per_m", self.straight_per_m, 0.0, 10.0, "0 to 10")?;
        check("plausible_m", self.plausible_m, 0.0, 100.0, "0 to 100")?;
        check("period_s", self.period_s, 1e-4, 1.0, "0.0001 to 1").map(|()| self)
    }
}

/// State of one direction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Memory {
    sum: f64,
    weight: f64,
    settled_m: f64,
    in_force_rad: f64,
}

/// The law with its state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LateralCompensation {
    settings: CompensationSettings,
    table: CompensationTable,
    forward: Memory,
    reverse: Memory,
    out_rad: f64,
}

impl LateralCompensation {
    /// A law without compensation so far.
    pub fn new(settings: CompensationSettings, table: CompensationTable) -> Self {
        Self { settings, table, forward: Memory::default(), reverse: Memory::default(), out_rad: 0.0 }
    }

    /// The compensation in force in `gear` [rad], to which the output moves.
    pub fn in_force_rad(&self, gear: Gear) -> f64 {
        if gear == Gear::Forward { self.forward.in_force_rad } else { self.reverse.in_force_rad }
    }

    /// One period. `error_m`: the instantaneous lateral error e; `travelled_m`: distance since the last period, not negative;
    /// `curvature_per_m`: of the path at the matched point; `tracking`: whether the tracking law is active (nothing is accumulated at rest
    /// or in a turn). Returns what to add to the law's wheel angle [rad].
    pub fn step(&mut self, gear: Gear, error_m: f64, travelled_m: f64, curvature_per_m: f64, tracking: bool) -> f64 {
        let settings = &self.settings;
        let memory = if gear == Gear::Forward { &mut self.forward } else { &mut self.reverse };
        let step = settings.rate_rad_s * settings.period_s;
        let arrived = (memory.in_force_rad - self.out_rad).abs() <= step;
        self.out_rad = memory.in_force_rad.max(self.out_rad - step).min(self.out_rad + step);
        let straight = curvature_per_m.abs() <= settings.straight_per_m;
        let sound = straight && error_m.abs() <= settings.plausible_m && travelled_m >= 0.0 && travelled_m.is_finite();
        if !tracking || !sound || !arrived {
            // a stop, a bend, an event or a change in progress: the law must settle again before its error is used
            (memory.sum, memory.weight, memory.settled_m) = (0.0, 0.0, 0.0);
            return self.out_rad;
        }
        if memory.settled_m < settings.settle_m {
            memory.settled_m += travelled_m;
            return self.out_rad;
        }
        let (weight, threshold) = match settings.accumulation {
            Accumulation::Distance(distance_m) => (travelled_m, distance_m),
            Accumulation::Periods(count) => (1.0, f64::from(count)),
        };
        memory.sum += weight * error_m;
        memory.weight += weight;
        if memory.weight >= threshold && memory.weight > 0.0 {
            let mean_m = memory.sum / memory.weight;
            (memory.sum, memory.weight) = (0.0, 0.0);
            if mean_m.abs() > settings.dead_zone_m {
                let added_rad = self.table.angle_rad(-mean_m, settings.exact_m);
                memory.in_force_rad = (memory.in_force_rad + added_rad).max(-settings.limit_rad).min(settings.limit_rad);
                memory.settled_m = 0.0;
            }
        }
        self.out_rad
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn table(slope_rad_per_m: f64) -> CompensationTable {
        let points: Vec<_> = (-3..=3)
            .map(|k| CompensationEntry { error_m: 0.03 * f64::from(k), angle_rad: slope_rad_per_m * 0.03 * f64::from(k) })
            .collect();
        CompensationTable::new(&points, &points).unwrap()
    }

    /// A vehicle whose settled error is its offset plus what the compensation adds: 1 m of error per radian.
    fn drive(offset_m: f64, periods: usize, law: &mut LateralCompensation) -> (f64, Vec<f64>) {
        let mut angles = vec![0.0];
        let mut error_m = offset_m;
        for _ in 0..periods {
            angles.push(law.step(Gear::Forward, error_m, 0.016, 0.0, true));
            error_m = offset_m - angles[angles.len() - 1];
        }
        (error_m, angles)
    }

    #[test]
    fn the_angle_is_added_to_the_one_in_force_and_the_error_stays_zero() {
        let mut law = LateralCompensation::new(CompensationSettings::default(), table(-1.0));
        let (error_m, angles) = drive(0.05, 6000, &mut law);
        assert!(error_m.abs() <= 0.001, "{error_m}");
        // replaced instead of added, the second mean of about zero would have removed the compensation
        assert!(angles[3000..].iter().all(|a| (a - 0.05).abs() < 0.0015));
        let steepest = angles.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        assert!(steepest <= CompensationSettings::default().rate_rad_s * 0.02 + 1e-15);
    }

    #[test]
    fn by_periods_the_mean_is_over_readings_and_by_distance_over_the_way() {
        // 3 readings of 0.02 m over 0.01 m each, 1 of −0.01 m over 0.09 m: the mean of the readings is 0.0125 m, that of the way −0.0025 m
        let mean = |accumulation| {
            let settings =
                CompensationSettings { accumulation, settle_m: 0.0, rate_rad_s: 10.0, exact_m: 0.0, ..CompensationSettings::default() };
            let mut law = LateralCompensation::new(settings.checked().unwrap(), table(-1.0));
            for (error_m, travelled_m) in [(0.02, 0.01), (0.02, 0.01), (0.02, 0.01), (-0.01, 0.090_000_1)] {
                law.step(Gear::Forward, error_m, travelled_m, 0.0, true);
            }
            law.in_force_rad(Gear::Forward)
        };
        // the angle whose entry is −m, on a curve of −1 rad/m
        assert!((mean(Accumulation::Periods(4)) - 0.0125).abs() < 1e-9, "{}", mean(Accumulation::Periods(4)));
        assert!((mean(Accumulation::Distance(0.12)) + 0.0025).abs() < 1e-6, "{}", mean(Accumulation::Distance(0.12)));
        // a fifth period would begin the next mean
        assert_eq!(mean(Accumulation::Periods(5)), 0.0);
        for accumulation in [Accumulation::Periods(0), Accumulation::Distance(0.0), Accumulation::Distance(f64::NAN)] {
            assert!(CompensationSettings { accumulation, ..CompensationSettings::default() }.checked().is_err(), "{accumulation:?}");
        }
    }

    #[test]
    fn by_periods_the_error_goes_to_zero_as_well() {
        let settings = CompensationSettings { accumulation: Accumulation::Periods(300), ..CompensationSettings::default() };
        let mut law = LateralCompensation::new(settings, table(-1.0));
        let (error_m, angles) = drive(0.05, 6000, &mut law);
        assert!(error_m.abs() <= 0.001 && angles[3000..].iter().all(|a| (a - 0.05).abs() < 0.0015), "{error_m}");
    }

    #[test]
    fn the_compensation_is_limited_and_standing_or_an_event_accumulates_nothing() {
        let settings = CompensationSettings { limit_rad: 0.02, ..CompensationSettings::default() };
        let mut law = LateralCompensation::new(settings, table(-1.0));
        drive(0.3, 8000, &mut law);
        assert_eq!(law.in_force_rad(Gear::Forward), 0.02);
        assert_eq!(law.in_force_rad(Gear::Reverse), 0.0);
        let mut law = LateralCompensation::new(settings, table(-1.0));
        for k in 0..5000 {
            // 8.75 m pass, less than settling and accumulating need, then an event: it begins again each time
            law.step(Gear::Forward, if k % 500 == 499 { 0.8 } else { 0.05 }, 0.0175, 0.0, true);
            law.step(Gear::Reverse, 0.05, 0.0175, if k % 300 == 0 { 0.2 } else { 0.0 }, k % 2 == 0);
        }
        assert_eq!((law.in_force_rad(Gear::Forward), law.in_force_rad(Gear::Reverse)), (0.0, 0.0));
    }

    #[test]
    fn an_entry_is_used_exactly_and_the_curve_in_between() {
        let point = |error_m, angle_rad| CompensationEntry { error_m, angle_rad };
        let entries = [point(0.0, 0.0), point(0.02, -0.03)];
        let points = [point(-0.04, 0.05), point(0.0, 0.0), point(0.04, -0.05)];
        let table = CompensationTable::new(&entries, &points).unwrap();
        assert_eq!(table.angle_rad(0.0204, 0.0005), -0.03);
        assert!((table.angle_rad(0.0206, 0.0005) + 0.02575).abs() < 1e-12);
        assert_eq!((table.curve_rad(9.0), table.curve_rad(-9.0), table.curve_rad(f64::NAN)), (-0.05, 0.05, 0.0));
        assert!(CompensationTable::new(&entries, &points[..1]).is_err());
        assert!(CompensationTable::new(&entries, &[points[1], points[0]]).is_err());
    }

    proptest! {
        #[test]
        fn the_curve_is_monotone(steps in prop::collection::vec((0.001..0.1f64, 0.0..0.1f64), 2..20)) {
            let (mut e, mut a) = (0.0, 0.0);
            let points: Vec<_> = steps.iter().map(|(de, da)| { e += de; a -= da; CompensationEntry { error_m: e, angle_rad: a } }).collect();
            let table = CompensationTable::new(&[], &points).unwrap();
            let values: Vec<f64> = (0..=400).map(|k| table.curve_rad(e * f64::from(k) / 400.0)).collect();
            prop_assert!(values.windows(2).all(|w| w[1] <= w[0] + 1e-12));
        }

        #[test]
        fn no_reading_panics(error in any::<f64>(), way in any::<f64>()) {
            let mut law = LateralCompensation::new(CompensationSettings::default(), table(-1.0));
            let out = law.step(Gear::Reverse, error, way, error, true);
            prop_assert!(out.is_finite());
        }
    }
}
