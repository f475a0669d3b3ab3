//! A map that comes back from a controller or a tool: DCM, CDFX, C, Rust, Autoware, Apollo, matrix and long CSV, our JSON.
//!
//! In: a file, and where the file does not say it the torque that is 100 %. Out: [`ImportedMap`], its points in SI units, each with the
//! worth of its last digit: a torque that differs by less is the same. Units come from the line *Units of the tables* of our headers, or
//! from the names of units that the format has.

mod autoware;
mod c_source;
mod cdfx;
mod csv;
mod dcm;
mod error;
pub(crate) mod foreign;
mod full_scale;
mod imported;
mod number;
mod read;
mod rust_source;
mod unit_names;
mod xml;

pub(crate) use error::{Error, Result};
pub(crate) use full_scale::FullScale;
pub(crate) use imported::{ImportedAccelTable, ImportedMap, ImportedPoint, ImportedTable};
pub(crate) use number::WrittenNumber;
pub(crate) use read::{MapFormat, read_map, source_tables};
