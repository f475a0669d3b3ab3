//! A section of the page: its text, its figures, and what the script needs to know of them.

use super::chart::Chart;
use super::heat::Heat;
use super::html;
use super::svg::{Svg, escaped};
use serde_json::Value;
use std::fmt::Write as _;

/// One section.
pub(super) struct Section {
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    pub(super) body: String,
    /// The figures, in order.
    pub(super) pictures: Vec<Svg>,
    /// Data of the heat maps by their id.
    pub(super) heats: Vec<(String, Value)>,
}

impl Section {
    pub(super) fn new(id: &'static str, title: &'static str) -> Self {
        Self { id, title, body: String::new(), pictures: Vec::new(), heats: Vec::new() }
    }

    pub(super) fn paragraph(&mut self, text: &str) {
        self.body.push_str(&html::paragraph(text));
    }

    /// A remark that something is absent.
    pub(super) fn absent(&mut self, text: &str) {
        self.body.push_str(&html::absent(text));
    }

    pub(super) fn table(&mut self, class: &str, header: &[&str], rows: &[Vec<String>]) {
        self.body.push_str(&html::table(class, header, rows));
    }

    /// A heading within the section.
    pub(super) fn heading(&mut self, text: &str) {
        let _ = writeln!(self.body, "<h3>{}</h3>", escaped(text));
    }

    /// Figures that follow stand side by side where there is room.
    pub(super) fn open_row(&mut self) {
        self.body.push_str("<div class=\"row\">\n");
    }

    pub(super) fn close_row(&mut self) {
        self.body.push_str("</div>\n");
    }

    pub(super) fn heat(&mut self, heat: &Heat) {
        self.picture(heat.draw());
        self.heats.push((heat.id.clone(), heat.data()));
    }

    /// The surface over a heat map that is in the page: drawn, and turned, by the script.
    pub(super) fn surface(&mut self, heat_id: &str, label: &str) {
        let _ = writeln!(
            self.body,
            "<figure class=\"turn\"><svg class=\"f surface\" data-of=\"{heat_id}\" tabindex=\"0\" role=\"img\" aria-label=\"{}\" \
             viewBox=\"0 0 440 380\" style=\"max-width:440px\"></svg></figure>",
            escaped(label)
        );
    }

    pub(super) fn chart(&mut self, chart: &Chart) {
        self.picture(chart.draw());
    }

    pub(super) fn svg(&mut self, svg: Svg) {
        self.picture(svg);
    }

    fn picture(&mut self, svg: Svg) {
        self.body.push_str("<figure>");
        self.body.push_str(&svg.inline());
        self.body.push_str("</figure>\n");
        self.pictures.push(svg);
    }
}
