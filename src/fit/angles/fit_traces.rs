//! The traces of a fit for a report, for all angles.

use crate::campaign::SampleVerdict;
use crate::fit::Result;
use crate::fit::angles::fitted_angles::FittedAngles;
use crate::fit::angles::listed_runs::listed;
use crate::fit::angles::table1_file::Fit;
use crate::fit::table1::delay_likelihood::delay_likelihood;
use crate::fit::table1::traces::AngleTraces;
use crate::map::{CsvRef, FIT_TRACES_FORMAT, FORMAT_VERSION, FitTraces, sha256_hex};

impl FittedAngles<'_> {
    /// The thinned traces of all angles; cells and delays of the test angle.
    ///
    /// # Errors
    /// No fit at the test angle.
    pub(crate) fn traces(&self, fit: &Fit) -> Result<FitTraces> {
        let test = self.test()?;
        let all = self.runs();
        let listed = listed(&all.iter().map(|run| &run.row).collect::<Vec<_>>());
        let mut rows: Vec<Vec<Option<usize>>> = self.angles.iter().map(|angle| vec![None; angle.figures.rows.len()]).collect();
        for (row, run) in listed.iter().enumerate() {
            rows[all[*run].angle][all[*run].own] = Some(row);
        }
        let (mut runs, mut residual_cells, mut residual_times) = (Vec::new(), Vec::new(), Vec::new());
        for (angle, rows) in self.angles.iter().zip(rows) {
            let own = AngleTraces::new(angle)?;
            // a run that table1.json does not list has no row
            runs.extend(own.runs.into_iter().filter_map(|run| Some(crate::map::RunTrace { row: rows[run.row]?, ..run })));
            residual_times.extend(own.residual_times);
            if self.task.is_test(angle.wheel_angle_deg) {
                residual_cells = own.residual_cells;
            }
        }
        runs.sort_by_key(|run| run.row);
        Ok(FitTraces {
            format: FIT_TRACES_FORMAT.to_owned(),
            format_version: FORMAT_VERSION,
            tool_version: env!("CARGO_PKG_VERSION").to_owned(),
            generation: fit.file.generation.clone(),
            table1: CsvRef { file: "table1.json".to_owned(), sha256: sha256_hex(fit.file.to_json()?.as_bytes()) },
            verdicts: SampleVerdict::ALL.iter().map(ToString::to_string).collect(),
            runs,
            residual_cells,
            residual_times,
            delay: delay_likelihood(&test.estimate),
        })
    }
}
