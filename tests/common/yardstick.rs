//! What a map is judged by: the torque that it gives for the accelerations of the simulator's own map, over cells fixed beforehand.

use pivot_cal::control::RAD_PER_DEG;
use pivot_cal::internals::VehicleFile;
use pivot_cal::invert;
use pivot_cal::invert::invert;
use pivot_cal::map::{AccelTable, CsvRef, Gear, Table1File};

use super::Fallible;

/// A place at which a map is judged.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    pub(crate) gear: Gear,
    pub(crate) speed_mps: f64,
    pub(crate) torque_nm: f64,
    pub(crate) accel_mps2: f64,
}

/// The cells, with the truth.
pub(crate) struct Yardstick {
    pub(crate) cells: Vec<Cell>,
}

/// Errors of a map at the cells [N·m], in their order.
pub(crate) struct Errors {
    /// Of Table 2, as a controller reads it.
    pub(crate) table: Vec<f64>,
    /// Of the fitted surface, inverted exactly.
    pub(crate) surface: Vec<f64>,
    /// Cells that lie outside Table 2: the nearest entry answers there.
    pub(crate) outside: usize,
}

impl Yardstick {
    /// Both gears, every 0.05 m/s from 0 (just moving) to `fastest_mps`, every 2 N·m over `torques_nm`.
    pub(crate) fn new(vehicle: &VehicleFile, fastest_mps: f64, torques_nm: [f64; 2]) -> Fallible<Self> {
        let truth = vehicle.truth()?;
        let angle_rad = vehicle.settings().vehicle.test_angle_deg * RAD_PER_DEG;
        let every = |from: f64, to: f64, step: f64| (0..).map(move |k| from + f64::from(k) * step).take_while(move |x| *x < to + 1e-9);
        let mut cells = Vec::new();
        for gear in Gear::ALL {
            for speed_mps in every(0.0, fastest_mps, 0.05) {
                for torque_nm in every(torques_nm[0], torques_nm[1], 2.0) {
                    let accel_mps2 = truth.gear_accel_mps2(gear, speed_mps, torque_nm, angle_rad);
                    cells.push(Cell { gear, speed_mps, torque_nm, accel_mps2 });
                }
            }
        }
        Ok(Self { cells })
    }

    /// The speeds of the moving cells [m/s], rising.
    pub(crate) fn speeds_mps(&self) -> Vec<f64> {
        let mut speeds: Vec<f64> = self.cells.iter().map(|c| c.speed_mps).filter(|v| *v > 0.0).collect();
        speeds.sort_unstable_by(f64::total_cmp);
        speeds.dedup();
        speeds
    }

    pub(crate) fn judge(&self, file: &Table1File) -> Fallible<Errors> {
        let inversion = invert(file, CsvRef { file: "table1.json".into(), sha256: String::new() }, &invert::InvertSettings::default())?;
        let mut errors = Errors { table: Vec::new(), surface: Vec::new(), outside: 0 };
        for gear in Gear::ALL {
            let table = inversion.file.maps.iter().find(|m| m.gear == gear).ok_or("no Table 2 of a gear")?.table()?;
            let surface = file.maps.iter().find(|m| m.gear == gear).ok_or("no Table 1 of a gear")?.surface.table()?;
            for cell in self.cells.iter().filter(|c| c.gear == gear) {
                errors.outside += usize::from(table.torque_from_accel(cell.speed_mps, cell.accel_mps2).is_none());
                let found_nm = table.torque_from_accel_clamped(cell.speed_mps, cell.accel_mps2).ok_or("not a number")?;
                errors.table.push(found_nm - cell.torque_nm);
                errors.surface.push(inverse(&surface, cell.speed_mps, cell.accel_mps2) - cell.torque_nm);
            }
        }
        Ok(errors)
    }
}

/// The torque at which a surface, linear between its torques and beyond them, gives an acceleration [N·m].
pub(crate) fn inverse(surface: &AccelTable, speed_mps: f64, accel_mps2: f64) -> f64 {
    let torques = surface.torque_nm().breaks();
    let at = |k: usize| surface.accel_from_torque_clamped(speed_mps, torques[k]).unwrap_or(f64::NAN);
    let above = (1..torques.len() - 1).find(|k| at(*k) > accel_mps2).unwrap_or(torques.len() - 1);
    let (low, high) = (at(above - 1), at(above));
    torques[above - 1] + (accel_mps2 - low) / (high - low) * (torques[above] - torques[above - 1])
}

impl Yardstick {
    /// Root mean square over the cells at speeds `from_mps` to `to_mps`.
    pub(crate) fn rms_between(&self, errors: &[f64], from_mps: f64, to_mps: f64) -> f64 {
        let inside = |c: &Cell| c.speed_mps > from_mps - 1e-9 && c.speed_mps < to_mps + 1e-9;
        rms(&self.cells.iter().zip(errors).filter(|(c, _)| inside(c)).map(|(_, e)| *e).collect::<Vec<_>>())
    }
}

/// Root of the mean square.
pub(crate) fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
}
