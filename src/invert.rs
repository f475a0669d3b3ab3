//! From Table 1 to Table 2: which torque gives the desired acceleration at the present speed.
//!
//! In: `table1.json`. Out: an [`Inversion`]: `table2.json` and its CSVs. At each speed the fine surface is piecewise linear and rising in
//! torque, so that its inverse is exact; what a controller reads is a bilinear table, so its nodes are chosen for the least squared error
//! between them, too.

mod breaks;
mod error;
mod inverse;
mod optimal;
mod product;
mod round_trip;
mod settings;

pub use crate::map::ZeroRow;
pub use error::{Error, Result};
pub use product::{Inversion, invert};
pub use settings::InvertSettings;
