//! From surveys at one or several wheel angles to Table 1: a fit per angle with shared delays, the common part of the maps, one file.

mod family;
mod fit_traces;
mod fitted_angles;
mod listed_runs;
mod shared_delays;
mod shrink_together;
mod table1_file;

pub use table1_file::Fit;

use crate::campaign::{AngleGroup, Grouped, Survey};
use crate::fit::angles::fitted_angles::Task;
use crate::fit::{FitSettings, Result};
use crate::map::FitTraces;

/// Fits Table 1 to the surveyed logs of one vehicle, at one wheel angle. The order of the logs does not matter.
///
/// # Errors
/// No logs, logs of different vehicles, too little motion, one torque only, a speed signal that is too slow and alone.
pub fn fit(surveys: Vec<Survey>, settings: &FitSettings) -> Result<Fit> {
    let group = AngleGroup::of(surveys);
    let test_angle_deg = group.wheel_angle_deg;
    let grouped = sorted(group.into());
    Task::new(&grouped, false, test_angle_deg, settings).fitted()?.table1()
}

/// The same fit with the thinned traces for a report.
///
/// # Errors
/// As [`fit`].
pub(crate) fn fit_traced(surveys: Vec<Survey>, settings: &FitSettings) -> Result<(Fit, FitTraces)> {
    let group = AngleGroup::of(surveys);
    let test_angle_deg = group.wheel_angle_deg;
    fit_angles(group.into(), false, test_angle_deg, settings)
}

/// Fits every group; the maps of `test_angle_deg` have the plain file names.
///
/// An angle that cannot be fitted is skipped, and a note gives the reason; at `test_angle_deg` it is an error. With `asked`, the user
/// requested the angles: one that is skipped, or whose table is not sound, makes the fit not sound. Without it, angles were only found in
/// the logs, and one without a sound table is skipped like one that cannot be fitted: a drive across the yard spoils no campaign.
///
/// # Errors
/// As [`fit`]; no group at `test_angle_deg`.
pub fn fit_angles(grouped: Grouped, asked: bool, test_angle_deg: f64, settings: &FitSettings) -> Result<(Fit, FitTraces)> {
    let grouped = sorted(grouped);
    let task = Task::new(&grouped, asked, test_angle_deg, settings);
    let fitted = task.fitted()?;
    let fit = fitted.table1()?;
    let traces = fitted.traces(&fit)?;
    Ok((fit, traces))
}

/// Groups by rising angle, and the surveys of each by log, so that the order in which logs are given does not matter.
fn sorted(mut grouped: Grouped) -> Grouped {
    for group in &mut grouped.groups {
        group.surveys.sort_by(|a, b| a.track.source.cmp(&b.track.source));
    }
    grouped.groups.sort_by(|a, b| a.wheel_angle_deg.total_cmp(&b.wheel_angle_deg));
    grouped
}
