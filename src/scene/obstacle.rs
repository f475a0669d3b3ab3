//! Quadrangles and other convex polygons of a scene: obstacles, and the field of a U-turn.

use crate::guidance::{PlanePoint, Polygon};
use crate::map::toml_line;
use crate::scene::{Error, Result};
use serde::{Deserialize, Serialize};

/// `[[obstacle]]`: the body stays outside.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObstacleKeys {
    /// Corners in either sense of rotation [m]; the shape is convex.
    pub(crate) corners_m: Vec<[f64; 2]>,
}

/// Largest coordinate of a corner [m].
const FAR_M: f64 = 1000.0;

/// The polygon of corners [m] in the `nth` section of this name.
///
/// # Errors
/// Fewer than three corners, one that is out of range, a shape that is not convex; with the line.
pub(crate) fn polygon(text: &str, (section, nth): (&str, usize), key: &str, corners_m: &[[f64; 2]]) -> Result<Polygon> {
    let shape = |problem: String| {
        let name = if section == "obstacle" { format!("obstacle {}: {key}", nth + 1) } else { format!("{section}.{key}") };
        Error::Shape { line: toml_line(text, (section, nth), key), key: name, problem }
    };
    if let Some([x_m, y_m]) = corners_m.iter().find(|c| c.iter().any(|v| v.is_nan() || v.abs() > FAR_M)) {
        return Err(shape(format!("a corner is at ({x_m}, {y_m}); allowed: -{FAR_M} to {FAR_M} m")));
    }
    let corners = corners_m.iter().map(|[x_m, y_m]| PlanePoint::new(*x_m, *y_m)).collect();
    Polygon::new(corners).map_err(|fault| {
        shape(format!(
            "{fault}; allowed: the corners of a convex shape, in order round it; write a shape that is not convex as several obstacles"
        ))
    })
}
