//! Maps of other systems, read without judging them: what cannot be read stays empty, with its place, for [`crate::check`] to report.

mod apollo;
mod autoware;
mod cells;
mod grid;
mod long_csv;
mod points;

pub use apollo::points_of_apollo;
pub use autoware::{Pedal, grid_of_autoware};
pub use cells::{CsvLine, cells_of_csv};
pub use grid::{CellGrid, Misread, MisreadKind};
pub use long_csv::{points_of_long_csv, says_long_form};
pub use points::{CommandPoint, CommandPoints};
