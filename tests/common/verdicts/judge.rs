//! A map against the exact map of its vehicle: how wrong it is where it calls itself measured.

use crate::verdicts::Fallible;
use crate::verdicts::case::{Case, Delivered};
use crate::verdicts::chain::calibrated;
use pivot_cal::control::RAD_PER_DEG;
use pivot_cal::internals::{Truth, VehicleFile};
use pivot_cal::map::{CellStatus, CheckOutcome, Table1File, Table2File};
use pivot_cal::verify::Status;

/// Root mean square torque error of a right map [N·m], for the scrubber's torques; other vehicles in proportion.
pub(crate) const RMS_LIMIT_NM: f64 = 0.5;
/// Standard errors that an error may have, and the share of the cells that may have more.
const STD_ERRS: f64 = 3.0;
const BEYOND_LIMIT: f64 = 0.05;
/// Slower than this the exact map changes faster than a table [m/s].
const SLOWEST_MPS: f64 = 0.04;

/// How wrong a map is.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wrongness {
    /// Cells that were compared.
    pub(crate) cells: usize,
    /// Root mean square torque error [N·m].
    pub(crate) rms_nm: f64,
    /// The same relative to the limit for the vehicle: above 1 the torques are wrong.
    pub(crate) over_limit: f64,
    /// Share of the cells that are wrong by more than three reported standard errors.
    pub(crate) beyond: f64,
}

impl Wrongness {
    /// Whether the torques are wrong.
    pub(crate) fn torques(&self) -> bool {
        self.over_limit > 1.0
    }

    /// Whether the map is wrong: its torques, or its standard errors.
    pub(crate) fn is_wrong(&self) -> bool {
        self.torques() || self.beyond > BEYOND_LIMIT
    }
}

/// What became of a case.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    /// How wrong the map is; `None` if no map was made.
    pub(crate) wrongness: Option<Wrongness>,
    /// The verdict; `None` if the program ended with an error.
    pub(crate) status: Option<Status>,
    /// First line of the verdict, or the error.
    pub(crate) reason: String,
    /// Names of the checks that warn.
    pub(crate) warnings: Vec<String>,
    /// Every check with its figure and limit, in words.
    pub(crate) checks: Vec<String>,
}

impl Outcome {
    /// A pass.
    pub(crate) fn passes(&self) -> bool {
        self.status == Some(Status::Pass)
    }

    /// A map that is wrong.
    pub(crate) fn is_wrong(&self) -> bool {
        self.wrongness.is_some_and(|w| w.is_wrong())
    }

    /// A pass of a wrong map.
    pub(crate) fn is_false_pass(&self) -> bool {
        self.passes() && self.is_wrong()
    }
}

/// Calibrates a case and compares the map with the truth.
///
/// # Errors
/// A vehicle without an exact map.
pub(crate) fn judged(mut case: Case) -> Fallible<Outcome> {
    let truth = case.truth.clone();
    let delivered = std::mem::replace(&mut case.delivered, Box::new(|_, torque_nm, _| torque_nm));
    let limit_nm = RMS_LIMIT_NM * case.size;
    Ok(match calibrated(case) {
        Err(error) => Outcome { wrongness: None, status: None, reason: error.to_string(), warnings: Vec::new(), checks: Vec::new() },
        Ok(made) => {
            let checks = made.verdict.checks.iter().filter(|c| c.outcome == CheckOutcome::Warning);
            Outcome {
                wrongness: Some(compared((&truth, &delivered), (&made.table1, &made.table2), limit_nm)?),
                status: Some(made.verdict.status),
                reason: made.verdict.reason.clone(),
                warnings: checks.map(|c| c.name.clone()).collect(),
                checks: made.verdict.checks.iter().map(|c| format!("{}: {}", c.name, c.text())).collect(),
            }
        }
    })
}

/// The cells that Table 1 calls measured, Table 2's torque for the exact acceleration against the cell's torque.
fn compared(
    (vehicle, delivered): (&VehicleFile, &Delivered),
    (table1, table2): (&Table1File, &Table2File),
    limit_nm: f64,
) -> Fallible<Wrongness> {
    let truth: Truth = vehicle.truth()?;
    let angle_rad = vehicle.settings().vehicle.test_angle_deg * RAD_PER_DEG;
    // a table gives no more than the torque that the vehicle allows
    let most_nm = table1.vehicle.torque_limit_nm.unwrap_or(f64::INFINITY);
    let (mut squares, mut beyond, mut cells) = (0.0, 0usize, 0usize);
    for map in &table1.maps {
        let Some(inverted) = table2.maps.iter().find(|m| m.gear == map.gear) else { continue };
        let table = inverted.table()?;
        for (i, torque_nm) in map.torque_nm.iter().enumerate() {
            for (j, speed_mps) in map.speed_mps.iter().enumerate() {
                let accel = |u: f64| truth.gear_accel_mps2(map.gear, *speed_mps, delivered(*speed_mps, u, map.gear.sign()), angle_rad);
                // where a limit makes more torque no acceleration, every torque is right
                let slope = (accel(*torque_nm + 0.05) - accel(*torque_nm - 0.05)) / 0.1;
                if map.status[i][j] != CellStatus::Measured || *speed_mps < SLOWEST_MPS || torque_nm.abs() > most_nm || slope < 1e-3 {
                    continue;
                }
                // beyond the table's accelerations, the nearest
                let Some(answer_nm) = table.torque_from_accel_clamped(*speed_mps, accel(*torque_nm)) else { continue };
                let error_nm = (answer_nm - torque_nm).abs();
                squares += error_nm * error_nm;
                beyond += usize::from(error_nm > STD_ERRS * map.std_err_mps2[i][j] / slope);
                cells += 1;
            }
        }
    }
    let count = cells.max(1) as f64;
    let rms_nm = (squares / count).sqrt();
    Ok(Wrongness { cells, rms_nm, over_limit: rms_nm / limit_nm, beyond: beyond as f64 / count })
}
