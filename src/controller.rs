//! The controller's settings as a file: what the user sets, what the verdict stores, and what the exports carry.
//!
//! In: TOML text. Out: [`ControllerSettings`], every value checked, and from them the settings of the pivot controller and of path tracking.
//! `data/controllers/default.toml` is the controller of this program, `data/controllers/plain.toml` the published law with nothing added.

mod apply;
mod error;
mod or_word;
pub(crate) mod sections;
mod setting;
mod settings;

pub use error::Error;
pub(crate) use error::Result;
pub use settings::{ControllerFile, ControllerSettings};
