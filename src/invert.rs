//! From Table 1 to Table 2: the torque that gives the desired acceleration at the present speed.
//!
//! In: `table1.json`. Out: an [`Inversion`]: `table2.json` and its CSVs. At each speed the fine surface is piecewise linear and rises with
//! torque, so its inverse is exact. A controller reads a bilinear table, so the nodes are chosen for the smallest squared error at and
//! between them.

mod breaks;
mod delivered_torque;
mod error;
mod inverse;
mod optimal;
mod product;
mod raw;
mod round_trip;
mod settings;

pub(crate) use crate::map::ZeroRow;
pub use error::Error;
pub(crate) use error::Result;
pub(crate) use product::described_tables;
pub use product::{Inversion, invert};
pub use raw::RawSettings;
pub use settings::InvertSettings;
