//! The nearest point of a reference path that is logged whole, as the run-time law would have matched it.
//!
//! The polyline in force is the latest before the pose's time. The nearest point is the foot of the perpendicular on its segments, or a corner. It is
//! sought around the last one, so that another branch of a path that crosses itself or comes back does not catch it; only at first, and when it
//! has been lost, along the whole polyline, and then on segments that run along the vehicle's axis.

use crate::log::ReferencePath;

/// Way along the path, to either side of the last point, that is searched [m]: some ten periods of a sweeper's way.
const WINDOW_M: f64 = 1.5;
/// Nearer than this a point in the window counts as found [m].
const FOUND_M: f64 = 1.0;
/// A pose further than this from its path is none of that path's [m].
const FAR_M: f64 = 2.0;
/// cos of the largest angle between the vehicle's axis and a segment that it may be on: 60°.
const ALONG: f64 = 0.5;

/// Matches poses at ascending times.
#[derive(Debug, Clone)]
pub(crate) struct NearestPoint<'a> {
    paths: &'a [ReferencePath],
    /// The first path that is not yet in force.
    next: usize,
    /// Segment of the last match.
    segment: Option<usize>,
}

/// A point on a segment.
#[derive(Debug, Clone, Copy)]
struct Foot {
    segment: usize,
    distance_m: f64,
    point_m: [f64; 2],
}

impl<'a> NearestPoint<'a> {
    /// `paths`: sorted by time.
    pub(crate) fn new(paths: &'a [ReferencePath]) -> Self {
        Self { paths, next: 0, segment: None }
    }

    /// The nearest point of the path in force; `None` before the first, on a path of fewer than two points, or too far from it.
    pub(crate) fn at(&mut self, time_ns: i64, place_m: [f64; 2], yaw_rad: f64) -> Option<[f64; 2]> {
        while self.paths.get(self.next).is_some_and(|path| path.time_ns <= time_ns) {
            self.next += 1;
            self.segment = None;
        }
        let points = &self.paths[self.next.checked_sub(1)?].points_m[..];
        let near = self.segment.and_then(|last| around(points, last, place_m)).filter(|foot| foot.distance_m <= FOUND_M);
        let foot = near.or_else(|| anywhere(points, place_m, yaw_rad)).filter(|foot| foot.distance_m <= FAR_M);
        self.segment = foot.map(|foot| foot.segment);
        foot.map(|foot| foot.point_m)
    }
}

/// The foot on one segment; `None` where it has no length.
fn foot(points: &[[f64; 2]], segment: usize, [x, y]: [f64; 2]) -> Option<Foot> {
    let (from, to) = (points.get(segment)?, points.get(segment + 1)?);
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let square = dx * dx + dy * dy;
    let share = ((x - from[0]) * dx + (y - from[1]) * dy) / square;
    if !share.is_finite() {
        return None;
    }
    let share = share.clamp(0.0, 1.0);
    let point_m = [from[0] + share * dx, from[1] + share * dy];
    Some(Foot { segment, distance_m: (x - point_m[0]).hypot(y - point_m[1]), point_m })
}

/// The nearest foot around the last match.
fn around(points: &[[f64; 2]], last: usize, place_m: [f64; 2]) -> Option<Foot> {
    let length = |k: usize| points.get(k + 1).map_or(0.0, |to| (to[0] - points[k][0]).hypot(to[1] - points[k][1]));
    let mut best = foot(points, last, place_m);
    let mut keep = |found: Option<Foot>| {
        if let Some(found) = found
            && best.is_none_or(|best| found.distance_m < best.distance_m)
        {
            best = Some(found);
        }
    };
    let mut way_m = 0.0;
    for segment in last + 1..points.len().saturating_sub(1) {
        keep(foot(points, segment, place_m));
        way_m += length(segment);
        if way_m > WINDOW_M {
            break;
        }
    }
    way_m = 0.0;
    for segment in (0..last).rev() {
        keep(foot(points, segment, place_m));
        way_m += length(segment);
        if way_m > WINDOW_M {
            break;
        }
    }
    best
}

/// The nearest foot on the whole polyline, on segments along the vehicle's axis.
fn anywhere(points: &[[f64; 2]], place_m: [f64; 2], yaw_rad: f64) -> Option<Foot> {
    let (sin, cos) = yaw_rad.sin_cos();
    let along = |k: &usize| {
        let (dx, dy) = (points[k + 1][0] - points[*k][0], points[k + 1][1] - points[*k][1]);
        (dx * cos + dy * sin).abs() >= ALONG * dx.hypot(dy)
    };
    let feet = (0..points.len().saturating_sub(1)).filter(along).filter_map(|k| foot(points, k, place_m));
    feet.min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(time_ns: i64, points_m: &[[f64; 2]]) -> ReferencePath {
        ReferencePath { time_ns, points_m: points_m.to_vec() }
    }

    #[test]
    fn the_latest_path_before_the_pose_counts() {
        let paths = [path(10, &[[0.0, 0.0], [5.0, 0.0]]), path(20, &[]), path(30, &[[0.0, 1.0], [5.0, 1.0]])];
        let mut nearest = NearestPoint::new(&paths);
        assert_eq!(nearest.at(9, [1.0, 0.5], 0.0), None);
        assert_eq!(nearest.at(10, [1.0, 0.5], 0.0), Some([1.0, 0.0]));
        assert_eq!(nearest.at(20, [1.0, 0.5], 0.0), None, "an empty path takes the last one back");
        assert_eq!(nearest.at(35, [1.0, 0.5], 0.0), Some([1.0, 1.0]));
        assert_eq!(nearest.at(36, [1.0, 9.0], 0.0), None, "too far away to be on it");
    }

    #[test]
    fn where_a_path_crosses_itself_the_branch_that_is_driven_counts() {
        // east, around, and south across the first branch at x = 5
        let loop_m = [[0.0, 0.0], [10.0, 0.0], [10.0, 5.0], [5.0, 5.0], [5.0, -5.0]];
        let paths = [path(0, &loop_m)];
        let mut nearest = NearestPoint::new(&paths);
        for k in 0..100 {
            let x = 0.1 * f64::from(k);
            // 4 cm left of the branch; the other one is nearer for x within 4 cm of 5
            let found = nearest.at(i64::from(k), [x, 0.04], 0.0);
            assert!(found.is_some_and(|p| (p[0] - x).abs() < 1e-12 && p[1] == 0.0), "{x}: {found:?}");
        }
        // seen for the first time at the crossing, the heading decides
        let south = NearestPoint::new(&paths).at(1, [5.03, 0.0], -1.5);
        assert!(south.is_some_and(|p| p[0] == 5.0), "{south:?}");
    }

    #[test]
    fn repeated_points_and_ends_are_no_harm() {
        let paths = [path(0, &[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]), path(50, &[[3.0, 3.0], [3.0, 3.0]])];
        let mut nearest = NearestPoint::new(&paths);
        assert_eq!(nearest.at(1, [1.4, 0.1], 0.0), Some([1.0, 0.0]), "beyond the end: the end");
        assert_eq!(nearest.at(60, [3.0, 3.0], 0.0), None, "no segment has a length");
    }
}
