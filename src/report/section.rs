//! A section of the page: its text with its figures, and what the script needs to know of them.

use crate::report::chart::Chart;
use crate::report::heat::Heat;
use crate::report::svg::Svg;
use maud::{Markup, html};
use serde_json::Value;

/// One section.
pub(crate) struct Section {
    pub(crate) id: &'static str,
    pub(crate) title: &'static str,
    /// What follows the title.
    pub(crate) body: Markup,
    pub(crate) figures: Figures,
}

/// The figures of a section. Each method draws one, keeps it, and returns it for its place in the text.
#[derive(Default)]
pub(crate) struct Figures {
    /// In the order in which they were drawn.
    pub(crate) pictures: Vec<Svg>,
    /// Data of the heat maps by their id.
    pub(crate) heats: Vec<(String, Value)>,
}

impl Figures {
    /// A heat map whose cells answer the pointer.
    pub(crate) fn heat(&mut self, heat: &Heat) -> Markup {
        self.heats.push((heat.id.clone(), heat.data()));
        self.svg(heat.draw())
    }

    /// A heat map, and beside it the surface over its cells, which the script draws and turns; `label` is what a screen reader says of it.
    pub(crate) fn heat_and_surface(&mut self, heat: &Heat, label: &str) -> Markup {
        html! {
            (self.heat(heat))
            figure.turn {
                svg.f.surface data-of=(heat.id) tabindex="0" role="img" aria-label=(label) viewBox="0 0 440 380" style="max-width:440px" {}
            }
        }
    }

    /// A chart.
    pub(crate) fn chart(&mut self, chart: &Chart) -> Markup {
        self.svg(chart.draw())
    }

    /// A picture.
    pub(crate) fn svg(&mut self, svg: Svg) -> Markup {
        let figure = html! { figure { (svg.inline()) } };
        self.pictures.push(svg);
        figure
    }
}
