//! `[polyline]`: points that are driven one after the other, with turns on the spot at the corners.

use crate::guidance::route::polyline::{PolylinePlan, PolylinePoint, PolylineSettings};
use crate::guidance::route::segment_speed::SegmentSpeed;
use crate::guidance::route::tracking::LawName;
use crate::map::toml_line;
use crate::scene::ranges::{check, ranged};
use crate::scene::{Error, Result};
use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// One point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PointKeys {
    /// East [m].
    x_m: f64,
    /// North [m].
    y_m: f64,
    /// Set speed of the segment that begins here [m/s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    speed_mps: Option<f64>,
}

/// `[polyline]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PolylineKeys {
    /// The points.
    points: Vec<PointKeys>,
    /// Tracking law.
    #[serde(default = "law")]
    law: LawName,
    /// Heading of the vehicle at the first point [°]; that of the first segment if it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    start_heading_deg: Option<f64>,
    /// Set speed of segments without one of their own [m/s].
    #[serde(default = "cruise")]
    cruise_mps: f64,
    /// Distance from rest to the set speed [m].
    #[serde(default = "accelerating")]
    accelerating_m: f64,
    /// Distance from the set speed to the stop [m].
    #[serde(default = "decelerating")]
    decelerating_m: f64,
    /// A corner of at most this angle is driven through [°].
    #[serde(default = "continues")]
    continues_deg: f64,
}

fn law() -> LawName {
    LawName::Lqr
}
fn cruise() -> f64 {
    SegmentSpeed::default().cruise_mps
}
fn accelerating() -> f64 {
    SegmentSpeed::default().accelerating_m
}
fn decelerating() -> f64 {
    SegmentSpeed::default().decelerating_m
}
fn continues() -> f64 {
    5.0
}

/// Most points of a file.
const MOST_POINTS: usize = 10_000;

impl PolylineKeys {
    /// Checks every number, and that the points are a path.
    pub(crate) fn checked(&self, text: &str) -> Result<()> {
        let numbers = [
            // above the speed at which a leg begins
            ranged("cruise_mps", self.cruise_mps, SegmentSpeed::default().start_mps, 5.0),
            ranged("accelerating_m", self.accelerating_m, 0.1, 100.0),
            ranged("decelerating_m", self.decelerating_m, 0.1, 100.0),
            ranged("continues_deg", self.continues_deg, 0.0, 30.0),
            ranged("start_heading_deg", self.start_heading_deg.unwrap_or(0.0), -360.0, 360.0),
        ];
        check(text, ("polyline", 0), &numbers)?;
        let shape =
            |problem: String| Error::Shape { line: toml_line(text, ("polyline", 0), "points"), key: "polyline.points".to_owned(), problem };
        if self.points.len() > MOST_POINTS {
            return Err(shape(format!("{} points; allowed: {MOST_POINTS}", self.points.len())));
        }
        PolylinePlan::new(&self.points(), &self.settings()).map_err(|fault| shape(fault.to_string())).map(|_| ())
    }

    /// The law.
    pub(crate) fn law(&self) -> LawName {
        self.law
    }

    /// The points.
    pub(crate) fn points(&self) -> Vec<PolylinePoint> {
        self.points.iter().map(|p| PolylinePoint { x_m: p.x_m, y_m: p.y_m, speed_mps: p.speed_mps }).collect()
    }

    /// Settings of the plan.
    pub(crate) fn settings(&self) -> PolylineSettings {
        PolylineSettings {
            continues_rad: self.continues_deg * RAD_PER_DEG,
            start_heading_rad: self.start_heading_deg.map(|deg| deg * RAD_PER_DEG),
            speed: SegmentSpeed {
                cruise_mps: self.cruise_mps,
                accelerating_m: self.accelerating_m,
                decelerating_m: self.decelerating_m,
                ..SegmentSpeed::default()
            },
            ..PolylineSettings::default()
        }
    }
}
