//! Charts of lines over a common axis, one panel above the other.

use crate::report::scale::Scale;
use crate::report::svg::{Svg, num};

/// Room around the panels [px].
const LEFT: f64 = 56.0;
const RIGHT: f64 = 14.0;
const TITLE: f64 = 24.0;
const GAP: f64 = 30.0;
const BELOW: f64 = 40.0;

/// Points (x, y).
pub(crate) type Points = Vec<(f64, f64)>;

/// One line: classes `a`, `b`, `k` are the page's colours, `d` is dashed.
pub(crate) struct Line {
    pub(crate) name: &'static str,
    pub(crate) class: &'static str,
    pub(crate) points: Points,
}

/// An area between two lines: classes `af`, `bf` are colours, `o` is faint, `p` is stronger.
pub(crate) struct Area {
    pub(crate) class: &'static str,
    pub(crate) lower: Points,
    pub(crate) upper: Points,
}

/// One panel.
#[derive(Default)]
pub(crate) struct Panel {
    pub(crate) title: String,
    pub(crate) areas: Vec<Area>,
    pub(crate) lines: Vec<Line>,
    /// Single points with their class and radius.
    pub(crate) dots: Vec<(f64, f64, &'static str, f64)>,
    /// Straight lines across at this value, with what they mean.
    pub(crate) levels: Vec<(f64, String)>,
    /// Whether zero is on the axis.
    pub(crate) with_zero: bool,
    /// Top of the axis; what is above is cut off.
    pub(crate) most: Option<f64>,
}

/// Panels over a common axis.
pub(crate) struct Chart {
    pub(crate) id: String,
    pub(crate) label: String,
    pub(crate) x_title: &'static str,
    pub(crate) width: f64,
    pub(crate) panel: f64,
    pub(crate) panels: Vec<Panel>,
}

impl Chart {
    /// The picture.
    pub(crate) fn draw(&self) -> Svg {
        let count = self.panels.len() as f64;
        let height = TITLE + count * self.panel + (count - 1.0) * GAP + BELOW;
        let mut svg = Svg::new(&self.id, &self.label, self.width, height);
        let xs = || {
            self.panels.iter().flat_map(|p| {
                let lines = p.lines.iter().flat_map(|l| l.points.iter().map(|p| p.0));
                lines.chain(p.areas.iter().flat_map(|a| a.lower.iter().map(|p| p.0))).chain(p.dots.iter().map(|d| d.0))
            })
        };
        let (low, high) = xs().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let sx = Scale::new(low, high, LEFT, self.width - RIGHT);
        for (k, panel) in self.panels.iter().enumerate() {
            let top = TITLE + k as f64 * (self.panel + GAP);
            self.draw_panel(&mut svg, panel, &sx, top);
        }
        let bottom = height - BELOW;
        let (ticks, digits) = sx.ticks(9.0);
        for t in ticks {
            svg.text(sx.at(t), bottom + 16.0, "c", &num(t, digits));
        }
        svg.text(0.5 * (LEFT + self.width - RIGHT), bottom + 33.0, "c m", self.x_title);
        svg
    }

    fn draw_panel(&self, svg: &mut Svg, panel: &Panel, sx: &Scale, top: f64) {
        let bottom = top + self.panel;
        let values = panel.lines.iter().flat_map(|l| l.points.iter().map(|p| p.1));
        let values = values.chain(panel.areas.iter().flat_map(|a| a.lower.iter().chain(&a.upper).map(|p| p.1)));
        let values = values.chain(panel.dots.iter().map(|d| d.1)).chain(panel.levels.iter().map(|l| l.0));
        let most = panel.most.unwrap_or(f64::INFINITY);
        let sy = Scale::over(values.map(|v| v.min(most)), panel.with_zero, bottom, top);
        let place = |points: &Points| -> Points { points.iter().map(|p| (sx.at(p.0), sy.at(p.1.clamp(sy.low, sy.high)))).collect() };
        svg.text(LEFT, top - 8.0, "t", &panel.title);
        let (ticks, digits) = sy.ticks((self.panel / 26.0).clamp(2.0, 6.0));
        for t in ticks {
            svg.line((LEFT, sy.at(t)), (self.width - RIGHT, sy.at(t)), "g");
            svg.text(LEFT - 7.0, sy.at(t) + 4.0, "e", &num(t, digits));
        }
        for t in sx.ticks(9.0).0 {
            svg.line((sx.at(t), bottom), (sx.at(t), bottom + 4.0), "x");
        }
        if sy.low < 0.0 && sy.high > 0.0 {
            svg.line((LEFT, sy.at(0.0)), (self.width - RIGHT, sy.at(0.0)), "x");
        }
        for (value, text) in &panel.levels {
            svg.line((LEFT, sy.at(*value)), (self.width - RIGHT, sy.at(*value)), "x d");
            svg.text(self.width - RIGHT - 4.0, sy.at(*value) - 4.0, "e m", text);
        }
        for area in &panel.areas {
            svg.band(&place(&area.lower), &place(&area.upper), area.class);
        }
        for line in &panel.lines {
            svg.polyline(&place(&line.points), &format!("l {}", line.class));
        }
        for (x, y, class, radius) in &panel.dots {
            svg.dot(sx.at(*x), sy.at(y.clamp(sy.low, sy.high)), *radius, class);
        }
        // names of the lines, right of the title
        let mut x = self.width - RIGHT;
        for line in panel.lines.iter().rev().filter(|l| !l.name.is_empty()) {
            svg.text(x, top - 8.0, "e m", line.name);
            x -= 7.0 * line.name.chars().count() as f64 + 14.0;
            svg.line((x - 18.0, top - 12.0), (x, top - 12.0), &format!("l {}", line.class));
            x -= 30.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(panels: Vec<Panel>) -> String {
        Chart { id: "c".to_owned(), label: "l".to_owned(), x_title: "t [s]", width: 570.0, panel: 100.0, panels }.draw().file()
    }

    fn line(name: &'static str, points: Points) -> Line {
        Line { name, class: "a", points }
    }

    #[test]
    fn what_lies_above_the_top_of_the_axis_is_drawn_at_the_top() {
        let points = vec![(0.0, 0.0), (1.0, 50.0), (2.0, 10.0)];
        // 500 px from 0 to 2 s, 100 px from 10 at the top to 0
        let cut = drawn(vec![Panel { lines: vec![line("", points.clone())], with_zero: true, most: Some(10.0), ..Panel::default() }]);
        assert!(cut.contains("d=\"M56 124L306 24L556 24\""), "{cut}");
        let whole = drawn(vec![Panel { lines: vec![line("", points)], with_zero: true, ..Panel::default() }]);
        assert!(whole.contains("d=\"M56 124L306 24L556 104\""), "{whole}");
    }

    #[test]
    fn panels_share_the_range_of_all_their_lines() {
        let short = Panel { lines: vec![line("", vec![(0.0, 0.0), (1.0, 1.0)])], ..Panel::default() };
        let long = Panel { lines: vec![line("", vec![(2.0, 0.0), (4.0, 1.0)])], ..Panel::default() };
        let both = drawn(vec![short, long]);
        assert!(both.contains("d=\"M56 124L181 24\"") && both.contains("d=\"M306 254L556 154\""), "{both}");
    }

    #[test]
    fn a_chart_without_points_is_still_a_picture() {
        let empty = drawn(vec![Panel::default()]);
        assert!(!empty.contains("NaN") && !empty.contains("inf") && empty.contains(">t [s]</text>"), "{empty}");
    }
}
