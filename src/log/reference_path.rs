//! The reference path of the lateral calibration, from messages with a complete polyline, such as `nav_msgs/Path`.
//!
//! `reference_x = { path = "/path.poses[:].pose.position.x" }` and the corresponding `reference_y` give one polyline per message. A path
//! that is published repeatedly without a change is kept once.

use crate::log::signal_map::{SignalMap, SignalName};
use crate::log::{Error, Result};
use std::collections::BTreeSet;

/// A polyline of one message; it is valid from its time until the next.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReferencePath {
    /// Time of the message [ns since the epoch of the stamps].
    pub time_ns: i64,
    /// Its points [m], finite.
    pub points_m: Vec<[f64; 2]>,
}

/// Lists of numbers, one per message, in the order of the log.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Lists {
    /// Time, first value and number of values of each message.
    messages: Vec<(i64, usize, usize)>,
    values: Vec<f64>,
}

impl Lists {
    /// Adds a message's list. A list equal to the last one needs no memory.
    pub(crate) fn push(&mut self, time_ns: i64, list: impl ExactSizeIterator<Item = f64> + Clone) {
        let count = list.len();
        if let Some(&(_, from, last)) = self.messages.last() {
            let same = last == count && self.values[from..from + last].iter().zip(list.clone()).all(|(a, b)| a.to_bits() == b.to_bits());
            if same {
                self.messages.push((time_ns, from, count));
                return;
            }
        }
        self.messages.push((time_ns, self.values.len(), count));
        self.values.extend(list);
    }

    /// Adds the lists of the next section of the log.
    pub(crate) fn append(&mut self, next: Self) {
        let before = self.values.len();
        self.messages.extend(next.messages.into_iter().map(|(time_ns, from, count)| (time_ns, from + before, count)));
        self.values.extend(next.values);
    }

    /// Number of values; unchanged messages are counted once.
    pub(crate) fn len(&self) -> usize {
        self.values.len()
    }
}

/// The polylines with the coordinates `x` and `y`, sorted by time, without repetitions. Points that are not finite are skipped.
pub(crate) fn polylines(x: &Lists, y: &Lists) -> Vec<ReferencePath> {
    let mut paths: Vec<ReferencePath> = Vec::new();
    let mut last: Option<[usize; 4]> = None;
    for (&(time_ns, x_from, x_count), &(_, y_from, y_count)) in x.messages.iter().zip(&y.messages) {
        let place = [x_from, x_count, y_from, y_count];
        if last.replace(place) == Some(place) {
            continue;
        }
        let points = x.values[x_from..x_from + x_count].iter().zip(&y.values[y_from..y_from + y_count]);
        let points_m = points.map(|(x, y)| [*x, *y]).filter(|point| point.iter().all(|c| c.is_finite())).collect();
        paths.push(ReferencePath { time_ns, points_m });
    }
    paths.sort_by_key(|path| path.time_ns);
    paths.dedup_by(|next, before| next.points_m == before.points_m);
    paths
}

/// Whether the reference is named as complete polylines.
///
/// # Errors
/// One coordinate is a list and the other a number, or the lists are from two topics.
pub(crate) fn is_named(map: &SignalMap) -> Result<bool> {
    let [x, y] = [SignalName::ReferenceX, SignalName::ReferenceY].map(|name| map.signals.get(&name).map(|spec| &spec.path));
    let (Some(x), Some(y)) = (x, y) else { return Ok(false) };
    match (x.is_list(), y.is_list()) {
        (true, true) if x.topic == y.topic => Ok(true),
        (false, false) => Ok(false),
        _ => Err(Error::HalfPath { x: x.to_string(), y: y.to_string() }),
    }
}

/// The topics of `pivot-cal lateral record` for its two forms of the reference.
const POINT_TOPIC: &str = "/reference/matched_point";
const PATH_TOPIC: &str = "/reference/path";

/// In a built-in map, replaces the matched point by the complete path if the log holds only the path.
pub(crate) fn instead_of_point(map: &mut SignalMap, topics: &BTreeSet<&str>) -> Result<()> {
    if topics.contains(POINT_TOPIC) || !topics.contains(PATH_TOPIC) {
        return Ok(());
    }
    for (name, coordinate) in [(SignalName::ReferenceX, "x"), (SignalName::ReferenceY, "y")] {
        if let Some(spec) = map.signals.get_mut(&name).filter(|spec| spec.path.topic == POINT_TOPIC) {
            spec.path = format!("{PATH_TOPIC}.poses[:].pose.position.{coordinate}").parse()?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn lists(messages: &[(i64, &[f64])]) -> Lists {
        let mut lists = Lists::default();
        for (time_ns, values) in messages {
            lists.push(*time_ns, values.iter().copied());
        }
        lists
    }

    #[test]
    fn an_unchanged_path_is_kept_once_and_another_with_one_coordinate_changed_is_not() {
        let x = lists(&[(1, &[0.0, 1.0]), (2, &[0.0, 1.0]), (3, &[0.0, 1.0]), (4, &[0.0, 2.0])]);
        let y = lists(&[(1, &[0.0, 0.0]), (2, &[0.0, 0.0]), (3, &[0.0, 5.0]), (4, &[0.0, 5.0])]);
        assert_eq!(x.len(), 4);
        let paths = polylines(&x, &y);
        assert_eq!(paths.iter().map(|p| p.time_ns).collect::<Vec<_>>(), [1, 3, 4]);
        assert_eq!(paths[1].points_m, [[0.0, 0.0], [1.0, 5.0]]);
    }

    #[test]
    fn sections_are_joined_and_sorted_by_time_and_broken_points_are_skipped() {
        let mut x = lists(&[(5, &[1.0, f64::NAN, 3.0])]);
        let mut y = lists(&[(5, &[1.0, 2.0, 3.0])]);
        x.append(lists(&[(2, &[7.0]), (9, &[])]));
        y.append(lists(&[(2, &[8.0]), (9, &[])]));
        let paths = polylines(&x, &y);
        assert_eq!(paths.iter().map(|p| (p.time_ns, p.points_m.len())).collect::<Vec<_>>(), [(2, 1), (5, 2), (9, 0)]);
    }

    #[test]
    fn both_coordinates_are_lists_of_one_topic_or_none_is() {
        let named = |x: &str, y: &str| {
            is_named(
                &SignalMap::from_toml(&format!("[signals]\nreference_x = {{ path = '{x}' }}\nreference_y = {{ path = '{y}' }}")).unwrap(),
            )
        };
        assert!(named("/p.poses[:].x", "/p.poses[:].y").unwrap());
        assert!(!named("/p.x", "/p.y").unwrap());
        assert!(named("/p.poses[:].x", "/p.y").is_err() && named("/p.poses[:].x", "/q.poses[:].y").is_err());
    }
}
