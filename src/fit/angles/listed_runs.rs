//! Which runs `table1.json` lists: all of them, or of a large campaign some.

use crate::map::{ListedRuns, RunRow};

/// Most runs that are listed: a row has 600 bytes of text, and 200 logs of a campaign have 27,000 runs.
const MOST_RUNS: usize = 2000;
/// Of these, the runs with the largest residual, which are the ones that are looked at.
const WORST: usize = 500;

/// Numbers of the listed runs, rising: all, or the 500 with the largest residual and evenly spaced ones.
pub(crate) fn listed(rows: &[&RunRow]) -> Vec<usize> {
    let all = rows.len();
    if all <= MOST_RUNS {
        return (0..all).collect();
    }
    let mut order: Vec<usize> = (0..all).collect();
    let size = |k: usize| rows[k].speed_rmse_mps.unwrap_or(-1.0);
    order.sort_by(|a, b| size(*b).total_cmp(&size(*a)).then(a.cmp(b)));
    let (worst, rest) = order.split_at_mut(WORST);
    rest.sort_unstable();
    let places = MOST_RUNS - WORST;
    let mut kept: Vec<usize> = worst.iter().copied().chain((0..places).map(|k| rest[k * rest.len() / places])).collect();
    kept.sort_unstable();
    kept
}

/// The counts of a campaign of which some runs are not listed; `None` if all are.
pub(crate) fn counts(rows: &[&RunRow], listed: usize) -> Option<ListedRuns> {
    let used = || rows.iter().filter(|row| row.used_s > 0.0);
    let used_s = (used().map(|row| row.used_s).sum::<f64>() * 1e3).round() / 1e3;
    (listed < rows.len()).then(|| ListedRuns { listed, all: rows.len(), used: used().count(), used_s })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Gear, Table1File};

    fn rows(count: usize) -> Vec<RunRow> {
        let file = Table1File::from_json(include_str!("../../../maps/table1.json")).ok();
        let row = file.and_then(|file| file.report.runs.into_iter().find(|run| run.used_s > 0.0));
        let row =
            |k: usize| row.clone().map(|row| RunRow { speed_rmse_mps: Some((k % 997) as f64), gear: Gear::Forward, used_s: 0.5, ..row });
        (0..count).filter_map(row).collect()
    }

    #[test]
    fn a_campaign_of_any_size_lists_at_most_2000_runs_with_the_worst_among_them() {
        let all = rows(27_000);
        let refs: Vec<&RunRow> = all.iter().collect();
        let kept = listed(&refs);
        assert_eq!(kept.len(), MOST_RUNS);
        assert!(kept.is_sorted_by(|a, b| a < b));
        assert!((0..27_000).filter(|k| all[*k].speed_rmse_mps == Some(996.0)).all(|k| kept.contains(&k)));
        assert!(kept.windows(2).all(|pair| pair[1] - pair[0] < 100), "no stretch of the campaign is left out");
        assert_eq!(counts(&refs, kept.len()), Some(ListedRuns { listed: 2000, all: 27_000, used: 27_000, used_s: 13_500.0 }));
    }

    #[test]
    fn a_small_campaign_lists_all_runs_and_no_counts() {
        let all = rows(2000);
        let refs: Vec<&RunRow> = all.iter().collect();
        assert_eq!((listed(&refs).len(), counts(&refs, 2000)), (2000, None));
    }
}
