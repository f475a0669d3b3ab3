//! The scenes of manoeuvres as files: what stands where, which body drives, and where it starts.
//!
//! In: TOML text. Out: a [`SceneFile`], every value checked, and from it the inputs of path planning for a vehicle's wheelbase. Keys:
//! `docs/manoeuvres.md`; examples: `data/scenes/`.

mod body;
mod error;
mod file;
mod manoeuvre_scene;
mod obstacle;
mod parking;
mod place;
mod plane_frame;
mod polyline;
mod ranges;
mod route;
mod u_turn;

pub use error::Error;
pub(crate) use error::Result;
pub use file::SceneFile;
pub use manoeuvre_scene::ManoeuvreScene;
pub(crate) use route::RouteKeys;
pub(crate) use u_turn::UTurnTask;
