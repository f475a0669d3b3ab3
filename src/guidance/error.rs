//! Why a manoeuvre cannot be planned, with the nearest feasible parameter.

/// Result of planning.
pub(crate) type Result<T> = core::result::Result<T, Error>;

/// Why a manoeuvre cannot be planned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("{field} is {value}; allowed: {allowed}")]
    Setting { field: &'static str, value: f64, allowed: &'static str },
    #[error("a polygon of {corners} corners {problem}")]
    Polygon { corners: usize, problem: &'static str },
    #[error(
        "the slot is {found_m:.3} m wide; the vehicle of {vehicle_m:.3} m with {clearance_m:.2} m on either side needs at least {nearest_m:.3} m"
    )]
    SlotTooNarrow { found_m: f64, vehicle_m: f64, clearance_m: f64, nearest_m: f64 },
    #[error("the slot is {found_m:.3} m deep; the vehicle needs at least {nearest_m:.3} m")]
    SlotTooShallow { found_m: f64, nearest_m: f64 },
    #[error(
        "the smallest turning radius, {radius_m:.3} m, is too large to enter a slot {found_m:.3} m wide beside the obstacle; nearest feasible width: {nearest_m:.3} m"
    )]
    RadiusTooLarge { radius_m: f64, found_m: f64, nearest_m: f64 },
    #[error(
        "the slot is {found_m:.3} m wide, too narrow to turn into it; nearest feasible width from a start along the row: {nearest_m:.3} m"
    )]
    SlotTooNarrowToEnter { found_m: f64, nearest_m: f64 },
    #[error("the aisle is {found_m:.3} m wide; nearest feasible width from a start along the row: {nearest_m:.3} m")]
    AisleTooNarrow { found_m: f64, nearest_m: f64 },
    #[error(
        "no path into the slot from x {x_m:.2} m, y {y_m:.2} m, heading {heading_deg:.1}°: the best ends {error_m:.3} m and {error_deg:.2}° off with {clearance_m:.3} m of clearance; feasible: {nearest}"
    )]
    NoPath { x_m: f64, y_m: f64, heading_deg: f64, error_m: f64, error_deg: f64, clearance_m: f64, nearest: String },
    #[error(
        "{speed_mps:.3} m/s is not reached in a run-up of {run_up_m:.3} m at {accel_mps2:.2} m/s²; nearest feasible run-up: {nearest_m:.3} m"
    )]
    RunUpTooShort { speed_mps: f64, run_up_m: f64, accel_mps2: f64, nearest_m: f64 },
    #[error("the vehicle stops after {turned_deg:.1}° of the turn; nearest feasible entry speed: {nearest_mps:.3} m/s")]
    StopsInTurn { turned_deg: f64, nearest_mps: f64 },
    #[error(
        "no U-turn has a clearance of {clearance_m:.2} m; the best ({best}) has {lacking_m:.3} m too little: nearest feasible clearance {nearest_m:.3} m"
    )]
    NoUTurn { clearance_m: f64, best: String, lacking_m: f64, nearest_m: f64 },
}
