//! A scene file: the scene with the hash of its text.

use crate::map::{sha256_hex, toml_text};
use crate::scene::manoeuvre_scene::ManoeuvreScene;
use crate::scene::{Error, Result};
use serde::{Deserialize, Serialize};

/// A scene with the hash of its file, as `verify.json` stores it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneFile {
    /// SHA-256 of the file.
    sha256: String,
    /// Its content, with the defaults of keys that it leaves out.
    scene: ManoeuvreScene,
}

impl SceneFile {
    /// Reads the text of a scene file.
    ///
    /// # Errors
    /// Text that is not TOML, a key that is not known (the nearest known one is given), a value out of its range, sections that do not belong
    /// together, corners that are no convex shape, points that are no path.
    pub fn from_toml(text: &str) -> Result<Self> {
        let scene: ManoeuvreScene =
            toml_text(text).map_err(|fault| Error::Toml { line: fault.line, message: fault.message, nearest: fault.nearest })?;
        scene.checked(text)?;
        Ok(Self { sha256: sha256_hex(text.as_bytes()), scene })
    }

    /// The same, planned for a vehicle of this wheelbase [m], so that a scene that cannot be driven is an error here.
    ///
    /// # Errors
    /// As [`SceneFile::from_toml`]; also a slot, an aisle, a start, a field or a bend for which no path is found, with the key, its line, the nearest
    /// feasible value and what to do.
    pub fn from_toml_for(text: &str, wheelbase_m: f64) -> Result<Self> {
        let file = Self::from_toml(text)?;
        file.scene.planned_for(text, wheelbase_m)?;
        Ok(file)
    }

    /// The scene.
    pub fn scene(&self) -> &ManoeuvreScene {
        &self.scene
    }

    /// SHA-256 of the file.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const DOCK: &str = include_str!("../../data/scenes/dock.toml");
    const YARD: &str = include_str!("../../data/scenes/yard.toml");
    const ROUND: &str = include_str!("../../data/scenes/round.toml");
    const AISLE: &str = include_str!("../../data/scenes/aisle.toml");

    #[test]
    fn the_examples_are_planned_and_stored_whole() {
        for text in [DOCK, YARD, ROUND, AISLE] {
            let file = SceneFile::from_toml_for(text, 0.9).unwrap();
            assert_eq!(file.sha256(), sha256_hex(text.as_bytes()));
            let json = serde_json::to_string(&file).unwrap();
            assert_eq!(serde_json::from_str::<SceneFile>(&json).unwrap(), file);
        }
    }

    #[test]
    fn what_cannot_be_planned_is_named_with_its_line_what_is_allowed_and_what_to_do() {
        let cases = [
            // the file
            (DOCK, "name = \"dock\"", "name = \"my dock\"", "line 4: the name \"my dock\" is not allowed", "letters, digits"),
            (DOCK, "aisle_m = 3.60", "asile_m = 3.60", "line 17: unknown field `asile_m`", "did you mean `aisle_m`?"),
            (DOCK, "width_m = 1.35\n", "", "missing field `width_m`", "line 14"),
            (DOCK, "[[obstacle]]", "[polyline]\npoints = []\n[[obstacle]]", "the file holds 2 of the sections", "a file of its own"),
            (
                ROUND,
                "[polyline]",
                "[body]\nwidth_m = 1\n[polyline]",
                "line 5: [body] has no meaning in a scene with [polyline]",
                "leave it out",
            ),
            // ranges
            (DOCK, "angle_deg = 90.0", "angle_deg = 20", "line 18: parking.slot.angle_deg is 20", "allowed: 30 to 150"),
            (DOCK, "width_m = 0.76", "width_m = nan", "line 7: body.width_m is NaN", "allowed: 0.1 to 5"),
            (YARD, "run_up_m = [1.0, 6.0]", "run_up_m = [6.0, 1.0]", "line 9: u_turn.run_up_m is 6 to 1", "exchange them"),
            // shapes
            (
                DOCK,
                "[0.9, 3.6], [-0.9, 3.6]",
                "[-0.9, 3.6], [0.9, 3.6]",
                "line 27: obstacle 1: corners_m: a polygon of 4 corners",
                "in order round it",
            ),
            (YARD, ", [8.5, 5.0], [0.0, 5.0]]", "]", "line 6: u_turn.field_m: a polygon of 2 corners needs at least 3", "convex"),
            (
                ROUND,
                "x_m = 5.0, y_m = 3.0",
                "x_m = 5.0, y_m = 0.05",
                "line 9: polyline.points: points 2 and 3 are 0.05 m apart",
                "leave out point 3",
            ),
            (ROUND, "speed_mps = 0.5", "speed_mps = 9", "the set speed at point 2 is 9 m/s", "0.05 to 5 m/s"),
            (AISLE, "length_m = 52.0", "length_m = 20.0", "line 8: lateral.piece: the pieces are 44 m long together", "shorten learning_m"),
            (
                AISLE,
                "to_per_m = 0.125",
                "to_per_m = 0.05",
                "line 20: lateral.piece 3: the curvature jumps from 0.05 to 0.125",
                "put a piece before it",
            ),
            // planning
            (
                DOCK,
                "width_m = 1.35",
                "width_m = 1.0",
                "line 15: parking.slot.width_m: the slot is 1.000 m wide",
                "at least 1.160 m; widen the slot",
            ),
            (
                DOCK,
                "depth_m = 1.90",
                "depth_m = 1.2",
                "line 16: parking.slot.depth_m: the slot is 1.200 m deep",
                "at least 1.650 m; deepen",
            ),
            (DOCK, "aisle_m = 3.60", "aisle_m = 1.0", "line 17: parking.slot.aisle_m: the aisle is 1.000 m wide", "nearest feasible width"),
            (DOCK, "y_m = 1.5", "y_m = 9.5", "line 21: parking.start: no path into the slot from x -2.00 m, y 9.50 m", "move the start"),
            (DOCK, "[-0.9, 3.1], [0.9, 3.1]", "[-0.9, 0.6], [0.9, 0.6]", "no path into the slot", "move the obstacles"),
            (
                YARD,
                "run_up_m = [1.0, 6.0]",
                "run_up_m = [0.0, 0.05]",
                "line 9: u_turn.run_up_m: 0.300 m/s is not reached",
                "lengthen the run-up",
            ),
            (
                YARD,
                "clearance_m = 0.25",
                "clearance_m = 0.9",
                "line 8: u_turn.clearance_m: no U-turn has a clearance of 0.90 m",
                "reduce clearance_m",
            ),
            (
                YARD,
                "[8.5, 0.0], [8.5, 5.0]",
                "[4.4, 0.0], [4.4, 5.0]",
                "line 6: u_turn.field_m: no U-turn has a clearance",
                "so none does without touching",
            ),
            (AISLE, "from_per_m = 0.125\n\n", "from_per_m = 0.125\nto_per_m = 2.0\n\n", "jumps from 2 to 0.125", "allowed: a step of 0.02"),
        ];
        for (text, from, to, found, advice) in cases {
            assert!(text.contains(from), "{from}");
            let error = SceneFile::from_toml_for(&text.replacen(from, to, 1), 0.9).unwrap_err().to_string();
            assert!(error.contains(found) && error.contains(advice), "{to}: {error}");
        }
        let tight = AISLE.replace("0.125", "0.6").replace("length_m = 2.0", "length_m = 20.0");
        assert!(SceneFile::from_toml_for(&tight, 0.9).is_ok());
        let error = SceneFile::from_toml_for(&tight, 3.0).unwrap_err().to_string();
        assert!(
            error.contains("line 15: lateral.piece: piece 2 has a curvature of 0.6 1/m") && error.contains("widen the bend"),
            "{error}"
        );
    }
}
