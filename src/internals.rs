//! What benchmarks, fuzz targets, studies and tests against the simulator use beyond the library's interface.
//!
//! They are crates of their own, and so see only what is public. This is no part of the interface: it is not documented, and changes at any
//! time.

pub use crate::campaign::{ledger, with_missing};
pub use crate::guidance::route::follower::DriveStage;
pub use crate::guidance::route::polyline::{PolylinePlan, PolylinePoint, PolylineSettings};
pub use crate::guidance::u_turn;
pub use crate::guidance::{BodyShape, PlanePoint, Polygon};
pub use crate::log::extract::fields::FieldReader;
pub use crate::log::file::lz4::decompress as decompress_lz4;
pub use crate::log::path::MessagePath;
pub use crate::log::read::{read_lateral_bytes, read_signals};
pub use crate::log::survey::survey_bytes;
pub use crate::manoeuvre::picture::picture;
pub use crate::manoeuvre::{DEMO_POINTS, Manoeuvre, ManoeuvreKind, ManoeuvreMoment, ManoeuvreSettings, demo_points, replay_manoeuvre};
pub use crate::map::files::lateral_table_file::LateralTableFile;
pub use crate::map::numbers::AccelMaps;
pub use crate::plan::expected::{ExpectedCell, expected};
pub use crate::record::{Campaign, RunGroup, Torques, record};
pub use crate::scene::SceneFile;
pub use crate::sim::{
    GearSurface, IdentifiedSettings, MotionSettings, PhysicalSettings, Truth, VehicleFile, World, WorldCommand, WorldSettings,
};
pub use crate::verify::bench::PivotMoment;
pub use crate::verify::judge::replay;
pub use crate::verify::metric::Values;
pub use crate::verify::reference_maps::known_maps;
