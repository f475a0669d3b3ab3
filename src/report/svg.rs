//! Pictures as SVG text: the few shapes that the figures need, in a page or as files of their own.

use maud::{Markup, PreEscaped, html};
use std::fmt::Write as _;

/// Styles of every figure; colours are variables that the page sets for light and dark.
pub(crate) const STYLE: &str = include_str!("figure.css");
/// The colours of a picture that stands alone: paper is white.
const PAPER: &str = ".f{--ink:#1b1f24;--muted:#5a6572;--rule:#dfe3e8;--a:#0068a8;--b:#c2410c;--empty:#eceff2;background:#fff}";
/// Hatches by which a cell's status is told apart without colour, light and dark lines side by side so that they show on any colour.
pub(crate) const PATTERNS: &str = "<defs>\
<pattern id=\"he\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\">\
<path d=\"M1 0V7\" stroke=\"#fff\" stroke-opacity=\".8\" stroke-width=\"1.4\"/><path d=\"M2.3 0V7\" stroke=\"#000\" stroke-opacity=\".5\" stroke-width=\"1.2\"/></pattern>\
<pattern id=\"hu\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\">\
<path d=\"M0 0L7 7M7 0L0 7\" stroke=\"#fff\" stroke-opacity=\".75\" stroke-width=\"2.2\"/><path d=\"M0 0L7 7M7 0L0 7\" stroke=\"#000\" stroke-opacity=\".6\" stroke-width=\"1\"/></pattern></defs>";

/// A picture being drawn. Coordinates are in its own pixels, y downward.
#[derive(Debug, Clone)]
pub(crate) struct Svg {
    id: String,
    label: String,
    width: f64,
    height: f64,
    body: String,
}

impl Svg {
    /// An empty picture; `label` is what a screen reader says.
    pub(crate) fn new(id: &str, label: &str, width: f64, height: f64) -> Self {
        Self { id: id.to_owned(), label: label.to_owned(), width, height, body: String::new() }
    }

    /// Its name in the page and as a file.
    pub(crate) fn id(&self) -> &str {
        &self.id
    }

    /// Text at its base line; `class` holds `e` (ends there), `c` (centred), `m` (muted), `t` (title).
    pub(crate) fn text(&mut self, x: f64, y: f64, class: &str, text: &str) {
        let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        let _ = write!(self.body, "<text x=\"{}\" y=\"{}\"{class}>{}</text>", px(x), px(y), escaped(text));
    }

    /// Text turned to read upward, centred at its place.
    pub(crate) fn upward(&mut self, x: f64, y: f64, text: &str) {
        let (x, y) = (px(x), px(y));
        let _ = write!(self.body, "<text class=\"c m\" transform=\"translate({x} {y})rotate(-90)\">{}</text>", escaped(text));
    }

    /// A straight line.
    pub(crate) fn line(&mut self, from: (f64, f64), to: (f64, f64), class: &str) {
        let _ = write!(self.body, "<path class=\"{class}\" d=\"M{} {}L{} {}\"/>", px(from.0), px(from.1), px(to.0), px(to.1));
    }

    /// A line through points.
    pub(crate) fn polyline(&mut self, points: &[(f64, f64)], class: &str) {
        if points.len() > 1 {
            let _ = write!(self.body, "<path class=\"{class}\" d=\"{}\"/>", path(points));
        }
    }

    /// An area between two lines over the same places.
    pub(crate) fn band(&mut self, lower: &[(f64, f64)], upper: &[(f64, f64)], class: &str) {
        let outline: Vec<(f64, f64)> = lower.iter().chain(upper.iter().rev()).copied().collect();
        if outline.len() > 3 {
            let _ = write!(self.body, "<path class=\"{class}\" d=\"{}Z\"/>", path(&outline));
        }
    }

    /// A path as it is written, with further attributes.
    pub(crate) fn path(&mut self, d: &str, attributes: &str) {
        let _ = write!(self.body, "<path d=\"{d}\" {attributes}/>");
    }

    /// A disc.
    pub(crate) fn dot(&mut self, x: f64, y: f64, radius: f64, class: &str) {
        let _ = write!(self.body, "<circle class=\"{class}\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>", px(x), px(y), px(radius));
    }

    /// A rectangle with further attributes as they are.
    pub(crate) fn rect(&mut self, x: f64, y: f64, width: f64, height: f64, attributes: &str) {
        let (x, y, width, height) = (px(x), px(y), px(width), px(height));
        let _ = write!(self.body, "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" {attributes}/>");
    }

    /// Opens a group; closed by [`Svg::close`].
    pub(crate) fn open(&mut self, attributes: &str) {
        let _ = write!(self.body, "<g {attributes}>");
    }

    /// Closes a group.
    pub(crate) fn close(&mut self) {
        self.body.push_str("</g>");
    }

    /// For the page, which holds style and patterns once.
    pub(crate) fn inline(&self) -> Markup {
        let Self { id, label, width, height, body } = self;
        html! {
            svg.f id=(id) role="img" aria-label=(label) viewBox={ "0 0 " (width) " " (height) }
                style={ "max-width:" (width) "px;--w:" (width) "px" } { (PreEscaped(body)) }
        }
    }

    /// As a file of its own.
    pub(crate) fn file(&self) -> String {
        let Self { label, width, height, body, .. } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"f\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\
             <title>{}</title><style>{PAPER}{}</style>{PATTERNS}<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{body}</svg>\n",
            escaped(label),
            STYLE.replace('\n', "")
        )
    }
}

/// A path through points.
fn path(points: &[(f64, f64)]) -> String {
    let mut d = String::with_capacity(points.len() * 12);
    for (k, (x, y)) in points.iter().enumerate() {
        let _ = write!(d, "{}{} {}", if k == 0 { 'M' } else { 'L' }, px(*x), px(*y));
    }
    d
}

/// A coordinate to a tenth of a pixel.
pub(crate) fn px(value: f64) -> String {
    let rounded = (value * 10.0).round() / 10.0;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

/// A number with `digits` decimals and a true minus sign.
pub(crate) fn num(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if zero { text.replace('-', "") } else { text.replace('-', "−") }
}

/// Text safe in XML and HTML, attributes included. A character that XML does not allow at all is replaced.
fn escaped(text: &str) -> String {
    let allowed = text.replace(|c: char| c.is_control() && !matches!(c, '\n' | '\t'), "\u{fffd}");
    html! { (allowed) }.into_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_true_minus_and_no_negative_zero() {
        assert_eq!(num(-1.26, 1), "−1.3");
        assert_eq!(num(-0.001, 2), "0.00");
        assert_eq!(px(-0.01), "0");
    }

    #[test]
    fn names_from_a_file_cannot_leave_their_place() {
        assert_eq!(escaped("<b a=\"x\">&\u{1}"), "&lt;b a=&quot;x&quot;&gt;&amp;\u{fffd}");
        let inline = Svg::new("a\"><i>", "b\"><u>", 2.0, 1.0).inline().into_string();
        assert!(inline.contains("id=\"a&quot;&gt;&lt;i&gt;\"") && inline.contains("aria-label=\"b&quot;&gt;&lt;u&gt;\""), "{inline}");
    }
}
