//! Waypoints along the front wheel's arc, and the point of them that is nearest to the wheel.
//!
//! The search starts at the wheel's last place, goes forward only, and stops when the distance grows: a full turn ends where it began, and
//! its end must not be taken for its start.

/// Largest number of waypoints of a path: 10 m of arc every 0.02 m, a full turn with a wheelbase of 1.6 m.
pub(crate) const MAX_WAYPOINTS: usize = 512;

/// A point of the path with the speed planned there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Waypoint {
    /// East of the origin [m].
    pub x_m: f64,
    /// North of the origin [m].
    pub y_m: f64,
    /// Arc length from the start [m].
    pub arc_m: f64,
    /// Planned front-wheel speed [m/s], gear frame.
    pub speed_mps: f64,
}

/// Method of locating the wheel on the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Nearest {
    /// The nearest waypoint.
    Waypoint,
    /// The foot of the perpendicular on the path's nearest piece. Default: the desired acceleration has no steps.
    #[default]
    Projection,
}

/// Waypoints in the order of travel; storage is inside, nothing is allocated.
#[derive(Clone, PartialEq)]
pub struct Path {
    points: [Waypoint; MAX_WAYPOINTS],
    count: usize,
}

/// A place on the path, kept from one period to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Place {
    /// Index of the waypoint at or before the wheel.
    pub index: usize,
    /// Arc length of the wheel [m].
    pub arc_m: f64,
}

impl core::fmt::Debug for Path {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Path of {} waypoints over {} m", self.count, self.length_m())
    }
}

impl Default for Path {
    fn default() -> Self {
        Self { points: [Waypoint::default(); MAX_WAYPOINTS], count: 0 }
    }
}

impl Path {
    /// Adds a waypoint; `false` when the path is full.
    pub fn push(&mut self, point: Waypoint) -> bool {
        match self.points.get_mut(self.count) {
            Some(place) => {
                *place = point;
                self.count += 1;
                true
            }
            None => false,
        }
    }

    /// The waypoints in the order of travel.
    pub fn waypoints(&self) -> &[Waypoint] {
        self.points.get(..self.count).unwrap_or(&[])
    }

    /// Length of the arc [m]; 0 without waypoints.
    pub fn length_m(&self) -> f64 {
        self.waypoints().last().map_or(0.0, |p| p.arc_m)
    }

    /// Place on the path of the wheel at (`x_m`, `y_m`), searched from its last place: never before `from`.
    pub fn locate(&self, nearest: Nearest, x_m: f64, y_m: f64, from: Place) -> Place {
        let points = self.waypoints();
        let distance =
            |index: usize| points.get(index).map_or(f64::INFINITY, |p| (p.x_m - x_m) * (p.x_m - x_m) + (p.y_m - y_m) * (p.y_m - y_m));
        let mut index = from.index;
        while distance(index + 1) < distance(index) {
            index += 1;
        }
        let arc_at = |index: usize| points.get(index).map_or(from.arc_m, |p| p.arc_m);
        match nearest {
            Nearest::Waypoint => Place { index, arc_m: arc_at(index).max(from.arc_m) },
            Nearest::Projection => {
                // the foot lies on the piece before the nearest waypoint or on the one after it
                let first = index.saturating_sub(1);
                let foot = |start: usize| -> Option<f64> {
                    let (p, q) = (points.get(start)?, points.get(start + 1)?);
                    let (dx, dy) = (q.x_m - p.x_m, q.y_m - p.y_m);
                    let fraction = ((x_m - p.x_m) * dx + (y_m - p.y_m) * dy) / (dx * dx + dy * dy);
                    Some(p.arc_m + fraction.clamp(0.0, 1.0) * (q.arc_m - p.arc_m))
                };
                let here = arc_at(index);
                let before = foot(first).unwrap_or(here);
                let after = foot(index).unwrap_or(here);
                let arc_m = if after > here { after } else { before };
                let arc_m = if arc_m.is_finite() { arc_m } else { from.arc_m };
                Place { index, arc_m: arc_m.max(from.arc_m) }
            }
        }
    }

    /// Arc length of the foot of the perpendicular from (`x_m`, `y_m`) near `place` [m]. It may lie behind it, since noise has both signs.
    pub fn foot_m(&self, x_m: f64, y_m: f64, place: Place) -> f64 {
        self.locate(Nearest::Projection, x_m, y_m, Place { index: place.index.saturating_sub(2), arc_m: 0.0 }).arc_m
    }

    /// Planned speed [m/s] at `arc_m`, linear between waypoints; the last waypoint's past the end. `hint` is an index at or before it.
    pub fn speed_at(&self, arc_m: f64, hint: usize) -> f64 {
        let points = self.waypoints();
        let mut index = hint.saturating_sub(1);
        while points.get(index + 1).is_some_and(|p| p.arc_m < arc_m) {
            index += 1;
        }
        match (points.get(index), points.get(index + 1)) {
            (Some(p), Some(q)) if q.arc_m > p.arc_m => {
                let fraction = ((arc_m - p.arc_m) / (q.arc_m - p.arc_m)).clamp(0.0, 1.0);
                p.speed_mps + fraction * (q.speed_mps - p.speed_mps)
            }
            (Some(p), _) => p.speed_mps,
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A full circle of radius 1 m in 100 pieces: it ends where it begins.
    fn circle() -> Path {
        let mut path = Path::default();
        for k in 0..=100 {
            let angle = f64::from(k) * core::f64::consts::TAU / 100.0;
            assert!(path.push(Waypoint { x_m: angle.cos(), y_m: angle.sin(), arc_m: angle, speed_mps: angle }));
        }
        path
    }

    #[test]
    fn the_end_of_a_full_turn_is_not_taken_for_its_start() {
        let path = circle();
        for nearest in [Nearest::Waypoint, Nearest::Projection] {
            let mut place = path.locate(nearest, 1.0, 0.0, Place::default());
            assert_eq!(place.index, 0);
            for k in 0..=1000 {
                let angle = f64::from(k) * core::f64::consts::TAU / 1000.0;
                place = path.locate(nearest, angle.cos(), angle.sin(), place);
                // a waypoint is at most half a piece away, a foot on a chord at most the piece's sagitta
                let bound = if nearest == Nearest::Waypoint { 0.032 } else { 1e-4 };
                assert!((place.arc_m - angle).abs() < bound, "{nearest:?} {angle} {}", place.arc_m);
            }
            assert!((place.arc_m - path.length_m()).abs() < 1e-9);
        }
    }

    #[test]
    fn a_full_path_takes_no_more() {
        let mut path = Path::default();
        assert!((0..MAX_WAYPOINTS).all(|_| path.push(Waypoint::default())));
        assert!(!path.push(Waypoint::default()));
    }

    proptest! {
        #[test]
        fn the_place_never_runs_backwards_wherever_the_wheel_seems_to_be(
            points in prop::collection::vec((any::<f64>(), -2.0..2.0f64), 1..50)
        ) {
            let path = circle();
            for nearest in [Nearest::Waypoint, Nearest::Projection] {
                let mut place = Place::default();
                for &(x, y) in &points {
                    let next = path.locate(nearest, x, y, place);
                    prop_assert!(next.index >= place.index && next.arc_m >= place.arc_m && next.arc_m <= path.length_m());
                    let _ = path.speed_at(x, next.index);
                    place = next;
                }
            }
        }
    }
}
