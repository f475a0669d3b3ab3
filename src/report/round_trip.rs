//! Round trip: what acceleration comes out when Table 2's torque is put into Table 1.

use crate::map::{CellStatus, TorqueMap};
use crate::report::Inputs;
use crate::report::heat::{Heat, Quantity};
use crate::report::scale::Colours;
use crate::report::section::Section;
use crate::report::svg::{escaped, num};
use crate::report::tables::{DESIRED, SIZE, SPEED};
use std::fmt::Write as _;

const ERROR: Quantity = Quantity { name: "error", unit: "m/s²", digits: 4 };

/// Middles between breaks.
fn middles(breaks: &[f64]) -> Vec<f64> {
    breaks.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect()
}

/// The least certain status of the four nodes around the middle of a mesh.
fn of_mesh(map: &TorqueMap, i: usize, j: usize) -> CellStatus {
    let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| map.status[i][j]);
    let order = [CellStatus::Unreachable, CellStatus::Extrapolated, CellStatus::Interpolated];
    order.into_iter().find(|s| corners.contains(s)).unwrap_or(CellStatus::Measured)
}

/// The round trip as a section.
pub(crate) fn round_trip(inputs: &Inputs) -> crate::report::Result<Section> {
    let mut section = Section::new("round-trip", "Round trip");
    let Some(table2) = &inputs.table2 else {
        section.absent("There is no Table 2 yet: run pivot-cal invert.");
        return Ok(section);
    };
    section.paragraph(
        "The acceleration that Table 1 gives for Table 2's torque, minus the one that was asked for, in the middle between the nodes, where \
         bilinear interpolation errs most. Meshes with a node beyond what was measured are hatched, those with a node \
         that cannot be reached are left empty.",
    );
    section.open_row();
    for map in &table2.maps {
        let Some(map1) = inputs.table1.maps.iter().find(|m| m.gear == map.gear) else { continue };
        let (forth, back) = (map.table()?, map1.surface.table()?);
        let (speeds, accels) = (middles(&map.speed_mps), middles(&map.accel_mps2));
        let error = |i: usize, j: usize| {
            if of_mesh(map, i, j) == CellStatus::Unreachable {
                return None;
            }
            let torque = forth.torque_from_accel(speeds[i], accels[j])?;
            Some(back.accel_from_torque(speeds[i], torque)? - accels[j])
        };
        section.heat(&Heat {
            id: format!("round-trip-{}", map.gear),
            title: format!("Round-trip error, {} gear", map.gear),
            x: (SPEED, &speeds),
            y: (DESIRED, &accels),
            value: (ERROR, Box::new(error)),
            beside: Vec::new(),
            status: Some(Box::new(move |i, j| match of_mesh(map, i, j) {
                CellStatus::Extrapolated => CellStatus::Extrapolated,
                // left empty, or as good as measured: no mark
                _ => CellStatus::Measured,
            })),
            colours: Colours::Diverging,
            range: None,
            legend: false,
            curve: None,
            dot: None,
            size: SIZE,
        });
    }
    section.close_row();
    let rows: Vec<Vec<String>> = table2
        .maps
        .iter()
        .map(|m| {
            let trip = &m.round_trip;
            let at = &trip.between_max_at;
            vec![
                m.gear.to_string(),
                num(trip.node_rms_mps2, 4),
                num(trip.node_max_mps2, 4),
                num(trip.between_rms_mps2, 4),
                num(trip.between_max_mps2, 4),
                format!("{} m/s, {} m/s²", num(at.speed_mps, 3), num(at.accel_mps2, 2)),
            ]
        })
        .collect();
    section.table("", &["gear|", "nodes, rms m/s²", "nodes, max m/s²", "between, rms m/s²", "between, max m/s²", "the largest at|"], &rows);
    if let Some(verdict) = inputs.verdict.as_ref().filter(|_| inputs.verdict_is_current) {
        let rows: Vec<Vec<String>> = verdict
            .round_trip
            .iter()
            .map(|t| {
                let worst = t.worst.map_or("–".to_owned(), |w| format!("{} of {}", num(w.error_mps2.abs(), 3), num(w.limit_mps2, 3)));
                let judged = if t.pass { "pass" } else { "FAIL" };
                let at = t.wheel_angle_deg.map_or(String::new(), |angle| format!(" at {}°", num(angle, 1)));
                vec![format!("{}{at}", t.gear), t.places.to_string(), t.failed.to_string(), worst, judged.to_owned()]
            })
            .collect();
        section.heading("As the gate judges it, on the CSV itself");
        section.table("narrow", &["gear|", "places", "over their limit", "worst, of its limit m/s²", "verdict|"], &rows);
        let _ = writeln!(section.body, "<p class=\"why\">{}</p>", escaped(&verdict.round_trip_limit.reason));
    }
    Ok(section)
}
