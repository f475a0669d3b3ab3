//! Where Table 2 rests on measurements.

use crate::map::{CellStatus, Gear, Table2File};

/// The cells of Table 2 that were measured or lie between measured ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Region {
    maps: Vec<(Gear, Vec<f64>, Vec<f64>, Vec<Vec<CellStatus>>)>,
}

impl Region {
    /// From the cells' status in `table2.json`.
    pub fn new(table2: &Table2File) -> Self {
        let maps = table2.maps.iter();
        Self { maps: maps.map(|m| (m.gear, m.speed_mps.clone(), m.accel_mps2.clone(), m.status.clone())).collect() }
    }

    /// Whether a look-up lies within the axes, and its nearest cell was measured or interpolated.
    pub fn contains(&self, gear: Gear, speed_mps: f64, accel_mps2: f64) -> bool {
        let Some((_, speeds, accels, status)) = self.maps.iter().find(|m| m.0 == gear) else { return false };
        let cell = nearest(speeds, speed_mps).zip(nearest(accels, accel_mps2));
        let found = cell.and_then(|(i, j)| status.get(i)?.get(j).copied());
        matches!(found, Some(CellStatus::Measured | CellStatus::Interpolated))
    }
}

/// Index of the nearest break; `None` outside the breaks and for NaN.
fn nearest(breaks: &[f64], x: f64) -> Option<usize> {
    if x.is_nan() || x < *breaks.first()? || x > *breaks.last()? {
        return None;
    }
    let upper = breaks.partition_point(|&b| b < x).min(breaks.len() - 1);
    Some(if upper > 0 && x - breaks[upper - 1] <= breaks[upper] - x { upper - 1 } else { upper })
}
