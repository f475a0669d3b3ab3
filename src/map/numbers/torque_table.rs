//! Table 2: torque over front-wheel speed and desired acceleration.

use crate::control::TableView;
use crate::map::{Axis, Matrix, Result, SPEED_AXIS, check_values, lookup};

/// Name of the acceleration axis in errors and CSV corners.
pub(crate) const ACCEL_AXIS: &str = "accel_mps2";

/// τ(v, a) [N·m] in the gear's frame, the table that the deployed controller reads.
///
/// One row per speed break, one column per acceleration break, as in `table2.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueTable {
    speed_mps: Axis,
    accel_mps2: Axis,
    torque_nm: Vec<f64>,
}

impl TorqueTable {
    /// Checks and takes over the values, row-major by speed: `torque_nm[i * accel.len() + j]` belongs to speed i and acceleration j.
    ///
    /// # Errors
    /// A number of values that does not fit the axes, or a value that is not finite.
    pub fn new(speed_mps: Axis, accel_mps2: Axis, torque_nm: Vec<f64>) -> Result<Self> {
        check_values("Table 2", speed_mps.len(), accel_mps2.len(), &torque_nm)?;
        Ok(Self { speed_mps, accel_mps2, torque_nm })
    }

    /// Speed breaks [m/s], the rows.
    pub fn speed_mps(&self) -> &Axis {
        &self.speed_mps
    }

    /// Breaks of the desired acceleration [m/s²], the columns.
    pub fn accel_mps2(&self) -> &Axis {
        &self.accel_mps2
    }

    /// All values [N·m], row-major by speed.
    pub fn values(&self) -> &[f64] {
        &self.torque_nm
    }

    /// Value [N·m] at speed break `speed_index` and acceleration break `accel_index`.
    ///
    /// # Panics
    /// If an index is past its axis.
    pub fn at(&self, speed_index: usize, accel_index: usize) -> f64 {
        assert!(accel_index < self.accel_mps2.len());
        self.torque_nm[speed_index * self.accel_mps2.len() + accel_index]
    }

    /// Torque [N·m] by bilinear interpolation, `None` outside the axes.
    pub fn torque_from_accel(&self, speed_mps: f64, accel_mps2: f64) -> Option<f64> {
        lookup::bilinear(self.speed_mps.breaks(), self.accel_mps2.breaks(), &self.torque_nm, speed_mps, accel_mps2)
    }

    /// The same with speed and acceleration clamped to the axes; `None` only for NaN.
    pub fn torque_from_accel_clamped(&self, speed_mps: f64, accel_mps2: f64) -> Option<f64> {
        lookup::bilinear_clamped(self.speed_mps.breaks(), self.accel_mps2.breaks(), &self.torque_nm, speed_mps, accel_mps2)
    }

    /// The table as the controller reads it.
    pub fn view(&self) -> TableView<'_> {
        TableView { speed_mps: self.speed_mps.breaks(), accel_mps2: self.accel_mps2.breaks(), torque_nm: &self.torque_nm }
    }

    /// The matrix of `table2.csv`.
    pub fn to_matrix(&self) -> Matrix {
        Matrix {
            rows_name: SPEED_AXIS.to_owned(),
            columns_name: ACCEL_AXIS.to_owned(),
            row_breaks: self.speed_mps.breaks().to_vec(),
            column_breaks: self.accel_mps2.breaks().to_vec(),
            values: self.torque_nm.clone(),
        }
    }

    /// From the matrix of a `table2.csv`.
    ///
    /// # Errors
    /// Axes in the other order or of other names, and all that [`Axis::new`] and [`TorqueTable::new`] refuse.
    pub fn from_matrix(matrix: Matrix) -> Result<Self> {
        matrix.expect_axes(SPEED_AXIS, ACCEL_AXIS)?;
        Self::new(Axis::new(SPEED_AXIS, matrix.row_breaks)?, Axis::new(ACCEL_AXIS, matrix.column_breaks)?, matrix.values)
    }
}
