//! A planned path from above as SVG: field, obstacles, bodies along the path, the planned path and, over it, the driven path.

use crate::guidance::{PathPose, Polygon};
use crate::manoeuvre::planned_task::Planned;
use crate::map::Gear;
use std::fmt::Write as _;

/// Room around the drawing [px].
const EDGE: f64 = 24.0;

/// A picture `width` pixels wide, showing y from `low_m` to `high_m` and x from `left_m` to `right_m`. `driven`: true places of the rear axle's middle.
pub fn picture(planned: &Planned, driven: &[(f64, f64)], view: [f64; 4], width: f64, title: &str) -> String {
    let [left_m, right_m, low_m, high_m] = view;
    let scale = (width - 2.0 * EDGE) / (right_m - left_m);
    let height = scale * (high_m - low_m) + 2.0 * EDGE + 20.0;
    let at = |x: f64, y: f64| (EDGE + scale * (x - left_m), EDGE + 20.0 + scale * (high_m - y));
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{EDGE}\" y=\"20\" font-weight=\"bold\">{title}</text>\n\
         <clipPath id=\"view\"><rect x=\"{EDGE}\" y=\"{top}\" width=\"{w:.1}\" height=\"{h:.1}\"/></clipPath>\n<g clip-path=\"url(#view)\">\n",
        top = EDGE + 20.0,
        w = width - 2.0 * EDGE,
        h = scale * (high_m - low_m),
    );
    let shape = |text: &mut String, polygon: &Polygon, style: &str| {
        let points: Vec<_> = polygon.corners().iter().map(|c| at(c.x_m, c.y_m)).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(text, "<polygon points=\"{}\" {style}/>", points.join(" "));
    };
    if let Some(field) = &planned.field {
        shape(&mut text, field, "fill=\"#f7f7f7\" stroke=\"#444\" stroke-width=\"2\"");
    }
    for obstacle in &planned.obstacles {
        shape(&mut text, obstacle, "fill=\"#c9c9c9\" stroke=\"#666\"");
    }
    let poses = &planned.path.poses;
    let every = (poses.len() / 14).max(1);
    for (k, pose) in poses.iter().enumerate() {
        let last = k + 1 == poses.len();
        if k % every == 0 || last {
            let colour = if pose.direction == Gear::Forward { "#1f6fb4" } else { "#d9641e" };
            let style = if last { "stroke-width=\"2.5\"" } else { "stroke-opacity=\"0.45\"" };
            shape(&mut text, &planned.body.at_pose(pose), &format!("fill=\"{colour}\" fill-opacity=\"0.04\" stroke=\"{colour}\" {style}"));
        }
    }
    let mut from = 0;
    while from + 1 < poses.len() {
        let gear = poses[from].direction;
        let to = poses[from..].iter().position(|p| p.direction != gear).map_or(poses.len() - 1, |k| from + k);
        let colour = if gear == Gear::Forward { "#1f6fb4" } else { "#d9641e" };
        let line = polyline(poses[from..=to].iter().map(|p: &PathPose| at(p.x_m, p.y_m)));
        let _ = writeln!(text, "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" points=\"{line}\"/>");
        from = to.max(from + 1);
    }
    let line = polyline(driven.iter().map(|&(x, y)| at(x, y)));
    let _ = writeln!(text, "<polyline fill=\"none\" stroke=\"black\" stroke-width=\"1\" stroke-dasharray=\"5 3\" points=\"{line}\"/>");
    text.push_str("</g>\n</svg>");
    text
}

fn polyline(points: impl Iterator<Item = (f64, f64)>) -> String {
    points.map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}
