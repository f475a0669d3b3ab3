//! Maps of other systems, read without judging them: unreadable parts stay empty, with their place, for `check` to report.

mod apollo;
mod autoware;
mod cells;
mod grid;
mod long_csv;
mod points;

pub(crate) use apollo::points_of_apollo;
pub(crate) use autoware::{Pedal, grid_of_autoware};
pub(crate) use cells::{CsvLine, cells_of_csv};
pub(crate) use grid::{CellGrid, Misread, MisreadKind};
pub(crate) use long_csv::{points_of_long_csv, says_long_form};
pub(crate) use points::{CommandPoint, CommandPoints};
