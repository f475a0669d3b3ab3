//! A manoeuvre from above: obstacles, outlines of the vehicle along the path, the path by direction of travel, and the driven path.

use crate::manoeuvre::{ManoeuvreTrace, TracePiece};
use crate::map::Gear;
use crate::report::scale::Scale;
use crate::report::svg::{Svg, num};

/// Room around the drawing [px].
const LEFT: f64 = 50.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 26.0;
const BELOW: f64 = 62.0;
/// Tallest drawing [px]; above that it is made narrower.
const TALLEST: f64 = 470.0;
/// Margin around the driven area [m].
const AROUND_M: f64 = 0.4;

type Point = [f64; 2];

/// The picture, at most `width` pixels wide, with `title` above it.
pub(crate) fn overhead(trace: &ManoeuvreTrace, id: &str, title: &str, width: f64) -> Svg {
    let view = view(trace);
    let [left, right, low, high] = view;
    let scale = ((width - LEFT - RIGHT) / (right - left)).min(TALLEST / (high - low));
    // the names of the lines need room
    let width = (LEFT + RIGHT + scale * (right - left)).max(350.0);
    let right = left + (width - LEFT - RIGHT) / scale;
    let view = [left, right, low, high];
    let height = TOP + scale * (high - low) + BELOW;
    let mut svg = Svg::new(id, &format!("{}: {} from above", trace.verdict.name, trace.verdict.what), width, height);
    let sx = Scale::new(left, right, LEFT, width - RIGHT);
    let sy = Scale::new(low, high, height - BELOW, TOP);
    let at = |p: &Point| (sx.at(p[0]), sy.at(p[1]));
    svg.text(LEFT, 16.0, "t", title);
    let bottom = height - BELOW;
    let (ticks, digits) = sx.ticks((width / 60.0).clamp(3.0, 12.0));
    for t in ticks {
        svg.line((sx.at(t), TOP), (sx.at(t), bottom), "g");
        svg.text(sx.at(t), bottom + 16.0, "c", &num(t, digits));
    }
    let (ticks, digits) = sy.ticks(((bottom - TOP) / 40.0).clamp(2.0, 10.0));
    for t in ticks {
        svg.line((LEFT, sy.at(t)), (width - RIGHT, sy.at(t)), "g");
        svg.text(LEFT - 7.0, sy.at(t) + 4.0, "e", &num(t, digits));
    }
    svg.text(0.5 * (LEFT + width - RIGHT), bottom + 33.0, "c m", "x [m]");
    svg.upward(14.0, 0.5 * (TOP + bottom), "y [m]");

    let area = |svg: &mut Svg, corners: &[Point], class: &str| {
        let inside: Vec<(f64, f64)> = clipped(corners, view).iter().map(at).collect();
        svg.band(&inside, &[], class);
    };
    area(&mut svg, &trace.field_m, "field");
    for obstacle in &trace.obstacles_m {
        area(&mut svg, obstacle, "wall");
    }
    let last = trace.outlines.len().saturating_sub(1);
    for (k, outline) in trace.outlines.iter().enumerate() {
        let (fill, line) = colours(outline.gear);
        area(&mut svg, &outline.points_m, &format!("{fill} faint {line}{}", if k == last { " end" } else { "" }));
    }
    let along = |svg: &mut Svg, points: &[Point], class: &str| svg.polyline(&points.iter().map(at).collect::<Vec<_>>(), class);
    for piece in &trace.planned {
        along(&mut svg, &piece.points_m, &format!("l wide {}", colours(piece.gear).1));
    }
    along(&mut svg, &trace.driven_m, "l k d thin");
    if let Some(start) = trace.driven_m.first() {
        let (x, y) = at(start);
        svg.dot(x, y, 3.5, "kf");
    }
    key(&mut svg, &trace.planned, bottom + 52.0);
    svg
}

/// Legend of the lines, below the picture.
fn key(svg: &mut Svg, planned: &[TracePiece], y: f64) {
    let gears: Vec<Gear> = Gear::ALL.into_iter().filter(|g| planned.iter().any(|p| p.gear == *g)).collect();
    let lines = gears.iter().map(|g| (format!("l wide {}", colours(*g).1), format!("planned, {g}")));
    let mut x = LEFT;
    for (class, text) in lines.chain([("l k d thin".to_owned(), "driven (dot: start)".to_owned())]) {
        svg.line((x, y - 4.0), (x + 22.0, y - 4.0), &class);
        svg.text(x + 28.0, y, "m", &text);
        x += 28.0 + 6.3 * text.chars().count() as f64 + 12.0;
    }
}

/// Class of an area and of a line of a direction of travel.
fn colours(gear: Gear) -> (&'static str, &'static str) {
    match gear {
        Gear::Forward => ("af", "a"),
        Gear::Reverse => ("bf", "b"),
    }
}

/// The view [m]: left, right, low, high.
fn view(trace: &ManoeuvreTrace) -> [f64; 4] {
    let points = trace.planned.iter().chain(&trace.outlines).flat_map(|p| &p.points_m).chain(&trace.driven_m).chain(&trace.field_m);
    let start = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
    let [left, right, low, high] = points
        .filter(|p| p.iter().all(|c| c.is_finite()))
        .fold(start, |v, p| [v[0].min(p[0]), v[1].max(p[0]), v[2].min(p[1]), v[3].max(p[1])]);
    if left > right {
        return [0.0, 1.0, 0.0, 1.0];
    }
    // a path along a line still has a height
    let wide = (right - left).max(1.0);
    let high = high.max(low + 0.05 * wide);
    [left - AROUND_M, right + AROUND_M, low - AROUND_M, high + AROUND_M]
}

/// The part of a polygon within the view. Source: Sutherland & Hodgman (1974).
fn clipped(corners: &[Point], [left, right, low, high]: [f64; 4]) -> Vec<Point> {
    let mut inside = corners.to_vec();
    for (axis, limit, sign) in [(0, left, 1.0), (0, right, -1.0), (1, low, 1.0), (1, high, -1.0)] {
        let within = |p: &Point| sign * (p[axis] - limit) >= 0.0;
        let all = std::mem::take(&mut inside);
        for (k, to) in all.iter().enumerate() {
            let from = &all[(k + all.len() - 1) % all.len()];
            if within(from) != within(to) {
                let share = (limit - from[axis]) / (to[axis] - from[axis]);
                inside.push([from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]);
            }
            if within(to) {
                inside.push(*to);
            }
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polygon_is_cut_at_the_view() {
        let view = [0.0, 2.0, 0.0, 1.0];
        assert_eq!(clipped(&[[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]], view).len(), 4);
        assert!(clipped(&[[3.0, 3.0], [4.0, 3.0], [4.0, 4.0]], view).is_empty());
        let cut = clipped(&[[1.0, 0.5], [3.0, 0.5], [3.0, 0.75]], view);
        assert!(cut.iter().all(|p| p[0] <= 2.0) && cut.contains(&[2.0, 0.5]) && cut.contains(&[2.0, 0.625]), "{cut:?}");
    }
}
