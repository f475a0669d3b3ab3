//! Why a map cannot be exported.

use crate::map::{FolderError, Gear};
use crate::text::shown;
use std::path::PathBuf;

/// Result of this room.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why a map cannot be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("{}: {source}; fit and invert first, or give the folder that holds the map", shown(path))]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{}: {source}", shown(path))]
    File { path: PathBuf, source: crate::map::Error },
    #[error(
        "{} is not the file that {} describes (SHA-256 {found:.12}… instead of {expected:.12}…): it is damaged, was edited, or belongs to \
         another map; run `pivot-cal invert` again",
        shown(path),
        shown(by)
    )]
    Hash { path: PathBuf, by: PathBuf, found: String, expected: String },
    #[error(
        "{} and {} are of different generations ({generations}): one of them was left by another run; run `pivot-cal invert` again",
        shown(path),
        shown(by)
    )]
    Generation { path: PathBuf, by: PathBuf, generations: String },
    #[error(
        "{} holds other numbers than {}, although the hash is right: the JSON is damaged or was edited; make the map again",
        shown(path),
        shown(csv)
    )]
    Differs { path: PathBuf, csv: PathBuf },
    #[error("{} holds no map at the wheel angle of {angle_deg}°; its wheel angles are {found}", shown(path))]
    NoMap { path: PathBuf, angle_deg: f64, found: String },
    #[error("{found:?} is no unit of {what}; allowed: {allowed}")]
    Unit { what: &'static str, found: String, allowed: &'static str },
    #[error("this unit of {what} needs a {needs}: --{what}-{}", needs.replace(' ', "-"))]
    UnitNumber { what: &'static str, needs: &'static str },
    #[error("the unit of {what} has the scale {scale} and the offset {offset}; allowed: a scale above 0, and numbers")]
    UnitScale { what: &'static str, scale: f64, offset: f64 },
    #[error("{format} has units of its own; leave out --speed-unit and --torque-unit, or choose c, rust, dcm, cdfx or a2l")]
    OwnUnits { format: &'static str },
    #[error(
        "the {what} numbers of the map are not whole counts of 16 bits; make them so with `pivot-cal invert --int16` and verify the map again"
    )]
    NotRaw { what: &'static str },
    #[error("{format} computes in double precision, as it was verified; leave out --float and --int16, or choose c or rust")]
    DoubleOnly { format: &'static str },
    #[error("the controller cannot be set up for this map: {0}; change the controller file and verify with it again")]
    Controller(crate::control::Error),
    #[error(transparent)]
    ControllerFile(#[from] crate::controller::Error),
    #[error("the plant of Table 1 cannot be made: {0}; fit again, or give --angle with a forward map")]
    Plant(#[from] crate::sim::Error),
    #[error("lateral_table.json cannot be used by the run-time law: {0}; make it again with `pivot-cal lateral fit`")]
    Lateral(#[from] crate::control::Error),
    #[error(
        "{format} needs values that change strictly with the command, and the {gear} map does not: {place}; `pivot-cal check` lists all places"
    )]
    NotMonotone { format: &'static str, gear: Gear, place: String },
    #[error(
        "{format} needs {what}, and the torques of the {gear} Table 1 reach from {low} to {high} N·m; log runs with such torques, or choose \
         another format"
    )]
    Torques { format: &'static str, what: &'static str, gear: Gear, low: f64, high: f64 },
}

impl From<FolderError> for Error {
    fn from(error: FolderError) -> Self {
        match error {
            FolderError::Read { path, source } => Self::Read { path, source },
            FolderError::File { path, source } => Self::File { path, source },
        }
    }
}
