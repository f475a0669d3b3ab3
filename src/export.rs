//! A map in the form that controllers and calibration tools load.
//!
//! In: the folder of a map, whose files must belong together. Out: files, as names and texts, each with the verdict on the map in its header,
//! or the word UNVERIFIED. All are written from `table2.json`, except
//! Autoware's maps from `table1.json`, since they give acceleration over speed and pedal, the plant as FMU from the same file, and the lateral
//! compensation from `lateral_table.json`. The same map gives the same bytes; the binary in an FMU is that of the compiler.

mod a2l;
mod apollo;
mod autoware;
mod c;
mod cdfx;
mod constant;
mod controller_c;
mod dcm;
mod error;
mod file;
mod fmu;
mod json;
mod lateral;
mod lateral_source;
mod number;
mod proof;
mod provenance;
mod rust;
mod settings;
mod source;
mod stored;
mod user_unit;

pub use error::Error;
pub(crate) use error::Result;
pub use file::File;
pub use number::Precision;
pub use proof::Proof;
pub use settings::ExportSettings;
pub use source::MapSource;
pub use user_unit::{UnitNumbers, UserUnit, UserUnits};

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
    /// A2L (ASAP2), of the exported C.
    A2l,
    /// `table2.json` with its JSON Schema.
    Json,
    /// The whole pivot controller in C99.
    ControllerC,
    /// The identified plant as FMI 2.0 and 3.0 units for co-simulation.
    Fmu,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 10] =
        [Self::C, Self::Rust, Self::Autoware, Self::Apollo, Self::Dcm, Self::Cdfx, Self::A2l, Self::Json, Self::ControllerC, Self::Fmu];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::C => "c",
            Self::Rust => "rust",
            Self::Autoware => "autoware",
            Self::Apollo => "apollo",
            Self::Dcm => "dcm",
            Self::Cdfx => "cdfx",
            Self::A2l => "a2l",
            Self::Json => "json",
            Self::ControllerC => "controller-c",
            Self::Fmu => "fmu",
        }
    }

    /// The files of this form.
    ///
    /// # Errors
    /// A map that this form cannot hold: without braking torques for Autoware, not strictly monotone for Autoware and Apollo, without raw
    /// units for whole counts. Units of the user for a form with units of its own.
    pub fn files(self, source: &MapSource, settings: &ExportSettings) -> Result<Vec<File>> {
        let precision = settings.precision;
        if self.has_own_units() && !settings.units.are_si() {
            return Err(Error::OwnUnits { format: self.name() });
        }
        match self {
            Self::C => Ok(c::files(source, settings)?.into_iter().chain(lateral::c_files(source, precision)).collect()),
            Self::Rust => Ok(std::iter::once(rust::file(source, settings)?).chain(lateral::rust_files(source, precision)).collect()),
            Self::Autoware => autoware::files(source, settings),
            Self::Apollo => apollo::files(source, settings),
            Self::Dcm => Ok(vec![dcm::file(source, &settings.units)]),
            Self::Cdfx => Ok(vec![cdfx::file(source, &settings.units)]),
            Self::A2l => Ok(vec![a2l::file(source, settings)?]),
            Self::Json => Ok(json::files(source)),
            Self::ControllerC => controller_c::files(source, settings),
            Self::Fmu => fmu::files(source, settings),
        }
    }

    /// Whether its units are part of the form.
    fn has_own_units(self) -> bool {
        matches!(self, Self::Autoware | Self::Apollo | Self::Json | Self::ControllerC | Self::Fmu)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
