//! A map in the form that controllers and calibration tools load.
//!
//! In: the folder of a map, whose files must belong together. Out: files, as names and texts, each with the verdict on the map in its header,
//! or the word UNVERIFIED. All are written from `table2.json`, except
//! Autoware's maps from `table1.json`, since they give acceleration over speed and pedal, and the lateral compensation from
//! `lateral_table.json`. The same map gives the same bytes.

mod apollo;
mod autoware;
mod c;
mod cdfx;
mod constant;
mod crc;
mod dcm;
mod error;
mod file;
mod json;
mod lateral;
mod lateral_source;
mod number;
mod proof;
mod provenance;
mod rust;
mod source;

pub use error::Error;
pub(crate) use error::Result;
pub use file::File;
pub use number::Precision;
pub use proof::Proof;
pub use source::MapSource;

use std::fmt;

/// A form of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// One header and one source in C99.
    C,
    /// A Rust module that needs `core` only.
    Rust,
    /// Autoware's accel and brake map.
    Autoware,
    /// Apollo's calibration table.
    Apollo,
    /// DCM 2.0.
    Dcm,
    /// ASAM CDF 2.0.
    Cdfx,
    /// `table2.json` with its JSON Schema.
    Json,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 7] = [Self::C, Self::Rust, Self::Autoware, Self::Apollo, Self::Dcm, Self::Cdfx, Self::Json];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::C => "c",
            Self::Rust => "rust",
            Self::Autoware => "autoware",
            Self::Apollo => "apollo",
            Self::Dcm => "dcm",
            Self::Cdfx => "cdfx",
            Self::Json => "json",
        }
    }

    /// The files of this form. `precision` is for C and Rust; the others are decimal text.
    ///
    /// # Errors
    /// A map that this form cannot hold: without braking torques for Autoware, not strictly monotone for Autoware and Apollo.
    pub fn files(self, source: &MapSource, precision: Precision) -> Result<Vec<File>> {
        match self {
            Self::C => Ok(c::files(source, precision).into_iter().chain(lateral::c_files(source, precision)).collect()),
            Self::Rust => Ok(std::iter::once(rust::file(source, precision)).chain(lateral::rust_files(source, precision)).collect()),
            Self::Autoware => autoware::files(source),
            Self::Apollo => apollo::files(source),
            Self::Dcm => Ok(vec![dcm::file(source)]),
            Self::Cdfx => Ok(vec![cdfx::file(source)]),
            Self::Json => Ok(json::files(source)),
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
