//! Where Table 2 is based on measurements.

use crate::map::{CellStatus, Gear, Table2File, TorqueMap};

/// The cells of Table 2 that were measured or lie between measured ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Region {
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
    pub(crate) fn new(table2: &Table2File) -> Self {
        let cells = |map: &TorqueMap| Cells {
            gear: map.gear,
            speed_mps: map.speed_mps.clone(),
            accel_mps2: map.accel_mps2.clone(),
            status: map.status.clone(),
        };
        let at_test_angle = table2.maps.iter().filter(|m| m.angle().is_same(table2.vehicle.test_angle()));
        Self { maps: at_test_angle.map(cells).collect() }
    }

    /// Whether a look-up lies within the axes, and its nearest cell was measured or interpolated.
    pub(crate) fn contains(&self, gear: Gear, speed_mps: f64, accel_mps2: f64) -> bool {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::verify::reference_maps::known_maps;
    use crate::{map::Vehicle, sim};

    fn region(change: impl Fn(&mut TorqueMap)) -> Region {
        let vehicle = Vehicle {
            wheelbase_m: 0.92,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        };
        let (_, mut table2) = known_maps(&sim::WorldSettings::physical(vehicle, sim::PhysicalSettings::default())).unwrap();
        change(&mut table2.maps[0]);
        Region::new(&table2)
    }

    #[test]
    fn the_nearest_cell_decides_and_nothing_beyond_the_axes_is_measured() {
        let region = region(|map| {
            let j = map.accel_mps2.iter().position(|a| a.abs() < 1e-9).unwrap();
            map.status[4][j] = CellStatus::Extrapolated;
            map.status[6][j] = CellStatus::Interpolated;
        });
        let inside = |speed_mps: f64, accel_mps2: f64| region.contains(Gear::Forward, speed_mps, accel_mps2);
        // breaks every 0.05 m/s and 0.1 m/s²: the extrapolated cell is that of 0.2 m/s and 0 m/s²
        for (speed_mps, accel_mps2) in [(0.2, 0.0), (0.224, 0.04), (0.176, -0.04)] {
            assert!(!inside(speed_mps, accel_mps2), "{speed_mps} {accel_mps2}");
        }
        for (speed_mps, accel_mps2) in [(0.226, 0.0), (0.174, 0.0), (0.2, 0.06), (0.3, 0.0)] {
            assert!(inside(speed_mps, accel_mps2), "{speed_mps} {accel_mps2}");
        }
        assert!(!inside(1.01, 0.0) && !inside(-0.01, 0.0) && !inside(0.3, 99.0) && !inside(f64::NAN, 0.0));
    }

    #[test]
    fn a_gear_without_a_map_is_not_measured() {
        assert!(!region(|map| map.gear = Gear::Reverse).contains(Gear::Forward, 0.3, 0.0));
    }
}
