//! Heat maps: one coloured cell per node of a table, drawn to scale; hatching or dots over a cell show its status.

use crate::map::CellStatus;
use crate::report::scale::{Colours, Scale};
use crate::report::svg::{Svg, num, px};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Largest number of cells along an axis; larger tables are thinned out for drawing.
const MOST: usize = 64;
/// Room around the cells [px].
const LEFT: f64 = 56.0;
const TOP: f64 = 26.0;
const BAR: f64 = 78.0;
const BELOW: f64 = 62.0;

/// A quantity along an axis or in the cells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quantity {
    /// Its display name.
    pub(crate) name: &'static str,
    /// Its unit.
    pub(crate) unit: &'static str,
    /// Decimals shown.
    pub(crate) digits: usize,
}

/// A value per cell, by index along x and along y.
pub(crate) type Field<'a> = Box<dyn Fn(usize, usize) -> Option<f64> + 'a>;

/// The drawn quantity.
pub(crate) struct Heat<'a> {
    pub(crate) id: String,
    pub(crate) title: String,
    pub(crate) x: (Quantity, &'a [f64]),
    pub(crate) y: (Quantity, &'a [f64]),
    pub(crate) value: (Quantity, Field<'a>),
    /// Also shown when the pointer is on a cell.
    pub(crate) beside: Vec<(Quantity, Field<'a>)>,
    pub(crate) status: Option<Box<dyn Fn(usize, usize) -> CellStatus + 'a>>,
    pub(crate) colours: Colours,
    /// Values at the ends of the colour scale; `None` takes them from the cells.
    pub(crate) range: Option<(f64, f64)>,
    /// A line over the cells, x and y in the axes' units, with its name.
    pub(crate) curve: Option<(&'static str, Vec<(f64, f64)>)>,
    /// Whether the marks are explained below.
    pub(crate) legend: bool,
    /// A single point in the axes' units.
    pub(crate) dot: Option<(f64, f64)>,
    pub(crate) size: (f64, f64),
}

/// Letters of the statuses in the page's data.
fn letter(status: CellStatus) -> char {
    match status {
        CellStatus::Measured => 'm',
        CellStatus::Interpolated => 'i',
        CellStatus::Extrapolated => 'e',
        CellStatus::Unreachable => 'u',
    }
}

/// Indices of the breaks that are drawn.
fn kept(count: usize) -> Vec<usize> {
    let stride = count.div_ceil(MOST).max(1);
    let mut kept: Vec<usize> = (0..count).step_by(stride).collect();
    if kept.last().is_some_and(|k| k + 1 < count) {
        kept.push(count - 1);
    }
    kept
}

/// Borders of cells around `centres`.
fn borders(centres: &[f64]) -> Vec<f64> {
    let n = centres.len();
    if n < 2 {
        return centres.iter().flat_map(|c| [c - 0.5, c + 0.5]).collect();
    }
    let mut borders = vec![centres[0] - 0.5 * (centres[1] - centres[0])];
    borders.extend(centres.windows(2).map(|w| 0.5 * (w[0] + w[1])));
    borders.push(centres[n - 1] + 0.5 * (centres[n - 1] - centres[n - 2]));
    borders
}

impl Heat<'_> {
    fn axes(&self) -> (Vec<usize>, Vec<usize>) {
        (kept(self.x.1.len()), kept(self.y.1.len()))
    }

    fn range(&self) -> (f64, f64) {
        self.range.unwrap_or_else(|| {
            let (xs, ys) = self.axes();
            let all = || ys.iter().flat_map(|j| xs.iter().filter_map(|i| (self.value.1)(*i, *j)));
            let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
            if self.colours == Colours::Diverging {
                let most = low.abs().max(high.abs()).max(1e-9);
                return (-most, most);
            }
            (low, if high > low { high } else { low + 1.0 })
        })
    }

    /// The picture.
    pub(crate) fn draw(&self) -> Svg {
        let (width, height) = self.size;
        let mut svg = Svg::new(&self.id, &self.title, width, height);
        let (xs, ys) = self.axes();
        let pick = |breaks: &[f64], kept: &[usize]| borders(&kept.iter().map(|k| breaks[*k]).collect::<Vec<f64>>());
        let (bx, by) = (pick(self.x.1, &xs), pick(self.y.1, &ys));
        let (right, bottom) = (width - BAR, height - BELOW);
        let sx = Scale::new(bx[0], bx[bx.len() - 1], LEFT, right);
        let sy = Scale::new(by[0], by[by.len() - 1], bottom, TOP);
        let (low, high) = self.range();
        svg.text(LEFT, 15.0, "t", &self.title);
        svg.open(&format!("class=\"h\" data-heat=\"{}\"", self.id));
        let (mut extrapolated, mut unreachable, mut dots) = (String::new(), String::new(), String::new());
        let mut seen = [false; 4];
        for (b, j) in ys.iter().enumerate() {
            for (a, i) in xs.iter().enumerate() {
                let (x0, x1, y0, y1) = (sx.at(bx[a]), sx.at(bx[a + 1]), sy.at(by[b + 1]), sy.at(by[b]));
                let fill = match (self.value.1)(*i, *j) {
                    Some(v) => format!("fill=\"{}\"", self.colours.at((v - low) / (high - low))),
                    None => "class=\"no\"".to_owned(),
                };
                // a little overlap, so that no seam is visible
                svg.rect(x0, y0, x1 - x0 + 0.3, y1 - y0 + 0.3, &format!("{fill} data-c=\"{a} {b}\""));
                let Some(status) = self.status.as_ref().map(|s| s(*i, *j)) else { continue };
                let list = match status {
                    CellStatus::Measured => {
                        seen[0] = true;
                        continue;
                    }
                    CellStatus::Interpolated => {
                        seen[1] = true;
                        let _ = write!(dots, "M{} {}h3v3h-3z", px(0.5 * (x0 + x1) - 1.5), px(0.5 * (y0 + y1) - 1.5));
                        continue;
                    }
                    CellStatus::Extrapolated => {
                        seen[2] = true;
                        &mut extrapolated
                    }
                    CellStatus::Unreachable => {
                        seen[3] = true;
                        &mut unreachable
                    }
                };
                let _ = write!(list, "M{} {}H{}V{}H{}Z", px(x0), px(y0), px(x1), px(y1), px(x0));
            }
        }
        svg.close();
        svg.open("pointer-events=\"none\"");
        for (d, fill) in [
            (extrapolated, "fill=\"url(#he)\""),
            (unreachable, "fill=\"url(#hu)\""),
            (dots, "fill=\"#fff\" stroke=\"#222\" stroke-width=\".8\""),
        ] {
            if !d.is_empty() {
                svg.path(&d, fill);
            }
        }
        if let Some((name, points)) = &self.curve {
            let inside: Vec<(f64, f64)> = points
                .iter()
                .filter(|p| p.0 >= sx.low && p.0 <= sx.high && p.1 >= sy.low && p.1 <= sy.high)
                .map(|p| (sx.at(p.0), sy.at(p.1)))
                .collect();
            svg.polyline(&inside, "z");
            svg.polyline(&inside, "zk");
            if let Some(end) = inside.last() {
                svg.text(end.0 - 5.0, end.1 - 6.0, "e halo", name);
            }
        }
        if let Some((x, y)) = self.dot {
            svg.dot(sx.at(x), sy.at(y), 4.5, "mark");
        }
        svg.close();
        self.draw_axes(&mut svg, &sx, &sy);
        self.draw_bar(&mut svg, (low, high));
        self.draw_marks(&mut svg, seen);
        svg
    }

    fn draw_axes(&self, svg: &mut Svg, sx: &Scale, sy: &Scale) {
        let (width, height) = self.size;
        let (right, bottom) = (width - BAR, height - BELOW);
        let (ticks, digits) = sx.ticks(8.0);
        for t in ticks {
            svg.line((sx.at(t), bottom), (sx.at(t), bottom + 4.0), "x");
            svg.text(sx.at(t), bottom + 16.0, "c", &num(t, digits));
        }
        let (ticks, digits) = sy.ticks(7.0);
        for t in ticks {
            svg.line((LEFT - 4.0, sy.at(t)), (LEFT, sy.at(t)), "x");
            svg.text(LEFT - 7.0, sy.at(t) + 4.0, "e", &num(t, digits));
        }
        svg.text(0.5 * (LEFT + right), bottom + 32.0, "c m", &format!("{} [{}]", self.x.0.name, self.x.0.unit));
        svg.upward(14.0, 0.5 * (TOP + bottom), &format!("{} [{}]", self.y.0.name, self.y.0.unit));
    }

    fn draw_bar(&self, svg: &mut Svg, (low, high): (f64, f64)) {
        let (width, height) = self.size;
        let (x, bottom) = (width - BAR + 14.0, height - BELOW);
        let scale = Scale::new(low, high, bottom, TOP);
        let pieces = 32;
        for k in 0..pieces {
            let (a, b) = (f64::from(k) / f64::from(pieces), f64::from(k + 1) / f64::from(pieces));
            let (top, end) = (bottom - b * (bottom - TOP), bottom - a * (bottom - TOP));
            // a little overlap, so that no seam is visible
            svg.rect(x, top, 11.0, end - top + 0.4, &format!("fill=\"{}\"", self.colours.at(0.5 * (a + b))));
        }
        let (ticks, digits) = scale.ticks(5.0);
        for t in ticks {
            svg.text(x + 16.0, scale.at(t) + 4.0, "", &num(t, digits));
        }
        svg.text(x, TOP - 11.0, "m", self.value.0.unit);
    }

    /// Legend of the marks that occur over the cells.
    fn draw_marks(&self, svg: &mut Svg, seen: [bool; 4]) {
        if self.status.is_none() || !self.legend {
            return;
        }
        let y = self.size.1 - 16.0;
        let mut x = LEFT;
        let names = ["measured", "interpolated", "extrapolated", "unreachable"];
        for k in (0..4).filter(|k| seen[*k]) {
            svg.rect(x, y, 14.0, 11.0, "fill=\"#2a788e\"");
            match k {
                1 => svg.rect(x + 5.5, y + 4.0, 3.0, 3.0, "fill=\"#fff\" stroke=\"#222\" stroke-width=\".8\""),
                2 => svg.rect(x, y, 14.0, 11.0, "fill=\"url(#he)\""),
                3 => svg.rect(x, y, 14.0, 11.0, "fill=\"url(#hu)\""),
                _ => {}
            }
            svg.text(x + 19.0, y + 10.0, "m", names[k]);
            x += 104.0;
        }
    }

    /// Data of a cell that the page shows under the pointer and draws as a surface.
    pub(crate) fn data(&self) -> Value {
        let (xs, ys) = self.axes();
        let axis = |q: &Quantity, breaks: &[f64], kept: &[usize]| json!({ "n": q.name, "u": q.unit, "b": kept.iter().map(|k| breaks[*k]).collect::<Vec<f64>>() });
        let field = |(q, of): &(Quantity, Field)| {
            let steps = 10f64.powi(q.digits as i32 + 1);
            let rounded = |v: f64| (v * steps).round() / steps;
            let rows: Vec<Vec<Option<f64>>> = ys.iter().map(|j| xs.iter().map(|i| of(*i, *j).map(rounded)).collect()).collect();
            json!({ "n": q.name, "u": q.unit, "d": q.digits, "z": rows })
        };
        let status: Option<Vec<String>> =
            self.status.as_ref().map(|s| ys.iter().map(|j| xs.iter().map(|i| letter(s(*i, *j))).collect()).collect());
        let (low, high) = self.range();
        json!({
            "x": axis(&self.x.0, self.x.1, &xs),
            "y": axis(&self.y.0, self.y.1, &ys),
            "v": std::iter::once(&self.value).chain(&self.beside).map(field).collect::<Vec<Value>>(),
            "s": status,
            "r": [low, high],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_axis_is_thinned_out_and_keeps_its_ends() {
        let kept = kept(2000);
        assert!(kept.len() <= MOST + 1 && kept[0] == 0 && kept[kept.len() - 1] == 1999);
        assert_eq!(borders(&[0.0, 1.0, 3.0]), [-0.5, 0.5, 2.0, 4.0]);
    }
}
