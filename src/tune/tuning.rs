//! The result of the search.

use crate::controller::ControllerSettings;
use crate::tune::limit_margin::LimitMargin;
use crate::tune::loop_margins::LoopMargins;
use crate::verify::Maps;
use serde::Serialize;

/// A setting that the search changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct SettingChange {
    /// Section and key.
    pub(crate) key: String,
    /// Value before.
    pub(crate) from: String,
    /// Value after.
    pub(crate) to: String,
}

/// The result of the search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Tuning {
    /// Whether the settings keep every limit of the gate.
    pub(crate) passes: bool,
    /// The settings: those that were found, or the nearest ones.
    pub(crate) settings: ControllerSettings,
    /// What differs from the start.
    pub(crate) changes: Vec<SettingChange>,
    /// Candidates that were driven.
    pub(crate) candidates: usize,
    /// Mean settling time of the turns before and after [s]; absent if a turn does not end.
    pub(crate) settling_s: [Option<f64>; 2],
    /// Smallest margins before and after: of each metric and statistic the scenario that is nearest to its limit.
    pub(crate) before: Vec<LimitMargin>,
    pub(crate) after: Vec<LimitMargin>,
    /// Margins of the speed loop, after.
    pub(crate) loop_margins: LoopMargins,
    /// What limits the result, in words.
    pub(crate) limits: Vec<String>,
}

impl Tuning {
    /// The text of the controller file, with the map that it was tuned for and its margins at its start.
    pub(crate) fn to_toml(&self, maps: &Maps) -> String {
        let vehicle = &maps.table2.vehicle;
        let mut head = vec![
            format!("Written by pivot-cal {} tune.", env!("CARGO_PKG_VERSION")),
            format!("For the map of generation {}, wheelbase {} m.", maps.table1.generation, vehicle.wheelbase_m),
        ];
        let margins = &self.loop_margins;
        head.push(format!(
            "Speed loop: gain margin {:.2}, phase margin {:.1} deg, delay margin {:.3} s.",
            margins.gain, margins.phase_deg, margins.delay_s
        ));
        head.extend(self.after.iter().take(4).map(|m| format!("{}, {:.0} % left.", m.sentence(), 100.0 * m.margin)));
        let generation = maps.table1.generation.get(..8).unwrap_or("map");
        self.settings.clone().named(&format!("tuned for {generation}")).to_toml(&head)
    }
}

/// The settings in which two controllers differ.
pub(crate) fn changes(from: &ControllerSettings, to: &ControllerSettings) -> Vec<SettingChange> {
    let mut changes = Vec::new();
    for ((section, _, before), (_, _, after)) in from.sections().into_iter().zip(to.sections()) {
        for (before, after) in before.iter().zip(&after).filter(|(before, after)| before.value != after.value) {
            let key = format!("{section}.{}", before.key);
            changes.push(SettingChange { key, from: before.value.to_string(), to: after.value.to_string() });
        }
    }
    changes
}
