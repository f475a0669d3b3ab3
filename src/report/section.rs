//! A section of the page: its text, its figures, and what the script needs to know of them.

use crate::report::chart::Chart;
use crate::report::heat::Heat;
use crate::report::html;
use crate::report::svg::{Svg, escaped};
use serde_json::Value;
use std::fmt::Write as _;

/// One section.
pub(crate) struct Section {
    pub(crate) id: &'static str,
    pub(crate) title: &'static str,
    pub(crate) body: String,
    /// The figures, in order.
    pub(crate) pictures: Vec<Svg>,
    /// Data of the heat maps by their id.
    pub(crate) heats: Vec<(String, Value)>,
}

impl Section {
    pub(crate) fn new(id: &'static str, title: &'static str) -> Self {
        Self { id, title, body: String::new(), pictures: Vec::new(), heats: Vec::new() }
    }

    pub(crate) fn paragraph(&mut self, text: &str) {
        self.body.push_str(&html::paragraph(text));
    }

    /// A remark that something is absent.
    pub(crate) fn absent(&mut self, text: &str) {
        self.body.push_str(&html::absent(text));
    }

    pub(crate) fn table(&mut self, class: &str, header: &[&str], rows: &[Vec<String>]) {
        self.body.push_str(&html::table(class, header, rows));
    }

    /// A heading within the section.
    pub(crate) fn heading(&mut self, text: &str) {
        let _ = writeln!(self.body, "<h3>{}</h3>", escaped(text));
    }

    /// Figures that follow stand side by side where there is room.
    pub(crate) fn open_row(&mut self) {
        self.body.push_str("<div class=\"row\">\n");
    }

    pub(crate) fn close_row(&mut self) {
        self.body.push_str("</div>\n");
    }

    pub(crate) fn heat(&mut self, heat: &Heat) {
        self.picture(heat.draw());
        self.heats.push((heat.id.clone(), heat.data()));
    }

    /// The surface over a heat map that is in the page: drawn, and turned, by the script.
    pub(crate) fn surface(&mut self, heat_id: &str, label: &str) {
        let _ = writeln!(
            self.body,
            "<figure class=\"turn\"><svg class=\"f surface\" data-of=\"{heat_id}\" tabindex=\"0\" role=\"img\" aria-label=\"{}\" \
             viewBox=\"0 0 440 380\" style=\"max-width:440px\"></svg></figure>",
            escaped(label)
        );
    }

    pub(crate) fn chart(&mut self, chart: &Chart) {
        self.picture(chart.draw());
    }

    pub(crate) fn svg(&mut self, svg: Svg) {
        self.picture(svg);
    }

    fn picture(&mut self, svg: Svg) {
        self.body.push_str("<figure>");
        self.body.push_str(&svg.inline());
        self.body.push_str("</figure>\n");
        self.pictures.push(svg);
    }
}
