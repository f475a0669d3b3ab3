//! Breakaway and friction: the torque that sets the wheel in motion, and the torque that keeps it there.

use crate::map::Gear;
use crate::report::Inputs;
use crate::report::chart::{Chart, Line, Panel};
use crate::report::section::Section;
use crate::report::svg::num;
use crate::report::tables::holding_torque;

/// Breakaway and friction as a section.
pub(crate) fn friction(inputs: &Inputs) -> Section {
    let mut section = Section::new("friction", "Breakaway and friction");
    section.paragraph(
        "The torque at which the speed neither rises nor falls: friction, over speed. At standstill it meets the breakaway torque, which lies \
         between the largest torque that left the wheel at rest and the smallest that moved it.",
    );
    let mut panel = Panel { title: "torque that holds the speed [N·m]".to_owned(), with_zero: true, ..Panel::default() };
    let mut rows = Vec::new();
    for map in &inputs.table1.maps {
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
        let told = |v: Option<f64>, digits| v.map_or("–".to_owned(), |v| num(v, digits));
        let cruise = holding_torque(&map.surface).into_iter().rfind(|p| p.0 <= 0.6 + 1e-9);
        rows.push(vec![
            map.gear.to_string(),
            num(b.torque_nm, 2),
            told(b.std_err_nm, 2),
            told(b.at_rest_up_to_nm, 1),
            told(b.moved_from_nm, 1),
            cruise.map_or("–".to_owned(), |p| format!("{} at {} m/s", num(p.1, 2), num(p.0, 2))),
        ]);
    }
    section.chart(&Chart {
        id: "friction".to_owned(),
        label: "Torque that holds the speed, over speed".to_owned(),
        x_title: "front-wheel speed [m/s]",
        width: 760.0,
        panel: 220.0,
        panels: vec![panel],
    });
    section.table("narrow", &["gear|", "breakaway N·m", "± N·m", "at rest up to N·m", "moved from N·m", "friction N·m"], &rows);
    section
}
