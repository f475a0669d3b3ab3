//! From MCAP logs of torque-step runs to a torque map that has been proven in closed loop.
//!
//! A low-speed vehicle with one steerable, driven front wheel pivots on the spot when that wheel is turned by 90°. Its controller asks
//! for an acceleration; a torque map says which torque gives it at the present wheel speed. This library makes that map:
//!
//! ```text
//!  MCAP logs ──► signals ──► runs ──► Table 1 ──► Table 2 ──► verdict ──► page
//!   record /       log        campaign    fit       invert       verify     report
//!   any vehicle
//! ```
//!
//! Table 1 is a(v, τ), the acceleration over front-wheel speed and torque; Table 2 is τ(v, a), the torque over front-wheel speed and
//! desired acceleration. [`calibrate()`] goes from logs to a verified map in one call; each stage also works alone:
//!
//! | stage | call |
//! |---|---|
//! | read logs | [`calibrate::read_logs`], or [`log::read`] for one |
//! | survey | [`calibrate::survey`] |
//! | fit | [`fit::fit`], [`fit::fit_angles`], or [`calibrate::fit_logs`] |
//! | invert | [`invert::invert`], or [`calibrate::invert_folder`] |
//! | verify | [`verify::verify`], or [`calibrate::verify_folder`] |
//! | report | [`report::report`], or [`calibrate::report_folder`] |
//! | export, check, plan | [`export::Format::files`], [`check::check`], [`plan::plan`] |
//!
//! [`control`] is the controller that is deployed with the map. What else the program can do is on its command line.

pub mod calibrate;
pub mod campaign;
pub mod check;
#[doc(hidden)]
pub mod cli;
pub mod controller;
mod diff;
pub mod export;
pub mod fit;
mod guidance;
mod import;
#[doc(hidden)]
pub mod internals;
pub mod invert;
mod lateral;
pub mod log;
mod manoeuvre;
pub mod map;
pub mod plan;
mod record;
pub mod report;
pub mod scene;
pub mod signal;
mod sim;
mod spelling;
mod text;
mod tune;
mod units;
pub mod verify;

pub use calibrate::{CalibrateSettings, Calibrated, Error, Result, calibrate};
#[doc(no_inline)]
pub use pivot_control as control;
#[doc(hidden)]
pub use pivot_library as library;
