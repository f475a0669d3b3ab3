//! Whether a verdict allows its map to be deployed: it belongs to the tables, every pivot was judged, and it passes.

use crate::check::campaign_checks::all_checks;
use crate::map::Table1File;
use crate::verify::conclusion::standing;
use crate::verify::scenario::Scenario;
use crate::verify::verdict::{MapVerdict, Status};

impl MapVerdict {
    /// Whether the verdict is about the tables of `generation` whose CSV files have these hashes.
    pub(crate) fn is_about(&self, generation: &str, csv_sha256: &[String]) -> bool {
        let judged = &self.table2_csv_sha256;
        self.generation == generation && !judged.is_empty() && judged.iter().all(|sha256| csv_sha256.contains(sha256))
    }

    /// Number of pivots that the verdict lacks: a verdict on chosen scenarios alone does not judge a map.
    pub(crate) fn pivots_left_out(&self) -> usize {
        Scenario::all().iter().filter(|pivot| self.scenarios.iter().all(|judged| judged.name != pivot.name)).count()
    }
}

/// Whether the map with this Table 1 may be deployed, and the reason as one line. `current` is the verdict on its tables; without one, an
/// objection of Table 1 counts all the same.
pub(crate) fn deployment(table1: &Table1File, current: Option<&MapVerdict>) -> (Status, String) {
    let accepted = current.map_or(&[][..], |verdict| &verdict.accepted);
    match current {
        Some(verdict) if !verdict.passes() => (verdict.status, verdict.headline()),
        Some(verdict) if verdict.pivots_left_out() == 0 => (Status::Pass, verdict.headline()),
        _ => match standing(&all_checks(table1), accepted).next() {
            Some(check) => (Status::Rejected, format!("rejected by {}: {}", check.name, check.text())),
            None => (Status::NotJudged, "not judged: no verdict on every pivot covers these tables".to_owned()),
        },
    }
}
