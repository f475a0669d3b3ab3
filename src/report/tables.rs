//! Table 1 and Table 2: heat maps, and surfaces over the same cells.

use crate::map::{AccelMap, FineSurface, TorqueMap};
use crate::report::ReportFiles;
use crate::report::heat::{Heat, Quantity};
use crate::report::scale::Colours;
use crate::report::section::{Figures, Section};
use maud::html;

pub(crate) const SPEED: Quantity = Quantity { name: "front-wheel speed", unit: "m/s", digits: 2 };
pub(crate) const TORQUE: Quantity = Quantity { name: "torque", unit: "N·m", digits: 1 };
pub(crate) const ACCEL: Quantity = Quantity { name: "acceleration", unit: "m/s²", digits: 2 };
pub(crate) const DESIRED: Quantity = Quantity { name: "desired acceleration", unit: "m/s²", digits: 2 };
pub(crate) const ACCEL_ERROR: Quantity = Quantity { name: "standard error", unit: "m/s²", digits: 3 };
const TORQUE_ERROR: Quantity = Quantity { name: "standard error", unit: "N·m", digits: 2 };
pub(crate) const SAMPLES: Quantity = Quantity { name: "samples", unit: "", digits: 0 };
/// Size of a heat map [px].
pub(crate) const SIZE: (f64, f64) = (560.0, 400.0);

/// Torque at which the speed neither rises nor falls, over speed: where the surface crosses zero.
pub(crate) fn holding_torque(surface: &FineSurface) -> Vec<(f64, f64)> {
    let torques = &surface.torque_nm;
    let crossing = |j: usize| {
        let k = (1..torques.len()).rev().find(|k| surface.accel_mps2[k - 1][j] <= 0.0 && surface.accel_mps2[*k][j] > 0.0)?;
        let (low, high) = (surface.accel_mps2[k - 1][j], surface.accel_mps2[k][j]);
        Some(torques[k - 1] + (torques[k] - torques[k - 1]) * -low / (high - low))
    };
    surface.speed_mps.iter().enumerate().filter_map(|(j, v)| Some((*v, crossing(j)?))).collect()
}

/// Table 1 as a section.
pub(crate) fn table1(inputs: &ReportFiles) -> Section {
    let mut figures = Figures::default();
    let body = html! {
        p {
            "What the vehicle does: acceleration of the front wheel at each speed and effective torque, in the gear's frame. On the line the \
             speed neither rises nor falls. Hatched cells lie beyond what was measured; point at a cell for its value, drag the surface to \
             turn it."
        }
        @for map in &inputs.table1.maps {
            div.row { (figures.heat_and_surface(&of_accel(map), &format!("Table 1 as a surface, {} gear", map.gear))) }
        }
    };
    Section { id: "table1", title: "Table 1: acceleration over speed and torque", body, figures }
}

fn of_accel(map: &AccelMap) -> Heat<'_> {
    Heat {
        id: format!("table1-{}", map.gear),
        title: format!("Acceleration, {} gear", map.gear),
        x: (SPEED, &map.speed_mps),
        y: (TORQUE, &map.torque_nm),
        value: (ACCEL, Box::new(move |i, j| Some(map.accel_mps2[j][i]))),
        beside: vec![
            (ACCEL_ERROR, Box::new(move |i, j| Some(map.std_err_mps2[j][i]))),
            (SAMPLES, Box::new(move |i, j| Some(map.count[j][i] as f64))),
        ],
        status: Some(Box::new(move |i, j| map.status[j][i])),
        colours: Colours::Viridis,
        range: None,
        legend: true,
        curve: Some(("a = 0", holding_torque(&map.surface))),
        dot: None,
        size: SIZE,
    }
}

/// Table 2 as a section.
pub(crate) fn table2(inputs: &ReportFiles) -> Section {
    let mut figures = Figures::default();
    let body = html! {
        @if let Some(table2) = &inputs.table2 {
            p {
                "What the controller looks up: the torque that gives the desired acceleration at the present speed. Crossed cells cannot be \
                 reached within the torque limit and hold the nearest torque that can."
            }
            @for map in &table2.maps {
                div.row { (figures.heat_and_surface(&of_torque(map), &format!("Table 2 as a surface, {} gear", map.gear))) }
            }
        } @else {
            p.absent { "There is no Table 2 yet: run pivot-cal invert." }
        }
    };
    Section { id: "table2", title: "Table 2: torque over speed and desired acceleration", body, figures }
}

fn of_torque(map: &TorqueMap) -> Heat<'_> {
    Heat {
        id: format!("table2-{}", map.gear),
        title: format!("Torque, {} gear", map.gear),
        x: (SPEED, &map.speed_mps),
        y: (DESIRED, &map.accel_mps2),
        value: (TORQUE, Box::new(move |i, j| Some(map.torque_nm[i][j]))),
        beside: vec![(TORQUE_ERROR, Box::new(move |i, j| map.std_err_nm[i][j]))],
        status: Some(Box::new(move |i, j| map.status[i][j])),
        colours: Colours::Viridis,
        range: None,
        legend: true,
        curve: None,
        dot: None,
        size: SIZE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_holding_torque_is_where_the_acceleration_crosses_zero() {
        let surface = FineSurface {
            speed_mps: vec![0.0, 0.5, 1.0],
            torque_nm: vec![-10.0, 0.0, 10.0],
            // at 0 m/s zero lies a quarter of the way from 0 to 10 N·m, at 0.5 m/s on a node, at 1 m/s beyond the torques
            accel_mps2: vec![vec![-3.0, -2.0, -4.0], vec![-1.0, 0.0, -3.0], vec![3.0, 2.0, -2.0]],
        };
        assert_eq!(holding_torque(&surface), [(0.0, 2.5), (0.5, 0.0)]);
    }
}
