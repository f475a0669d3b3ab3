//! Autoware's `accel_map.csv` and `brake_map.csv`: acceleration over pedal (rows) and speed (columns).
//!
//! Source: the documented behaviour of `raw_vehicle_cmd_converter` (`CSVLoader`): at least two columns, rows of one length; along every
//! column acceleration rises strictly with the accel pedal, or falls strictly with the brake pedal.

use crate::import::foreign::{CellGrid, CsvLine, Misread};

/// Which pedal a map belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pedal {
    /// Acceleration rises with the pedal.
    Accel,
    /// Acceleration falls with the pedal.
    Brake,
}

/// The grid of an Autoware map. The pedal follows from `brake` or `accel` in the file's name, otherwise from the direction of most steps.
pub(crate) fn grid_of_autoware(file_name: &str, cells: &[CsvLine]) -> (Pedal, CellGrid, Vec<Misread>) {
    let (grid, misread) = CellGrid::of_cells(cells);
    let name = file_name.to_ascii_lowercase();
    let pedal = if name.contains("brake") {
        Pedal::Brake
    } else if name.contains("accel") {
        Pedal::Accel
    } else {
        of_steps(&grid)
    };
    (pedal, grid, misread)
}

fn of_steps(grid: &CellGrid) -> Pedal {
    let (rows, columns) = grid.shape();
    let mut balance = 0i64;
    for (i, j) in (1..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        if let (Some(before), Some(value)) = (grid.at(i - 1, j), grid.at(i, j)) {
            balance += i64::from(value > before) - i64::from(value < before);
        }
    }
    if balance < 0 { Pedal::Brake } else { Pedal::Accel }
}
