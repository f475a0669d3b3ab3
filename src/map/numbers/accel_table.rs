//! Table 1: acceleration over front-wheel speed and torque.

use crate::map::{Axis, Error, Matrix, Result, lookup};

/// Name of the speed axis in errors and CSV corners.
pub(crate) const SPEED_AXIS: &str = "speed_mps";
/// Name of the torque axis in errors and CSV corners.
pub(crate) const TORQUE_AXIS: &str = "torque_nm";

/// a(v, τ) [m/s²] in the gear's frame: speed ≥ 0 in the direction of travel, torque positive when it drives that way.
///
/// One row per torque break, one column per speed break, as in `table1.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct AccelTable {
    torque_nm: Axis,
    speed_mps: Axis,
    accel_mps2: Vec<f64>,
}

impl AccelTable {
    /// Checks and takes over the values, row-major by torque: `accel_mps2[i * speed.len() + j]` belongs to torque i and speed j.
    ///
    /// # Errors
    /// A number of values that does not fit the axes, or a value that is not finite.
    pub fn new(speed_mps: Axis, torque_nm: Axis, accel_mps2: Vec<f64>) -> Result<Self> {
        check_values("Table 1", torque_nm.len(), speed_mps.len(), &accel_mps2)?;
        Ok(Self { torque_nm, speed_mps, accel_mps2 })
    }

    /// Speed breaks [m/s], the columns.
    pub fn speed_mps(&self) -> &Axis {
        &self.speed_mps
    }

    /// Torque breaks [N·m], the rows.
    pub fn torque_nm(&self) -> &Axis {
        &self.torque_nm
    }

    /// All values [m/s²], row-major by torque.
    pub fn values(&self) -> &[f64] {
        &self.accel_mps2
    }

    /// Value [m/s²] at speed break `speed_index` and torque break `torque_index`.
    ///
    /// # Panics
    /// If an index is past its axis.
    pub fn at(&self, speed_index: usize, torque_index: usize) -> f64 {
        assert!(speed_index < self.speed_mps.len());
        self.accel_mps2[torque_index * self.speed_mps.len() + speed_index]
    }

    /// Acceleration [m/s²] by bilinear interpolation, `None` outside the axes.
    pub fn accel_from_torque(&self, speed_mps: f64, torque_nm: f64) -> Option<f64> {
        lookup::bilinear(self.torque_nm.breaks(), self.speed_mps.breaks(), &self.accel_mps2, torque_nm, speed_mps)
    }

    /// The same with speed and torque clamped to the axes; `None` only for NaN.
    pub fn accel_from_torque_clamped(&self, speed_mps: f64, torque_nm: f64) -> Option<f64> {
        lookup::bilinear_clamped(self.torque_nm.breaks(), self.speed_mps.breaks(), &self.accel_mps2, torque_nm, speed_mps)
    }

    /// The matrix of `table1.csv`.
    pub fn to_matrix(&self) -> Matrix {
        Matrix {
            rows_name: TORQUE_AXIS.to_owned(),
            columns_name: SPEED_AXIS.to_owned(),
            row_breaks: self.torque_nm.breaks().to_vec(),
            column_breaks: self.speed_mps.breaks().to_vec(),
            values: self.accel_mps2.clone(),
        }
    }

    /// From the matrix of a `table1.csv`.
    ///
    /// # Errors
    /// Axes in the other order or of other names, and all that [`Axis::new`] and [`AccelTable::new`] refuse.
    pub fn from_matrix(matrix: Matrix) -> Result<Self> {
        matrix.expect_axes(TORQUE_AXIS, SPEED_AXIS)?;
        Self::new(Axis::new(SPEED_AXIS, matrix.column_breaks)?, Axis::new(TORQUE_AXIS, matrix.row_breaks)?, matrix.values)
    }
}

/// Shape and finiteness of a table's values.
pub(crate) fn check_values(table: &'static str, rows: usize, columns: usize, values: &[f64]) -> Result<()> {
    if values.len() != rows * columns {
        return Err(Error::WrongShape { table, rows, columns, found: values.len() });
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(k) => Err(Error::NotFinite { table, row: k / columns, column: k % columns, value: values[k] }),
        None => Ok(()),
    }
}
