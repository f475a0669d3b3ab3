//! One scene: its sections, checked against each other.

use crate::guidance::Polygon;
use crate::map::toml_line;
use crate::scene::body::BodyKeys;
use crate::scene::obstacle::{ObstacleKeys, polygon};
use crate::scene::parking::{ParkingKeys, ParkingTask};
use crate::scene::polyline::PolylineKeys;
use crate::scene::route::RouteKeys;
use crate::scene::u_turn::{TurnSide, UTurnKeys, UTurnTask};
use crate::scene::{Error, Result};
use serde::{Deserialize, Serialize};

/// A scene: exactly one of `[parking]`, `[u_turn]`, `[polyline]` and `[lateral]`, with body and obstacles where they have a meaning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManoeuvreScene {
    /// Name; the verdict and the logs are named by it.
    pub(crate) name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) body: Option<BodyKeys>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) obstacle: Vec<ObstacleKeys>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) parking: Option<ParkingKeys>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) u_turn: Option<UTurnKeys>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) polyline: Option<PolylineKeys>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) lateral: Option<RouteKeys>,
}

impl ManoeuvreScene {
    /// Name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Checks every value, and the sections against each other.
    pub(crate) fn checked(&self, text: &str) -> Result<()> {
        let letters = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if self.name.is_empty() || self.name.len() > 40 || !self.name.chars().all(letters) {
            return Err(Error::Name { line: toml_line(text, ("", 0), "name"), found: self.name.clone() });
        }
        let sections =
            [self.parking.is_some(), self.u_turn.is_some(), self.polyline.is_some(), self.lateral.is_some()].iter().filter(|s| **s).count();
        if sections != 1 {
            return Err(Error::Sections { found: sections });
        }
        if let Some(kind) = self.polyline.as_ref().map(|_| "polyline").or_else(|| self.lateral.as_ref().map(|_| "lateral")) {
            if self.body.is_some() {
                return Err(Error::Unused { line: line_of_section(text, "body"), section: "body", kind });
            }
            if !self.obstacle.is_empty() {
                return Err(Error::Unused { line: line_of_section(text, "obstacle"), section: "[obstacle]", kind });
            }
        }
        if let Some(body) = &self.body {
            body.checked(text)?;
        }
        for (nth, obstacle) in self.obstacle.iter().enumerate() {
            polygon(text, ("obstacle", nth), "corners_m", &obstacle.corners_m)?;
        }
        self.parking.as_ref().map_or(Ok(()), |keys| keys.checked(text))?;
        self.u_turn.as_ref().map_or(Ok(()), |keys| keys.checked(text))?;
        self.polyline.as_ref().map_or(Ok(()), |keys| keys.checked(text))?;
        self.lateral.as_ref().map_or(Ok(()), |keys| keys.checked(text))
    }

    fn obstacles(&self) -> crate::guidance::Result<Vec<Polygon>> {
        let corners = |o: &ObstacleKeys| o.corners_m.iter().map(|[x_m, y_m]| crate::guidance::PlanePoint::new(*x_m, *y_m)).collect();
        self.obstacle.iter().map(|o| Polygon::new(corners(o))).collect()
    }

    /// The parking task of a vehicle of this wheelbase [m], if it is one.
    ///
    /// # Errors
    /// None for a checked scene.
    pub(crate) fn parking_task(&self, wheelbase_m: f64) -> crate::guidance::Result<Option<ParkingTask>> {
        let Some(keys) = &self.parking else { return Ok(None) };
        Ok(Some(keys.task(self.body.unwrap_or_default().shape(wheelbase_m), self.obstacles()?)))
    }

    /// The U-turn of a vehicle of this wheelbase [m], if it is one.
    ///
    /// # Errors
    /// None for a checked scene.
    pub(crate) fn u_turn_task(&self, wheelbase_m: f64) -> crate::guidance::Result<Option<UTurnTask>> {
        let Some(keys) = &self.u_turn else { return Ok(None) };
        keys.task(self.body.unwrap_or_default().shape(wheelbase_m), self.obstacles()?).map(Some)
    }

    /// Description.
    pub(crate) fn what(&self) -> String {
        let others = match self.obstacle.len() {
            0 => String::new(),
            1 => ", an obstacle".to_owned(),
            count => format!(", {count} obstacles"),
        };
        if let Some(keys) = &self.parking {
            let how = if keys.nose_in() { "forward into" } else { "backing into" };
            return format!("{how} a given slot at {}°{others}", keys.angle_deg());
        }
        if let Some(keys) = &self.u_turn {
            let side = if keys.side() == TurnSide::Left { "left" } else { "right" };
            return format!("U-turn to the {side} in a given field{others}");
        }
        if let Some(keys) = &self.polyline {
            return format!("{} given segments with turns on the spot, tracked by {}", keys.points().len() - 1, keys.law().title());
        }
        let Some(keys) = &self.lateral else { return String::new() };
        let [yaw_deg, zero_deg] = keys.mounting_deg();
        format!("given route, mounting yaw off by {yaw_deg}° and steering zero off by {zero_deg}°, compensated, in {} gear", keys.gear())
    }
}

/// The line of a section's heading.
fn line_of_section(text: &str, section: &str) -> Option<usize> {
    text.lines().position(|line| line.trim().trim_matches(['[', ']']).trim() == section && line.trim().starts_with('[')).map(|k| k + 1)
}
