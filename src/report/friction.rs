//! Breakaway and friction: the torque that sets the wheel in motion, and the torque that keeps it there.

use crate::map::{AccelMap, Gear};
use crate::report::ReportFiles;
use crate::report::chart::{Chart, Line, Panel};
use crate::report::html::{
    TableColumn::{Number, Text},
    num_or_dash, table,
};
use crate::report::section::{Figures, Section};
use crate::report::svg::num;
use crate::report::tables::holding_torque;
use maud::html;

/// The friction is given as a number at the highest node up to this speed [m/s].
const CRUISE_MPS: f64 = 0.6;

/// Breakaway and friction as a section.
pub(crate) fn friction(inputs: &ReportFiles) -> Section {
    let mut figures = Figures::default();
    let columns = [
        Text("gear"),
        Number("breakaway N·m"),
        Number("± N·m"),
        Number("at rest up to N·m"),
        Number("moved from N·m"),
        Number("friction N·m"),
    ];
    let rows: Vec<Vec<String>> = inputs.table1.maps.iter().map(row).collect();
    let body = html! {
        p {
            "The torque at which the speed neither rises nor falls: friction, over speed. At standstill it meets the breakaway torque, which \
             lies between the largest torque that left the wheel at rest and the smallest that moved it."
        }
        (figures.chart(&chart(&inputs.table1.maps)))
        (table("narrow", &columns, &rows))
    };
    Section { id: "friction", title: "Breakaway and friction", body, figures }
}

fn chart(maps: &[AccelMap]) -> Chart {
    let mut panel = Panel { title: "torque that holds the speed [N·m]".to_owned(), with_zero: true, ..Panel::default() };
    for map in maps {
        let b = &map.breakaway;
        let (name, line, dot) = match map.gear {
            Gear::Forward => ("forward gear", "a", "af"),
            Gear::Reverse => ("reverse gear", "b d", "bf"),
        };
        panel.lines.push(Line { name, class: line, points: holding_torque(&map.surface) });
        if let (Some(low), Some(high)) = (b.at_rest_up_to_nm, b.moved_from_nm) {
            panel.lines.push(Line { name: "", class: line, points: vec![(0.0, low), (0.0, high)] });
        }
        panel.dots.push((0.0, b.torque_nm, dot, 4.0));
    }
    Chart {
        id: "friction".to_owned(),
        label: "Torque that holds the speed, over speed".to_owned(),
        x_title: "front-wheel speed [m/s]",
        width: 760.0,
        panel: 220.0,
        panels: vec![panel],
    }
}

fn row(map: &AccelMap) -> Vec<String> {
    let b = &map.breakaway;
    let cruise = holding_torque(&map.surface).into_iter().rfind(|p| p.0 <= CRUISE_MPS + 1e-9);
    vec![
        map.gear.to_string(),
        num(b.torque_nm, 2),
        num_or_dash(b.std_err_nm, 2),
        num_or_dash(b.at_rest_up_to_nm, 1),
        num_or_dash(b.moved_from_nm, 1),
        cruise.map_or("–".to_owned(), |p| format!("{} at {} m/s", num(p.1, 2), num(p.0, 2))),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::known::known;

    #[test]
    fn the_friction_is_given_at_the_highest_node_up_to_the_cruising_speed() {
        let mut map = known().0.maps.remove(0);
        let found = row(&map)[5].clone();
        let speed = map.surface.speed_mps.iter().copied().filter(|v| *v <= CRUISE_MPS + 1e-9).fold(0.0, f64::max);
        assert!(found.ends_with(&format!(" at {} m/s", num(speed, 2))), "{found}");
        // all torques drive: none holds the speed
        map.surface.accel_mps2.iter_mut().flatten().for_each(|a| *a = 1.0);
        assert_eq!(row(&map)[5], "–");
    }
}
