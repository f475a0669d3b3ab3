//! What to drive next: the planned runs, the torques of which least is known, and the cells that are least sure.

use crate::map::{AccelMap, CellStatus};
use crate::report::Inputs;
use crate::report::section::Section;
use crate::report::svg::{escaped, num};

/// Rows shown of each list.
const SHOWN: usize = 8;
/// Planned runs that are shown.
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

/// What to drive next as a section.
pub(crate) fn next(inputs: &Inputs) -> Section {
    let mut section = Section::new("next", "What to drive next");
    planned(&mut section, inputs);
    section.heading("Where doubt is");
    section.paragraph(
        "The torque levels with the most doubt, summed over their cells as 1 − confidence, and how to reach the speeds that are missing. \
         A level far from the torques of a pivot matters less than one within them.",
    );
    let mut levels: Vec<Level> = inputs.table1.maps.iter().flat_map(levels).collect();
    levels.sort_by(|a, b| b.doubt.total_cmp(&a.doubt).then(a.torque_nm.total_cmp(&b.torque_nm)));
    let rows: Vec<Vec<String>> = levels
        .iter()
        .take(SHOWN)
        .map(|l| {
            vec![
                l.gear.clone(),
                num(l.torque_nm, 1),
                format!("{} of {}", l.measured, l.cells),
                num(l.mean_std_err, 3),
                num(l.doubt, 1),
                l.how.clone(),
            ]
        })
        .collect();
    section.table("", &["gear|", "torque N·m", "cells measured", "mean standard error m/s²", "doubt", "how|"], &rows);
    let mut cells: Vec<(f64, &AccelMap, usize, usize)> = Vec::new();
    for map in &inputs.table1.maps {
        for (i, row) in map.status.iter().enumerate() {
            for (j, status) in row.iter().enumerate() {
                if *status != CellStatus::Extrapolated {
                    cells.push((map.std_err_mps2[i][j], map, i, j));
                }
            }
        }
    }
    cells.sort_by(|a, b| b.0.total_cmp(&a.0));
    section.heading("The least sure cells within what was measured");
    let rows: Vec<Vec<String>> = cells
        .iter()
        .take(SHOWN)
        .map(|(error, map, i, j)| {
            vec![
                map.gear.to_string(),
                num(map.speed_mps[*j], 2),
                num(map.torque_nm[*i], 1),
                num(*error, 3),
                map.count[*i][*j].to_string(),
                map.status[*i][*j].to_string(),
            ]
        })
        .collect();
    section.table("narrow", &["gear|", "speed m/s", "torque N·m", "standard error m/s²", "samples", "status|"], &rows);
    section
}

/// The runs that `pivot-cal plan` proposes.
fn planned(section: &mut Section, inputs: &Inputs) {
    let Some(file) = &inputs.plan else {
        section.absent("No runs are planned yet: run pivot-cal plan, and then report again.");
        return;
    };
    let plan = &file.plan;
    section.paragraph(&format!(
        "{} runs in {} min {} s, the most useful first, are expected to take the standard error of the torque from {} to {} N·m (root mean square over \
         the cells, by the plan's own model). Gain: what the first run of a row takes off it.",
        plan.runs,
        (plan.seconds / 60.0).floor(),
        num(plan.seconds % 60.0, 0),
        num(plan.std_err_nm, 3),
        num(plan.std_err_after_nm, 3)
    ));
    let rows: Vec<Vec<String>> = plan
        .entries
        .iter()
        .take(PLANNED)
        .enumerate()
        .map(|(k, run)| {
            vec![
                (k + 1).to_string(),
                run.run.gear.to_string(),
                num(run.run.torque_nm, 1),
                escaped(&run.run.start()),
                run.repeats.to_string(),
                num(run.seconds, 1),
                num(1e3 * run.gain_nm, 2),
                num(run.gain_percent, 2),
                escaped(&run.reason.replace(" -", " −")),
            ]
        })
        .collect();
    let header = ["run", "gear|", "torque N·m", "start|", "times", "each s", "gain mN·m", "gain %", "why|"];
    section.table("", &header, &rows);
    if plan.entries.len() > PLANNED {
        section
            .paragraph(&format!("And {} more: pivot-cal plan -o next.toml writes them all as a campaign.", plan.entries.len() - PLANNED));
    }
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
            _ => "repeat it: every cell is measured, but not surely".to_owned(),
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
