//! All settings of the controller, as a file and as they are stored in a verdict.

use crate::controller::module_sections::{MonitoringKeys, SpotTurnKeys, SteeringKeys, TrackingKeys};
use crate::controller::sections::{AdditionKeys, FinishKeys, LoopKeys, PlanningKeys, PreviewKeys};
use crate::controller::setting::{Setting, Shown};
use crate::controller::{Error, Result};
use crate::map::{sha256_hex, toml_line, toml_text};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;

/// `data/controllers/default.toml`.
const DEFAULT: &str = include_str!("../../data/controllers/default.toml");

/// Shortest and longest control period [s]; a period is a whole number of milliseconds, the step of the simulated vehicle.
const PERIOD_S: std::ops::RangeInclusive<f64> = 0.005..=0.1;

/// Settings of the controller, every value within its range. A key that a file leaves out has its default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ControllerSettings {
    /// Name of the controller. Default `custom`.
    name: String,
    /// Control period [s]. Default 0.02.
    pub(crate) period_s: f64,
    pub(crate) planning: PlanningKeys,
    pub(crate) preview: PreviewKeys,
    pub(crate) speed_loop: LoopKeys,
    pub(crate) finish: FinishKeys,
    pub(crate) additions: AdditionKeys,
    pub(crate) monitoring: MonitoringKeys,
    pub(crate) steering: SteeringKeys,
    pub(crate) path_tracking: TrackingKeys,
    pub(crate) spot_turn: SpotTurnKeys,
}

impl Default for ControllerSettings {
    fn default() -> Self {
        Self {
            name: "custom".to_owned(),
            period_s: 0.02,
            planning: PlanningKeys::default(),
            preview: PreviewKeys::default(),
            speed_loop: LoopKeys::default(),
            finish: FinishKeys::default(),
            additions: AdditionKeys::default(),
            monitoring: MonitoringKeys::default(),
            steering: SteeringKeys::default(),
            path_tracking: TrackingKeys::default(),
            spot_turn: SpotTurnKeys::default(),
        }
    }
}

/// Settings of the controller with the hash of their file, as `verify.json` stores them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ControllerFile {
    /// SHA-256 of the file; of the bundled `default.toml` if none was given.
    pub(crate) sha256: String,
    /// Its content, with the defaults of keys that it leaves out.
    pub(crate) settings: ControllerSettings,
}

impl ControllerFile {
    /// Reads the text of a controller file.
    ///
    /// # Errors
    /// Text that is not TOML, a key that is not known (the nearest known one is given), a value of another type, out of its range, or against
    /// another value.
    pub fn from_toml(text: &str) -> Result<Self> {
        Ok(Self { sha256: sha256_hex(text.as_bytes()), settings: ControllerSettings::from_toml(text)? })
    }

    /// The controller of this program, `data/controllers/default.toml`.
    ///
    /// # Errors
    /// None in practice: the file is part of the program.
    pub fn bundled() -> Result<Self> {
        Self::from_toml(DEFAULT)
    }

    /// The settings.
    pub fn settings(&self) -> &ControllerSettings {
        &self.settings
    }

    /// SHA-256 of the file.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Name and start of the hash, to show which controller was judged.
    pub fn label(&self) -> String {
        format!("{} (SHA-256 {:.12}…)", self.settings.name, self.sha256)
    }
}

impl ControllerSettings {
    fn from_toml(text: &str) -> Result<Self> {
        let settings: Self =
            toml_text(text).map_err(|fault| Error::Toml { line: fault.line, message: fault.message, nearest: fault.nearest })?;
        settings.checked(text)?;
        Ok(settings)
    }

    /// Name of the controller.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The same with another name.
    #[must_use]
    pub(crate) fn named(self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self }
    }

    /// The sections with their headings and settings, in the order of the file.
    pub(crate) fn sections(&self) -> [(&'static str, &'static str, Vec<Setting>); 9] {
        [
            ("planning", "The plan of a turn.", self.planning.settings()),
            ("preview", "Formula (1): the planned speed that the law follows.", self.preview.settings()),
            ("speed_loop", "Formula (2): from the speed error to the desired acceleration.", self.speed_loop.settings()),
            ("finish", "The look-up, and the end of a turn.", self.finish.settings()),
            ("additions", "Additions to the published law (docs/controller.md); \"off\" removes one.", self.additions.settings()),
            ("monitoring", "Times and limits of the longitudinal module.", self.monitoring.settings()),
            ("steering", "Tolerances and times of the steering.", self.steering.settings()),
            ("path_tracking", "The speed loop along paths: polylines, parking, U-turns.", self.path_tracking.settings()),
            ("spot_turn", "The speed loop of the turns on the spot in a polyline.", self.spot_turn.settings()),
        ]
    }

    /// The text of a file with every key, its meaning beside it; `head` are lines of comment at its start.
    pub(crate) fn to_toml(&self, head: &[String]) -> String {
        let mut text: String = head.iter().fold(String::new(), |mut text, line| {
            let _ = writeln!(text, "# {line}");
            text
        });
        let name = serde_json::Value::String(self.name.clone());
        let _ = write!(text, "\nname = {name}\n# control period [s]\nperiod_s = {:?}\n", self.period_s);
        for (section, about, settings) in self.sections() {
            let _ = write!(text, "\n# {about}\n[{section}]\n");
            for setting in settings {
                let line = format!("{} = {}", setting.key, setting.value);
                let _ = writeln!(text, "{line:<36} # {}", setting.about);
            }
        }
        text
    }

    /// Every setting on one line per section, for the header of an export.
    pub(crate) fn lines(&self) -> Vec<String> {
        let words = |value: Shown| match value {
            Shown::Number(number) => number.to_string(),
            Shown::Word(word) => word.to_owned(),
        };
        let line = |(section, _, settings): (&str, &str, Vec<Setting>)| {
            let all: Vec<String> = settings.iter().map(|s| format!("{} {}", s.key, words(s.value))).collect();
            format!("{section}: {}", all.join(", "))
        };
        std::iter::once(format!("period_s {}", self.period_s)).chain(self.sections().map(line)).collect()
    }

    /// Checks every value against its range, and the values against each other.
    fn checked(&self, text: &str) -> Result<()> {
        let milliseconds = 1e3 * self.period_s;
        if !PERIOD_S.contains(&self.period_s) || (milliseconds - milliseconds.round()).abs() > 1e-9 {
            let allowed = format!("{} to {} in whole milliseconds", PERIOD_S.start(), PERIOD_S.end());
            return Err(Error::Range {
                line: toml_line(text, ("", 0), "period_s"),
                key: "period_s".to_owned(),
                found: self.period_s,
                allowed,
            });
        }
        for (section, _, settings) in self.sections() {
            if let Some((setting, found)) = settings.iter().find_map(|s| Some((s, s.outside()?))) {
                let line = toml_line(text, (section, 0), setting.key);
                return Err(Error::Range { line, key: format!("{section}.{}", setting.key), found, allowed: setting.allowed() });
            }
        }
        let planning = &self.planning;
        if planning.start_speed_mps > planning.cruise_speed_mps {
            return Err(Error::Contradiction {
                key: "planning.start_speed_mps",
                found: planning.start_speed_mps,
                other: "planning.cruise_speed_mps",
                limit: planning.cruise_speed_mps,
                rule: "a turn cannot start above its highest speed",
            });
        }
        if let Some(guard_mps2) = self.additions.guard_from_mps2.value().filter(|guard| *guard < planning.decel_mps2) {
            return Err(Error::Contradiction {
                key: "additions.guard_from_mps2",
                found: guard_mps2,
                other: "planning.decel_mps2",
                limit: planning.decel_mps2,
                rule: "the guard would brake on the plan itself; let it act from above the plan's deceleration",
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::control::{PivotSettings, WaypointLawSettings};

    const HEADS: [&[&str]; 2] = [
        &[
            "The controller that pivot-cal verifies maps with, unless another is given by --controller-settings FILE.",
            "A key that a file leaves out has the value of this file.",
        ],
        &[
            "The published law with nothing added: waypoints, preview (1), speed loop (2), look-up, and an end where the torque stops at the threshold.",
        ],
    ];

    #[test]
    fn the_bundled_files_hold_every_key_and_the_default_is_the_controller_of_the_crate() {
        let default = ControllerFile::bundled().unwrap().settings;
        let plain = ControllerFile::from_toml(include_str!("../../data/controllers/plain.toml")).unwrap().settings;
        let files = [DEFAULT, include_str!("../../data/controllers/plain.toml")];
        for ((file, settings), head) in files.into_iter().zip([&default, &plain]).zip(HEADS) {
            assert_eq!(file, settings.to_toml(&head.iter().map(|line| (*line).to_owned()).collect::<Vec<_>>()));
        }
        assert_eq!(default, ControllerSettings::default().named("default"));
        // what the crate documents as its defaults
        assert_eq!(default.pivot(0.92, 1.5), PivotSettings::new(0.92, 1.5));
        assert_eq!(default.law(0.92, 0.1), WaypointLawSettings::new(0.92));
        let law = plain.law(0.92, 0.1);
        assert!(law.guard.is_none() && law.accel_rise_mps3.is_none() && law.finish == crate::control::Finish::Threshold);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line_and_what_is_allowed() {
        let cases = [
            ("[speed_loop]\nproportional = 3", "line 2: unknown field `proportional`", "did you mean `proportional_per_s`?"),
            ("name = \"a\"\n[speed_loop]\nproportional_per_s = 80", "line 3: speed_loop.proportional_per_s is 80", "allowed: 0 to 50"),
            ("[additions]\nguard_from_mps2 = \"none\"", "line 2: invalid value: string \"none\"", "a number or \"off\""),
            ("[additions]\naccel_rise_mps3 = -1", "line 2: additions.accel_rise_mps3 is -1", "allowed: \"off\", 0.1 to 100"),
            ("[preview]\nnearest = \"point\"", "line 2: unknown variant `point`", "`waypoint`"),
            ("[planning]\ncruise_speed_mps = 0.05", "planning.start_speed_mps is 0.1", "above its highest speed"),
            ("[planning]\ndecel_mps2 = 0.8", "additions.guard_from_mps2 is 0.5", "the guard would brake on the plan itself"),
            ("period_s = 0.0205", "line 1: period_s is 0.0205", "whole milliseconds"),
            ("period_s = nan", "line 1: period_s is NaN", "0.005 to 0.1"),
        ];
        for (text, found, allowed) in cases {
            let error = ControllerFile::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(found) && error.contains(allowed), "{text}: {error}");
        }
    }

    #[test]
    fn a_key_that_is_left_out_has_its_default_and_the_text_reads_back_as_it_is() {
        let text = "name = \"mine\"\n[speed_loop]\nproportional_per_s = 2\n[planning]\nwheel_policy = \"mirror\"\nright_angle_deg = -80\n";
        let settings = ControllerFile::from_toml(text).unwrap().settings;
        assert_eq!(settings.law(0.9, 0.1).speed_loop.proportional_per_s, 2.0);
        assert_eq!(settings.law(0.9, 0.1).preview, WaypointLawSettings::new(0.9).preview);
        assert!((settings.pivot(0.9, 1.5).planning.right_angle_rad + 80f64.to_radians()).abs() < 1e-12);
        assert_eq!(ControllerSettings::from_toml(&settings.to_toml(&[])).unwrap(), settings);
        let json = serde_json::to_string(&settings).unwrap();
        assert_eq!(serde_json::from_str::<ControllerSettings>(&json).unwrap(), settings);
    }
}
