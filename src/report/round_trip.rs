//! Round trip: what acceleration comes out when Table 2's torque is put into Table 1.

use crate::map::{AccelMap, CellStatus, TorqueMap};
use crate::report::ReportFiles;
use crate::report::heat::{Heat, Quantity};
use crate::report::html::{
    TableColumn::{Number, Text},
    table,
};
use crate::report::scale::Colours;
use crate::report::section::{Figures, Section};
use crate::report::svg::num;
use crate::report::tables::{DESIRED, SIZE, SPEED};
use crate::verify::MapVerdict;
use maud::{Markup, html};

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
pub(crate) fn round_trip(inputs: &ReportFiles) -> super::Result<Section> {
    let mut figures = Figures::default();
    let map1_of = |map: &TorqueMap| inputs.table1.maps.iter().find(|m| m.gear == map.gear);
    let body = html! {
        @if let Some(table2) = &inputs.table2 {
            p {
                "The acceleration that Table 1 gives for Table 2's torque, minus the one that was asked for, in the middle between the nodes, \
                 where bilinear interpolation errs most. Meshes with a node beyond what was measured are hatched, those with a node that \
                 cannot be reached are left empty."
            }
            div.row {
                @for map in &table2.maps {
                    @if let Some(map1) = map1_of(map) { (error(&mut figures, map, map1)?) }
                }
            }
            (largest(&table2.maps))
            @if let Some(verdict) = inputs.verdict.as_ref().filter(|_| inputs.verdict_is_current) {
                h3 { "As the gate judges it, on the CSV itself" }
                (judged(verdict))
                p.why { (verdict.round_trip_limit.reason) }
            }
        } @else {
            p.absent { "There is no Table 2 yet: run pivot-cal invert." }
        }
    };
    Ok(Section { id: "round-trip", title: "Round trip", body, figures })
}

/// The error in the middle of every mesh.
fn error(figures: &mut Figures, map: &TorqueMap, map1: &AccelMap) -> super::Result<Markup> {
    let (forth, back) = (map.table()?, map1.surface.table()?);
    let (speeds, accels) = (middles(&map.speed_mps), middles(&map.accel_mps2));
    let error = |i: usize, j: usize| {
        if of_mesh(map, i, j) == CellStatus::Unreachable {
            return None;
        }
        let torque = forth.torque_from_accel(speeds[i], accels[j])?;
        Some(back.accel_from_torque(speeds[i], torque)? - accels[j])
    };
    Ok(figures.heat(&Heat {
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
    }))
}

/// The errors that `invert` found.
fn largest(maps: &[TorqueMap]) -> Markup {
    let columns = [
        Text("gear"),
        Number("nodes, rms m/s²"),
        Number("nodes, max m/s²"),
        Number("between, rms m/s²"),
        Number("between, max m/s²"),
        Text("the largest at"),
    ];
    let row = |m: &TorqueMap| {
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
    };
    table("", &columns, &maps.iter().map(row).collect::<Vec<_>>())
}

/// The errors that `verify` found, beside their limit.
fn judged(verdict: &MapVerdict) -> Markup {
    let columns = [Text("gear"), Number("places"), Number("over their limit"), Number("worst, of its limit m/s²"), Text("verdict")];
    let rows: Vec<Vec<String>> = verdict
        .round_trip
        .iter()
        .map(|t| {
            let worst = t.worst.map_or("–".to_owned(), |w| format!("{} of {}", num(w.error_mps2.abs(), 3), num(w.limit_mps2, 3)));
            let at = t.wheel_angle_deg.map_or(String::new(), |angle| format!(" at {}°", num(angle, 1)));
            let judged = if t.pass { "pass" } else { "FAIL" };
            vec![format!("{}{at}", t.gear), t.places.to_string(), t.failed.to_string(), worst, judged.to_owned()]
        })
        .collect();
    table("narrow", &columns, &rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::known::known;

    #[test]
    fn a_mesh_is_as_certain_as_the_least_certain_of_its_nodes() {
        let mut map = known().1.maps.remove(0);
        map.status.iter_mut().for_each(|row| row.fill(CellStatus::Measured));
        map.status[2][2] = CellStatus::Interpolated;
        map.status[3][3] = CellStatus::Extrapolated;
        map.status[4][3] = CellStatus::Unreachable;
        assert_eq!(of_mesh(&map, 0, 0), CellStatus::Measured);
        assert_eq!(of_mesh(&map, 1, 1), CellStatus::Interpolated);
        assert_eq!(of_mesh(&map, 2, 2), CellStatus::Extrapolated);
        assert_eq!(of_mesh(&map, 3, 2), CellStatus::Unreachable);
        assert_eq!(middles(&[0.0, 1.0, 3.0]), [0.5, 2.0]);
    }
}
