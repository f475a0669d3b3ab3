//! The lateral compensation to export: its table as the run-time law reads it, and the law's settings.

use crate::control::{Accumulation, CompensationEntry, CompensationSettings, CompensationTable};
use crate::export::constant::Constant;
use crate::map::LateralTableFile;

/// The law to export.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LateralSource {
    /// The `lateral_table.json`.
    pub(crate) file: LateralTableFile,
    /// Settings of the run-time law.
    pub(crate) settings: CompensationSettings,
    /// The table as the law reads it.
    pub(crate) table: CompensationTable,
}

impl LateralSource {
    /// The law of a table with the default settings.
    ///
    /// # Errors
    /// A table that the law cannot read.
    pub(crate) fn new(file: LateralTableFile) -> Result<Self, crate::control::Error> {
        let entry = |error_m: f64, angle_rad: f64| CompensationEntry { error_m, angle_rad };
        let entries: Vec<_> = file.entries.iter().map(|e| entry(e.error_m, e.angle_rad)).collect();
        let points: Vec<_> = file.curve.error_m.iter().zip(&file.curve.angle_rad).map(|(e, a)| entry(*e, *a)).collect();
        let table = CompensationTable::new(&entries, &points)?;
        Ok(Self { file, settings: CompensationSettings::default(), table })
    }

    /// The settings of the law as numbers.
    pub(crate) fn constants(&self) -> Vec<Constant> {
        let s = &self.settings;
        let constant = |name: &str, what: &str, unit, value| Constant {
            name: format!("LATERAL_COMPENSATION_{name}"),
            what: what.to_owned(),
            unit,
            value,
        };
        let (by_periods, threshold, unit) = match s.accumulation {
            Accumulation::Distance(distance_m) => (0.0, distance_m, "m"),
            Accumulation::Periods(count) => (1.0, f64::from(count), "1"),
        };
        vec![
            constant("BY_PERIODS", "Whether the error is averaged over control periods instead of a distance", "1", by_periods),
            constant("THRESHOLD", "Distance or number of periods over which the error is averaged", unit, threshold),
            constant("EXACT", "Largest distance to an entry that is used exactly", "m", s.exact_m),
            constant("DEAD_ZONE", "Mean errors up to this are ignored", "m", s.dead_zone_m),
            constant("LIMIT", "Largest compensation in force", "rad", s.limit_rad),
            constant("RATE", "Fastest change of the added angle", "rad/s", s.rate_rad_s),
            constant("SETTLE", "Distance after a change before the accumulation begins again", "m", s.settle_m),
            constant("STRAIGHT", "Largest curvature at which the error is accumulated", "1/m", s.straight_per_m),
            constant("PLAUSIBLE", "An error beyond this is an event", "m", s.plausible_m),
            constant("PERIOD", "Control period", "s", s.period_s),
        ]
    }

    /// Error [m], angle [rad] and slope [rad/m] of each point of the curve.
    pub(crate) fn points(&self) -> Vec<[f64; 3]> {
        self.table.points().iter().zip(self.table.slopes()).map(|(p, slope)| [p.error_m, p.angle_rad, *slope]).collect()
    }
}
