//! Runs to drive next: the planned runs, and the torques and cells with the largest standard errors.

use crate::map::{AccelMap, CellStatus, PlanEntry, Proposal};
use crate::report::ReportFiles;
use crate::report::html::{
    TableColumn::{Number, Text},
    table,
};
use crate::report::section::{Figures, Section};
use crate::report::svg::num;
use maud::{Markup, html};

/// Number of rows shown of each list.
const SHOWN: usize = 8;
/// Number of planned runs that are shown.
const PLANNED: usize = 12;

/// One torque level of a gear.
struct Level {
    gear: String,
    torque_nm: f64,
    measured: usize,
    cells: usize,
    mean_std_err: f64,
    /// Sum over the cells of 1 − confidence.
    doubt: f64,
    how: String,
}

/// The next runs as a section.
pub(crate) fn next(inputs: &ReportFiles) -> Section {
    let body = html! {
        @if let Some(file) = &inputs.plan {
            (planned(&file.plan))
        } @else {
            p.absent { "No runs are planned yet: run pivot-cal plan, and then report again." }
        }
        h3 { "Torques with the least confidence" }
        p {
            "The torque levels with the least confidence (the sum of 1 − confidence over their cells), and how to reach the missing \
             speeds. A level far from the torques of a pivot matters less than one within them."
        }
        (doubtful_levels(&inputs.table1.maps))
        h3 { "The most uncertain cells within the measured region" }
        (doubtful_cells(&inputs.table1.maps))
    };
    Section { id: "next", title: "What to drive next", body, figures: Figures::default() }
}

/// The runs that `pivot-cal plan` proposes.
fn planned(plan: &Proposal) -> Markup {
    let columns = [
        Number("run"),
        Text("gear"),
        Number("torque N·m"),
        Text("start"),
        Number("times"),
        Number("each s"),
        Number("gain mN·m"),
        Number("gain %"),
        Text("why"),
    ];
    let row = |(k, entry): (usize, &PlanEntry)| {
        let run = &entry.run;
        vec![
            (k + 1).to_string(),
            run.gear.to_string(),
            num(run.torque_nm, 1),
            run.start(),
            entry.repeats.to_string(),
            num(entry.seconds, 1),
            num(1e3 * entry.gain_nm, 2),
            num(entry.gain_percent, 2),
            entry.reason.replace(" -", " −"),
        ]
    };
    let rows: Vec<Vec<String>> = plan.entries.iter().take(PLANNED).enumerate().map(row).collect();
    html! {
        p {
            (plan.runs) " runs in " ((plan.seconds / 60.0).floor()) " min " (num(plan.seconds % 60.0, 0)) " s, the most useful first, \
             are expected to reduce the standard error of the torque from " (num(plan.std_err_nm, 3)) " to " (num(plan.std_err_after_nm, 3)) " N·m \
             (root mean square over the cells, by the plan's own model). Gain: the reduction by the first run of a row."
        }
        (table("", &columns, &rows))
        @if plan.entries.len() > PLANNED {
            p { "And " (plan.entries.len() - PLANNED) " more: pivot-cal plan -o next.toml writes them all as a campaign." }
        }
    }
}

/// The torques whose cells have the least confidence in total.
fn doubtful_levels(maps: &[AccelMap]) -> Markup {
    let columns =
        [Text("gear"), Number("torque N·m"), Number("cells measured"), Number("mean standard error m/s²"), Number("doubt"), Text("how")];
    let mut levels: Vec<Level> = maps.iter().flat_map(levels).collect();
    levels.sort_by(|a, b| b.doubt.total_cmp(&a.doubt).then(a.torque_nm.total_cmp(&b.torque_nm)));
    levels.truncate(SHOWN);
    let row = |l: Level| {
        let measured = format!("{} of {}", l.measured, l.cells);
        vec![l.gear, num(l.torque_nm, 1), measured, num(l.mean_std_err, 3), num(l.doubt, 1), l.how]
    };
    table("", &columns, &levels.into_iter().map(row).collect::<Vec<_>>())
}

/// The cells with the largest standard errors, of those that are not extrapolated.
fn doubtful_cells(maps: &[AccelMap]) -> Markup {
    let columns =
        [Text("gear"), Number("speed m/s"), Number("torque N·m"), Number("standard error m/s²"), Number("samples"), Text("status")];
    let mut cells: Vec<(f64, &AccelMap, usize, usize)> = Vec::new();
    for map in maps {
        for (i, row) in map.status.iter().enumerate() {
            for (j, status) in row.iter().enumerate() {
                if *status != CellStatus::Extrapolated {
                    cells.push((map.std_err_mps2[i][j], map, i, j));
                }
            }
        }
    }
    cells.sort_by(|a, b| b.0.total_cmp(&a.0));
    cells.truncate(SHOWN);
    let row = |(error, map, i, j): (f64, &AccelMap, usize, usize)| {
        vec![
            map.gear.to_string(),
            num(map.speed_mps[j], 2),
            num(map.torque_nm[i], 1),
            num(error, 3),
            map.count[i][j].to_string(),
            map.status[i][j].to_string(),
        ]
    };
    table("narrow", &columns, &cells.into_iter().map(row).collect::<Vec<_>>())
}

fn levels(map: &AccelMap) -> Vec<Level> {
    let level = |i: usize| {
        let torque_nm = map.torque_nm[i];
        let cells = map.speed_mps.len();
        let missing: Vec<f64> = (0..cells).filter(|j| map.status[i][*j] != CellStatus::Measured).map(|j| map.speed_mps[j]).collect();
        let how = match (missing.first(), missing.last()) {
            (Some(first), Some(last)) if torque_nm > map.breakaway.torque_nm => {
                if *first < 0.1 {
                    format!("hold it from rest and let it run past {} m/s", num(*last, 2))
                } else {
                    format!("hold it from {} m/s on, up to {} m/s", num(*first, 2), num(*last, 2))
                }
            }
            (Some(first), Some(last)) => format!("spin up to {} m/s, then hold it down to {} m/s", num(*last, 2), num(*first, 2)),
            _ => "repeat it: every cell is measured, but uncertain".to_owned(),
        };
        Level {
            gear: map.gear.to_string(),
            torque_nm,
            measured: cells - missing.len(),
            cells,
            mean_std_err: map.std_err_mps2[i].iter().sum::<f64>() / cells as f64,
            doubt: map.confidence[i].iter().map(|c| 1.0 - c).sum(),
            how,
        }
    };
    (0..map.torque_nm.len()).map(level).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::report::known::known;

    /// Everything is measured except one level above the breakaway torque and one below it.
    fn map_with_gaps() -> (AccelMap, usize, usize) {
        let mut map = known().0.maps.remove(0);
        let (low, high) = (0, map.torque_nm.len() - 1);
        for i in [low, high] {
            map.status[i].fill(CellStatus::Interpolated);
            map.confidence[i].fill(0.25);
        }
        (map, low, high)
    }

    #[test]
    fn a_level_without_measurements_is_reached_from_rest_or_by_a_spin_up() {
        let (map, low, high) = map_with_gaps();
        let (all, cells) = (levels(&map), map.speed_mps.len());
        assert!(all[high].how.starts_with("hold it from rest"), "{}", all[high].how);
        assert!(all[low].how.starts_with("spin up to"), "{}", all[low].how);
        assert_eq!((all[high].measured, all[high].cells), (0, cells));
        assert!((all[high].doubt - 0.75 * cells as f64).abs() < 1e-9);
        assert!(all[1].how.starts_with("repeat it") && all[1].measured == cells);
    }

    #[test]
    fn the_most_uncertain_cell_comes_first_and_an_extrapolated_one_never() {
        let (mut map, low, high) = map_with_gaps();
        map.std_err_mps2[high][1] = 8.125;
        map.std_err_mps2[low][2] = 9.125;
        map.status[low][2] = CellStatus::Extrapolated;
        let found = doubtful_cells(&[map]).into_string();
        assert!(!found.contains("9.125"), "{found}");
        let first = found.split("<tbody><tr>").nth(1).unwrap().split("</tr>").next().unwrap();
        assert!(first.contains("<td>8.125</td>") && first.ends_with(">interpolated</td>"), "{first}");
    }
}
