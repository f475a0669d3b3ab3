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
//! desired acceleration. Rooms import only rooms further down this list: `report`, `export` and `diff`, `verify`, `record`, `sim`,
//! `control`, `fit`, `invert` and `lateral`, `campaign`, `signal`, `log`, `map`, `units`.

pub mod campaign;
pub mod check;
pub mod cli;
pub mod diff;
pub mod export;
pub mod fit;
pub mod guidance;
pub mod invert;
pub mod lateral;
pub mod log;
pub mod manoeuvre;
pub mod map;
pub mod plan;
pub mod record;
pub mod report;
pub mod signal;
pub mod sim;
mod spelling;
pub mod units;
pub mod verify;

#[doc(no_inline)]
pub use pivot_control as control;
