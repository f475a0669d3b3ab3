//! One trial: a synthetic vehicle drives a campaign, every method makes its map, and each is judged against the truth and the bound.

mod bound;
mod differencing;
mod drive;
mod grid;
mod smoother;
mod vehicle;

use drive::Drive;
use pivot_cal::campaign;
use pivot_cal::campaign::Survey;
use pivot_cal::fit;
use pivot_cal::fit::fit;
use pivot_cal::invert;
use pivot_cal::invert::invert;
use pivot_cal::map::{CellStatus, CsvRef, TorqueTable};
use std::fmt;
pub(crate) use vehicle::Kind;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// Evaluation cells: width in speed [m/s] and torque [N·m], and the samples that make a cell covered.
const CELL_MPS: f64 = 0.05;
const CELL_NM: f64 = 3.0;
const COVERED_SAMPLES: usize = 5;

/// What one trial found. Torque errors are root mean squares over the centres of the covered cells [N·m].
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    pub(crate) cells: usize,
    /// The Cramér-Rao bound.
    pub(crate) bound_nm: f64,
    /// The same table filled with the truth.
    pub(crate) discretisation_nm: f64,
    /// The same table exact at its nodes instead of best over the whole.
    pub(crate) node_exact_nm: f64,
    pub(crate) pivot_cal_nm: f64,
    pub(crate) bins_nm: f64,
    pub(crate) savitzky_golay_nm: f64,
    pub(crate) local_quadratic_nm: f64,
    /// Share of the measured cells of Table 1 whose 95 % interval holds the truth.
    pub(crate) coverage: f64,
    /// Median width of those intervals, relative to the bound's.
    pub(crate) width_ratio: f64,
    /// Share of the surface's deviations from the physics form that was taken.
    pub(crate) surface_share: f64,
    pub(crate) fit_s: f64,
}

impl Outcome {
    /// What no method that writes this table can do better than [N·m].
    pub(crate) fn floor_nm(&self) -> f64 {
        self.bound_nm.hypot(self.discretisation_nm)
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "{} cells, bound {:.3}, table {:.3} ({:.3} node-exact), pivot-cal {:.3}, local quadratic {:.3}, Savitzky-Golay {:.3}, bins {:.3} N·m; intervals hold {:.1} %, {:.2} × as wide as the bound's; {:.2} of the surface; fit {:.1} s",
            self.cells,
            self.bound_nm,
            self.discretisation_nm,
            self.node_exact_nm,
            self.pivot_cal_nm,
            self.local_quadratic_nm,
            self.savitzky_golay_nm,
            self.bins_nm,
            100.0 * self.coverage,
            self.width_ratio,
            self.surface_share,
            self.fit_s
        )
    }
}

/// Runs one trial.
pub(crate) fn run(kind: Kind, minutes: f64, seed: u64) -> Fallible<Outcome> {
    let truth = vehicle::truth(kind);
    let drive = Drive::new(&truth, minutes * 60.0, seed);
    let started = std::time::Instant::now();
    let survey = Survey::new(drive.track.clone(), &campaign::SurveySettings::default())?;
    let fit = fit(vec![survey], &fit::FitSettings::default())?;
    let fit_s = started.elapsed().as_secs_f64();
    let file = &fit.file;
    let reference = || CsvRef { file: "table1.json".into(), sha256: String::new() };
    let table = |file: &pivot_cal::map::Table1File, node_exact: bool| -> Fallible<TorqueTable> {
        let settings = invert::InvertSettings { node_exact, ..invert::InvertSettings::default() };
        Ok(invert(file, reference(), &settings)?.file.maps[0].table()?)
    };
    let ours = table(file, false)?;
    let mut true_file = file.clone();
    let surface = &mut true_file.maps[0].surface;
    for (row, u) in surface.accel_mps2.iter_mut().zip(&surface.torque_nm) {
        for (a, v) in row.iter_mut().zip(&surface.speed_mps) {
            *a = truth.accel_mps2(*v, *u);
        }
    }
    let (filled, exact) = (table(&true_file, false)?, table(&true_file, true)?);

    let covered = covered(&drive);
    // a table answers where it can; all methods are judged on the same cells
    let cells: Vec<(f64, f64)> =
        covered.into_iter().filter(|(v, u)| ours.torque_from_accel(*v, truth.accel_mps2(*v, *u)).is_some()).collect();
    let rms = |answer: &dyn Fn(f64, f64) -> f64| {
        let sum: f64 = cells.iter().map(|(v, u)| (answer(*v, truth.accel_mps2(*v, *u)) - u).powi(2)).sum();
        (sum / cells.len() as f64).sqrt()
    };
    let by_table = |t: &TorqueTable| rms(&|v, a| t.torque_from_accel_clamped(v, a).unwrap_or(f64::NAN));
    let bound = bound::Bound::new(&truth, &drive).ok_or("the bound is singular")?;
    let bound_nm =
        (cells.iter().map(|(v, u)| (bound.accel_std_mps2(*v, *u) / truth.slope(*v, *u)).powi(2)).sum::<f64>() / cells.len() as f64).sqrt();

    let bins = differencing::bins(&drive);
    let savitzky_golay = smoother::surface(&differencing::savitzky_golay(&drive));
    let local_quadratic = smoother::surface(&differencing::local_quadratic(&drive));

    let map = &file.maps[0];
    let (mut inside, mut counted, mut widths) = (0usize, 0usize, Vec::new());
    for (i, u) in map.torque_nm.iter().enumerate() {
        for (j, v) in map.speed_mps.iter().enumerate().filter(|(_, v)| **v > 0.0) {
            if map.status[i][j] == CellStatus::Measured {
                counted += 1;
                let error = (map.accel_mps2[i][j] - truth.accel_mps2(*v, *u)).abs();
                inside += usize::from(error <= 1.96 * map.std_err_mps2[i][j]);
                widths.push(map.std_err_mps2[i][j] / bound.accel_std_mps2(*v, *u));
            }
        }
    }
    Ok(Outcome {
        cells: cells.len(),
        bound_nm,
        discretisation_nm: by_table(&filled),
        node_exact_nm: by_table(&exact),
        pivot_cal_nm: by_table(&ours),
        bins_nm: rms(&|v, a| bins.torque_nm(v, a)),
        savitzky_golay_nm: rms(&|v, a| savitzky_golay.torque_nm(v, a)),
        local_quadratic_nm: rms(&|v, a| local_quadratic.torque_nm(v, a)),
        coverage: inside as f64 / counted.max(1) as f64,
        width_ratio: median(widths),
        surface_share: file.report.diagnostics["model_choice"]["surface_share"].as_f64().unwrap_or(1.0),
        fit_s,
    })
}

/// The middle value, the upper one of the two of an even number; NaN without values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Centres of the cells that hold enough samples of the true motion.
fn covered(drive: &Drive) -> Vec<(f64, f64)> {
    let mut counts = std::collections::BTreeMap::new();
    for sample in drive.samples.iter().filter(|s| s.run.is_some()) {
        let cell = ((sample.speed_mps / CELL_MPS).floor() as i64, (sample.torque_nm / CELL_NM).round() as i64);
        *counts.entry(cell).or_insert(0usize) += 1;
    }
    counts.into_iter().filter(|(_, n)| *n >= COVERED_SAMPLES).map(|((i, j), _)| ((i as f64 + 0.5) * CELL_MPS, j as f64 * CELL_NM)).collect()
}
