//! Whether a scene can be planned for a vehicle; if not, why, at which key, and what to do.

use crate::guidance::{Error as Planning, parking, u_turn};
use crate::map::toml_line;
use crate::scene::manoeuvre_scene::ManoeuvreScene;
use crate::scene::{Error, Result};
use crate::units::RAD_PER_DEG;

/// Largest wheel angle of a route [°]: it leaves 9° of the tracking limit of 69° as a reserve.
const WHEEL_LIMIT_DEG: f64 = 60.0;

/// The key that a planning error is about, as section and key, and what to do where the message does not say it.
fn about(error: &Planning) -> (&'static str, &'static str, &'static str, &'static str) {
    match error {
        Planning::SlotTooNarrow { .. } => {
            ("parking.slot", "width_m", "parking.slot.width_m", "; widen the slot, or reduce safety_m or the body")
        }
        Planning::RadiusTooLarge { .. } => {
            ("parking.slot", "width_m", "parking.slot.width_m", "; widen the slot, or raise wheel_limit_deg")
        }
        Planning::SlotTooNarrowToEnter { .. } => ("parking.slot", "width_m", "parking.slot.width_m", "; widen the slot"),
        Planning::SlotTooShallow { .. } => {
            ("parking.slot", "depth_m", "parking.slot.depth_m", "; deepen the slot, or reduce safety_m or the body")
        }
        Planning::AisleTooNarrow { .. } => ("parking.slot", "aisle_m", "parking.slot.aisle_m", "; widen the aisle"),
        Planning::NoPath { .. } => ("parking.start", "x_m", "parking.start", "; move the start, move the obstacles, or reduce clearance_m"),
        Planning::RunUpTooShort { .. } => ("u_turn", "run_up_m", "u_turn.run_up_m", "; lengthen the run-up, or lower speed_mps"),
        Planning::StopsInTurn { .. } => ("u_turn", "speed_mps", "u_turn.speed_mps", "; raise the speed"),
        Planning::NoUTurn { nearest_m, .. } if *nearest_m >= 0.0 => {
            ("u_turn", "clearance_m", "u_turn.clearance_m", "; reduce clearance_m, enlarge the field, or move obstacles and lines")
        }
        Planning::NoUTurn { .. } => (
            "u_turn",
            "field_m",
            "u_turn.field_m",
            ", so none does without touching; enlarge the field, move obstacles and lines, or widen run_up_m, speed_mps and wheel_rate_deg_s",
        ),
        Planning::Polygon { .. } => ("u_turn", "field_m", "u_turn.field_m", ""),
        // a number out of its range for this vehicle
        Planning::Setting { .. } => ("body", "width_m", "body", ""),
    }
}

impl ManoeuvreScene {
    /// Plans the scene for a vehicle of this wheelbase [m].
    ///
    /// # Errors
    /// Why it cannot be planned, with the line of the key, the nearest value that can, and what to do.
    pub(crate) fn planned_for(&self, text: &str, wheelbase_m: f64) -> Result<()> {
        let placed = |error: Planning| {
            let (section, key, name, advice) = about(&error);
            Error::Planning { line: toml_line(text, (section, 0), key), key: name, message: format!("{error}{advice}") }
        };
        if let Some(task) = self.parking_task(wheelbase_m).map_err(placed)? {
            parking::plan(&task.scene, task.start).map_err(placed)?;
        }
        if let Some(task) = self.u_turn_task(wheelbase_m).map_err(placed)? {
            u_turn::search(&task.car, &task.scene, &task.ranges, &task.settings).map_err(placed)?;
        }
        if let Some(route) = &self.lateral {
            let (piece, per_m) = route.tightest();
            let most_per_m = (WHEEL_LIMIT_DEG * RAD_PER_DEG).tan() / wheelbase_m;
            if per_m > most_per_m {
                let message = format!(
                    "piece {piece} has a curvature of {per_m} 1/m; allowed for a wheelbase of {wheelbase_m} m: {most_per_m:.3} 1/m, a wheel angle \
                     of {WHEEL_LIMIT_DEG}°; widen the bend"
                );
                return Err(Error::Planning {
                    line: toml_line(text, ("lateral.piece", piece - 1), "length_m"),
                    key: "lateral.piece",
                    message,
                });
            }
        }
        Ok(())
    }
}
