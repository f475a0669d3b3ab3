//! A fitted map against the exact one, cell by cell: the torque that Table 2 gives for the true acceleration, over the cells that Table 1 calls
//! measured.

use super::Fallible;
use pivot_cal::control::RAD_PER_DEG;
use pivot_cal::internals::VehicleFile;
use pivot_cal::invert::{InvertSettings, invert};
use pivot_cal::map::{CellStatus, CsvRef, Gear, Table1File};

/// Slower than this the exact map changes faster than a table [m/s].
const SLOWEST_MPS: f64 = 0.04;

/// One measured cell.
#[derive(Debug, Clone, Copy)]
#[allow(dead_code)] // every user takes what it needs
pub(crate) struct MeasuredCell {
    pub(crate) gear: Gear,
    pub(crate) speed_mps: f64,
    pub(crate) torque_nm: f64,
    /// Magnitude of the torque error [N·m].
    pub(crate) error_nm: f64,
    /// Reported standard error [N·m].
    pub(crate) std_err_nm: f64,
}

impl MeasuredCell {
    /// Whether the error is above `error_nm` and `std_errs` reported standard errors.
    pub(crate) fn is_off_by(&self, error_nm: f64, std_errs: f64) -> bool {
        self.error_nm > error_nm && self.error_nm > std_errs * self.std_err_nm
    }
}

/// The measured cells of `file`. A warming vehicle is judged by its mean over the runs of the gear.
pub(crate) fn measured_cells(vehicle: &VehicleFile, file: &Table1File) -> Fallible<Vec<MeasuredCell>> {
    let angle_rad = vehicle.settings().vehicle.test_angle_deg * RAD_PER_DEG;
    let inverted = invert(file, CsvRef { file: "table1.json".into(), sha256: String::new() }, &InvertSettings::default())?.file;
    let mut cells = Vec::new();
    for map in &file.maps {
        let truth = mean_vehicle(vehicle, file, map.gear).truth()?;
        let table2 = inverted.maps.iter().find(|m| m.gear == map.gear).ok_or("no Table 2")?;
        let table = table2.table()?;
        for (i, &torque_nm) in map.torque_nm.iter().enumerate() {
            for (j, &speed_mps) in map.speed_mps.iter().enumerate() {
                let accel = |u: f64| truth.gear_accel_mps2(map.gear, speed_mps, u, angle_rad);
                // where a limit makes more torque no acceleration, every torque is right
                let slope = (accel(torque_nm + 0.05) - accel(torque_nm - 0.05)) / 0.1;
                if map.status[i][j] != CellStatus::Measured || speed_mps < SLOWEST_MPS || slope < 1e-3 {
                    continue;
                }
                let Some(answer_nm) = table.torque_from_accel(speed_mps, accel(torque_nm)) else { continue };
                let (error_nm, std_err_nm) = ((answer_nm - torque_nm).abs(), map.std_err_mps2[i][j] / slope);
                cells.push(MeasuredCell { gear: map.gear, speed_mps, torque_nm, error_nm, std_err_nm });
            }
        }
    }
    Ok(cells)
}

/// The vehicle with its mean friction over the runs of a gear.
fn mean_vehicle(vehicle: &VehicleFile, file: &Table1File, gear: Gear) -> VehicleFile {
    let mut mean = vehicle.clone();
    let motion = &mut mean.motion;
    let (mut cold, mut used_s) = (0.0, 1e-9);
    for run in file.report.runs.iter().filter(|run| run.gear == gear) {
        cold += run.used_s * (-(run.start_s + 0.5 * run.duration_s) / motion.warming_time_s).exp();
        used_s += run.used_s;
    }
    let factor = 1.0 - motion.friction_fall * (1.0 - cold / used_s);
    for friction in
        [&mut motion.coulomb_nm, &mut motion.static_nm, &mut motion.scrub_nm, &mut motion.viscous_nm_s_m, &mut motion.quadratic_nm_s2_m2]
    {
        *friction *= factor;
    }
    mean
}
