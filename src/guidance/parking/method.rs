//! Where this planner departs from the published method, with the published choice as a setting.
//!
//! | | here | published |
//! |---|---|---|
//! | first line | at a set distance from the row | through the vehicle, where it stands |
//! | entry circle | touches line and axis; its radius grows from the smallest until it passes the obstacle's corner | the smallest radius; its centre is solved for so that it touches the line and passes the corner; where it then misses the axis, the moves along the axis follow |
//! | straight in | tried from every start that faces the axis within 80°, taken if the path passes every check | where heading and offset from the axis are small |

use crate::guidance::Result;
use crate::guidance::body::within;
use serde::Serialize;

/// Place of the first line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum FirstLine {
    /// At `line_distance_m` from the row: the entry does not depend on where the vehicle happens to stand. Default.
    #[default]
    SetDistance,
    /// Through the vehicle's start, within the aisle: the vehicle need not change lanes first.
    ThroughStart,
}

/// Choice of the entry circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum EntryMethod {
    /// Radius from the first line: the smallest that passes the corner. The vehicle may stay near the row, and the wheel keeps a reserve.
    /// Default.
    #[default]
    GrownRadius,
    /// The vehicle's smallest radius; the centre on the line's side where the body passes the corner with the safety distance.
    SmallestRadius,
}

/// When the vehicle goes straight in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum StraightIn {
    /// Tried within this angle from the axis [rad], and taken if the path passes every check.
    Tried(f64),
    /// Within this angle [rad] and this offset [m] from the axis, by thresholds alone; then nothing else is tried.
    Thresholds {
        /// Largest angle from the axis [rad].
        heading_rad: f64,
        /// Largest offset from the axis [m].
        offset_m: f64,
    },
}

impl Default for StraightIn {
    fn default() -> Self {
        Self::Tried(80.0_f64.to_radians())
    }
}

/// The choices.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(crate) struct ParkingMethod {
    /// First line.
    pub first_line: FirstLine,
    /// Entry circle.
    pub entry: EntryMethod,
    /// Straight in.
    pub straight_in: StraightIn,
}

impl ParkingMethod {
    /// The published choices, with thresholds of 10° and 0.1 m; the publication's own thresholds are not known here.
    pub(crate) fn published() -> Self {
        Self {
            first_line: FirstLine::ThroughStart,
            entry: EntryMethod::SmallestRadius,
            straight_in: StraightIn::Thresholds { heading_rad: 10.0_f64.to_radians(), offset_m: 0.1 },
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first out of its range.
    pub(crate) fn checked(self) -> Result<Self> {
        let heading_rad = match self.straight_in {
            StraightIn::Tried(heading_rad) => heading_rad,
            StraightIn::Thresholds { heading_rad, offset_m } => {
                within("method.straight_in.offset_m", offset_m, 0.0, 10.0, "0 to 10")?;
                heading_rad
            }
        };
        within("method.straight_in.heading_rad", heading_rad, 0.0, 1.5, "0 to 1.5 (86°)").map(|()| self)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::parking::scene::usual_scene;
    use crate::guidance::parking::tight::circle_past_corner;
    use crate::guidance::parking::{ParkingStart, plan};

    #[test]
    fn the_published_circle_has_the_smallest_radius_and_passes_the_corner_by_the_safety_distance() {
        for wheel_limit_deg in [40.0_f64, 45.0, 50.0] {
            let mut scene = usual_scene(90.0);
            scene.look_ahead.wheel_limit_rad = wheel_limit_deg.to_radians();
            let circle = circle_past_corner(&scene, scene.line_m());
            assert!((circle.radius_m - scene.least_radius_m()).abs() < 1e-12);
            // centre one radius below the line: from the corner at (0.66, 0) it is R − W/2 − d away, or the circle touches the axis
            let centre_m = scene.line_m() - circle.radius_m;
            let from_corner_m = (circle.line_x_m - 0.66).hypot(centre_m);
            let reach_m = circle.radius_m - 0.36 - 0.2;
            assert!(
                (from_corner_m - reach_m).abs() < 1e-9 || (circle.line_x_m - circle.radius_m).abs() < 1e-9 || centre_m > reach_m,
                "{wheel_limit_deg}°: {circle:?}"
            );
        }
    }

    #[test]
    fn the_published_choices_park_and_the_line_goes_through_the_vehicle_if_asked() {
        let start = ParkingStart { x_m: -2.5, y_m: 1.5, ..ParkingStart::default() };
        let mut through = usual_scene(90.0);
        through.method.first_line = FirstLine::ThroughStart;
        assert!((through.with_line_for(start).line_m() - 1.5).abs() < 1e-12);
        let planned = plan(&through, start).unwrap();
        // no change of lanes before the circle
        assert!(planned.path.poses.iter().take_while(|p| p.x_m < 0.0).all(|p| (p.y_m - 1.5).abs() < 1e-3) && planned.judgement.pass);
        // a start outside the aisle's middle part is brought into it
        assert!((through.with_line_for(ParkingStart { y_m: 0.1, ..start }).line_m() - 0.56).abs() < 1e-12);
        let mut published = usual_scene(90.0);
        published.look_ahead.wheel_limit_rad = 60.0_f64.to_radians();
        let ours = plan(&published, start).unwrap();
        published.method = ParkingMethod::published();
        let theirs = plan(&published, start).unwrap();
        // the grown circle enters in one move, the smallest one needs moves along the axis
        assert!(theirs.judgement.pass && ours.shuffles() == 0 && theirs.shuffles() > 0, "{} and {}", ours.moves(), theirs.moves());
        let entry = theirs.entry.unwrap();
        assert!((entry.radius_m - published.least_radius_m()).abs() < 1e-12 && entry.radius_m < ours.entry.unwrap().radius_m);
    }

    #[test]
    fn thresholds_alone_decide_whether_the_vehicle_goes_straight_in() {
        let mut scene = usual_scene(90.0);
        let start = ParkingStart { x_m: 0.3, y_m: 1.8, heading_rad: std::f64::consts::FRAC_PI_2 - 0.3, wheel_angle_rad: 0.0 };
        assert!(plan(&scene, start).unwrap().entry.is_none(), "tried, and it passes every check");
        scene.method.straight_in = StraightIn::Thresholds { heading_rad: 0.1, offset_m: 0.1 };
        assert!(plan(&scene, start).is_ok_and(|plan| plan.entry.is_some()), "beyond the thresholds: by the circle");
        scene.method.straight_in = StraightIn::Thresholds { heading_rad: 0.4, offset_m: 0.4 };
        assert!(plan(&scene, start).unwrap().entry.is_none());
        scene.method.straight_in = StraightIn::Tried(2.0);
        assert!(plan(&scene, start).unwrap_err().to_string().contains("allowed: 0 to 1.5"));
    }
}
