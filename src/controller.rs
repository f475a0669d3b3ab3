//! The controller's settings as a file: what the user sets, what the verdict stores, and what the exports carry.
//!
//! In: TOML text. Out: [`ControllerSettings`], every value checked, and from them the settings of the pivot controller and of path tracking.
//! `data/controllers/default.toml` is the controller of this program, `data/controllers/plain.toml` the published law with nothing added.

mod apply;
mod error;
pub(crate) mod module_sections;
pub(crate) mod or_word;
mod sections;
mod setting;
mod settings;
pub(crate) mod words;

pub use error::Error;
pub(crate) use error::Result;
pub use settings::{ControllerFile, ControllerSettings};
