//! Where Table 2 rests on measurements.

use crate::map::{CellStatus, Gear, Table2File, TorqueMap};

/// The cells of Table 2 that were measured or lie between measured ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Region {
    maps: Vec<Cells>,
}

#[derive(Debug, Clone, PartialEq)]
struct Cells {
    gear: Gear,
    speed_mps: Vec<f64>,
    accel_mps2: Vec<f64>,
    status: Vec<Vec<CellStatus>>,
}

impl Region {
    /// From the cells' status in `table2.json`.
    pub fn new(table2: &Table2File) -> Self {
        let cells = |map: &TorqueMap| Cells {
            gear: map.gear,
            speed_mps: map.speed_mps.clone(),
            accel_mps2: map.accel_mps2.clone(),
            status: map.status.clone(),
        };
        Self { maps: table2.maps.iter().map(cells).collect() }
    }

    /// Whether a look-up lies within the axes, and its nearest cell was measured or interpolated.
    pub fn contains(&self, gear: Gear, speed_mps: f64, accel_mps2: f64) -> bool {
        let Some(cells) = self.maps.iter().find(|m| m.gear == gear) else { return false };
        let place = nearest(&cells.speed_mps, speed_mps).zip(nearest(&cells.accel_mps2, accel_mps2));
        let status = place.and_then(|(i, j)| cells.status.get(i)?.get(j));
        matches!(status, Some(CellStatus::Measured | CellStatus::Interpolated))
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
