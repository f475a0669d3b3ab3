//! The solution space: the field's quadrangle, the obstacles in it, the lane lines, and the distances of a track from them.

use crate::guidance::geometry::{PlanePoint, Polygon};
use crate::guidance::u_turn::track::UTurnTrack;
use serde::Serialize;

/// Scene of a U-turn. The vehicle starts with its control point at the origin and heads along y.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UTurnScene {
    /// The body stays inside.
    pub field: Polygon,
    /// The body stays outside.
    pub obstacles: Vec<Polygon>,
    /// Lane lines of the return from the inner to the outer one, each from its far to its near end; the vehicle may cross them, and ends
    /// between them.
    pub lines: Vec<(PlanePoint, PlanePoint)>,
    /// Distance that the body keeps from border and obstacles [m].
    pub clearance_m: f64,
}

/// Lane in which a track ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Lane {
    /// In the lane of this number, from 0 beside the obstacle outward.
    Number(usize),
    /// On a line.
    Straddling,
}

/// Least distances of a track's body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// Distance from the field's border, negative outside [m].
    pub border_m: f64,
    /// Distance from the obstacles, negative inside [m]; infinite without any.
    pub obstacle_m: f64,
    /// At the end, from the lane lines [m]: negative when it is on one; infinite without any.
    pub line_m: f64,
}

impl Margins {
    /// The smaller of the distances from border and obstacles [m].
    pub fn smallest_m(&self) -> f64 {
        self.border_m.min(self.obstacle_m)
    }
}

impl UTurnScene {
    /// Margins of a track moved by `shift_m` along its run-up, evaluated at every `every`-th state of the turn, its last, and the start.
    pub fn margins(&self, track: &UTurnTrack, shift_m: f64, every: usize) -> Margins {
        let from = track.turn_from();
        let turning = track.states[from..].iter().step_by(every.max(1)).chain(track.states.last());
        let mut margins = Margins { border_m: f64::INFINITY, obstacle_m: f64::INFINITY, line_m: f64::INFINITY };
        let mut look = |body: &Polygon| {
            margins.border_m = margins.border_m.min(self.field.inside_margin_m(body));
            for obstacle in &self.obstacles {
                margins.obstacle_m = margins.obstacle_m.min(obstacle.separation_m(body));
            }
        };
        look(&track.body(&track.states[0]));
        for state in turning {
            let mut moved = *state;
            moved.y_m += shift_m;
            look(&track.body(&moved));
        }
        let (_, line_m) = self.lane(track, shift_m);
        Margins { line_m, ..margins }
    }

    /// The lane in which the moved track ends, and the distance of the body from the nearest line (negative on it).
    pub fn lane(&self, track: &UTurnTrack, shift_m: f64) -> (Lane, f64) {
        let mut end = track.end();
        end.y_m += shift_m;
        let body = track.body(&end);
        let (mut number, mut straddling, mut nearest_m) = (0, false, f64::INFINITY);
        for line in &self.lines {
            let (near, far) = beyond_m(*line, &body);
            // far: distance of the body's inner side past the line; near: of its outer side
            let gap = if near > 0.0 { near } else { -far };
            number += usize::from(near > 0.0);
            straddling |= gap <= 0.0;
            nearest_m = nearest_m.min(gap);
        }
        (if straddling { Lane::Straddling } else { Lane::Number(number) }, nearest_m)
    }
}

/// Least and largest distance of the body's corners beyond a line, outward positive: to the right of the way from its far to its near end.
pub fn beyond_m(line: (PlanePoint, PlanePoint), body: &Polygon) -> (f64, f64) {
    let (far, near) = line;
    let length = far.distance_m(near);
    body.corners().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| {
        let right = ((near.y_m - far.y_m) * (c.x_m - far.x_m) - (near.x_m - far.x_m) * (c.y_m - far.y_m)) / length;
        (low.min(right), high.max(right))
    })
}
