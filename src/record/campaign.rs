//! The campaign plan: a TOML list of groups of runs, expanded into single runs.

use crate::map::Gear;
use crate::record::error::{Error, Result};
use crate::record::event::RunEvent;
use crate::sim;
use crate::sim::{Random, Stream, Timing};
use serde::{Deserialize, Serialize};

/// A campaign: its runs, and the timing of its messages.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    /// Name, for the user.
    #[serde(default)]
    pub name: String,
    /// Start time of the log, RFC 3339. It is fixed in the file, so that the same plan and seed give the same bytes.
    #[serde(default = "default_start_time", skip_serializing_if = "is_default_start_time")]
    pub start_time: String,
    /// Seed of all random numbers. Default 1.
    #[serde(default = "default_seed", skip_serializing_if = "is_default_seed")]
    pub seed: u64,
    /// Timing of the messages that are not sensors.
    #[serde(default, skip_serializing_if = "is_default_topics")]
    pub topics: TopicSettings,
    /// Slope of the floor [°], uphill along the heading of the start; positive or negative, less than 45 in size. Default 0.
    #[serde(default, skip_serializing_if = "is_default")]
    pub slope_deg: f64,
    /// The groups of runs, driven in this order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<RunGroup>,
}

impl Default for Campaign {
    fn default() -> Self {
        let (start_time, seed) = (default_start_time(), default_seed());
        Self { name: String::new(), start_time, seed, topics: TopicSettings::default(), slope_deg: 0.0, runs: Vec::new() }
    }
}

fn default_start_time() -> String {
    "2026-01-15T08:00:00Z".to_owned()
}

fn default_seed() -> u64 {
    1
}

/// Timing of the messages that are not sensors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TopicSettings {
    /// `/drive/torque_command`: the valid command at the time of the message, so that a stamp is late by its phase. Default 50 Hz.
    pub torque_command: Timing,
    /// Whether the command is logged only when it changes. Default false.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub torque_command_on_change: bool,
    /// `/drive/gear`. Default 10 Hz.
    pub gear: Timing,
    /// `/safety/estop`. Default 10 Hz.
    pub estop: Timing,
    /// `/odom`, the localisation. Default 10 Hz.
    pub odometry: Timing,
}

impl Default for TopicSettings {
    fn default() -> Self {
        let slow = Timing { rate_hz: 10.0, ..Timing::default() };
        Self { torque_command: Timing::default(), torque_command_on_change: false, gear: slow, estop: slow, odometry: slow }
    }
}

/// Torque levels: a list, or a range with start, step and stop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number, a list of numbers, or { start, step, stop }")]
pub enum Torques {
    /// One level [N·m].
    One(f64),
    /// The levels [N·m].
    List(Vec<f64>),
    /// From `start` to `stop` in steps of `step`, both ends included [N·m].
    Steps(Steps),
}

/// From `start` to `stop` in steps of `step`, both ends included [N·m].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    start: f64,
    step: f64,
    stop: f64,
}

/// One or several wheel angles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number or a list of numbers")]
pub enum WheelAngles {
    /// One angle [°].
    One(f64),
    /// The angles [°], in driving order.
    List(Vec<f64>),
}

/// Runs that differ in torque, and in wheel angle if several are given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunGroup {
    /// Gear. Default forward.
    #[serde(default = "default_gear")]
    pub gear: Gear,
    /// Torque levels [N·m], gear frame: positive drives in the gear's direction.
    pub torque_nm: Torques,
    /// Number of runs per level. Default 1.
    #[serde(default = "default_repeats")]
    pub repeats: u32,
    /// Whether the order of the runs is drawn from the seed, so that warm-up does not look like an effect of torque. Default false.
    #[serde(default, skip_serializing_if = "is_default")]
    pub shuffle: bool,
    /// Spin-up speed before the level is applied [m/s]. Default 0: start from rest.
    #[serde(default, skip_serializing_if = "is_default")]
    pub start_speed_mps: f64,
    /// Spin-up torque [N·m]. Default 30.
    #[serde(default = "default_spin_up_nm", skip_serializing_if = "is_default_spin_up")]
    pub spin_up_nm: f64,
    /// A level after a spin-up ends below this speed [m/s], so that braking does not reverse the wheel. Default 0.03.
    #[serde(default = "default_end_speed_mps", skip_serializing_if = "is_default_end_speed")]
    pub end_speed_mps: f64,
    /// Longest time at the level [s]. Default 3.
    #[serde(default = "default_hold_s")]
    pub hold_s: f64,
    /// The level ends at this speed [m/s]. Default 1.2.
    #[serde(default = "default_speed_limit_mps")]
    pub speed_limit_mps: f64,
    /// The level ends if the wheel has not moved for this time [s]. Default 1.5.
    #[serde(default = "default_stall_s")]
    pub stall_s: f64,
    /// Pause at rest after the run [s]. Default 0.8.
    #[serde(default = "default_pause_s")]
    pub pause_s: f64,
    /// Wheel angle [°], or a list of angles. The group is driven at each angle in turn. Default: the vehicle's test angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wheel_angle_deg: Option<WheelAngles>,
    /// Standard deviation of the hand dither of the torque about the level [N·m]. Default 0.
    #[serde(default, skip_serializing_if = "is_default")]
    pub dither_nm: f64,
    /// An event during the level.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub event: Option<RunEvent>,
}

fn default_gear() -> Gear {
    Gear::Forward
}
fn default_repeats() -> u32 {
    1
}
fn default_spin_up_nm() -> f64 {
    30.0
}
fn default_hold_s() -> f64 {
    3.0
}
fn default_speed_limit_mps() -> f64 {
    1.2
}
fn default_end_speed_mps() -> f64 {
    0.03
}
fn default_stall_s() -> f64 {
    1.5
}
fn default_pause_s() -> f64 {
    0.8
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
fn is_default_start_time(value: &str) -> bool {
    value == default_start_time()
}
#[allow(clippy::trivially_copy_pass_by_ref)] // serde passes a reference
fn is_default_seed(value: &u64) -> bool {
    *value == default_seed()
}
fn is_default_topics(value: &TopicSettings) -> bool {
    *value == TopicSettings::default()
}
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_default_spin_up(value: &f64) -> bool {
    *value == default_spin_up_nm()
}
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_default_end_speed(value: &f64) -> bool {
    *value == default_end_speed_mps()
}

/// One run: a group's settings at one torque and wheel angle.
#[derive(Debug, Clone, PartialEq)]
pub struct RunPlan {
    /// The group, from 0.
    pub group: usize,
    /// Wheel angle [°]; `None` means the vehicle's test angle.
    pub wheel_angle_deg: Option<f64>,
    /// Torque level [N·m], gear frame.
    pub torque_nm: f64,
    /// The other settings.
    pub settings: RunGroup,
}

impl Campaign {
    /// Reads the TOML text and checks every number.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown (the nearest known key is given), a value is out of its range, or there are no runs.
    pub fn from_toml(text: &str) -> Result<Self> {
        let campaign: Self = sim::from_toml(text)?;
        campaign.start_ns()?;
        campaign.plan(campaign.seed)?;
        for timing in [&campaign.topics.torque_command, &campaign.topics.gear, &campaign.topics.estop, &campaign.topics.odometry] {
            timing.check()?;
        }
        Ok(campaign)
    }

    /// The TOML text for [`Campaign::from_toml`]. Each group is a separate entry below its text from `comments`. Rarely used keys with
    /// default values are left out.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_toml(&self, comments: &[String]) -> std::result::Result<String, toml::ser::Error> {
        #[derive(Serialize)]
        struct OneGroup<'a> {
            runs: [&'a RunGroup; 1],
        }
        let mut text = toml::to_string(&Self { runs: Vec::new(), ..self.clone() })?;
        for (k, group) in self.runs.iter().enumerate() {
            text.push('\n');
            text.push_str(comments.get(k).map_or("", String::as_str));
            text.push_str(&toml::to_string(&OneGroup { runs: [group] })?);
        }
        Ok(text)
    }

    /// Start of the log [ns since 1970].
    ///
    /// # Errors
    /// The start time is not RFC 3339 or is before 1970.
    pub fn start_ns(&self) -> Result<u64> {
        let wrong = |message: String| Error::StartTime { found: self.start_time.clone(), message };
        let time: jiff::Timestamp = self.start_time.parse().map_err(|e: jiff::Error| wrong(e.to_string()))?;
        u64::try_from(time.as_nanosecond()).map_err(|e| wrong(e.to_string()))
    }

    /// The single runs in driving order.
    ///
    /// # Errors
    /// A number is out of its range, a range gives no level, or there are no runs.
    pub fn plan(&self, seed: u64) -> Result<Vec<RunPlan>> {
        let mut random = Random::new(seed, Stream::Campaign);
        let mut plan = Vec::new();
        for (group, settings) in self.runs.iter().enumerate() {
            settings.check(group + 1)?;
            let levels = settings.torque_nm.levels(group + 1)?;
            for wheel_angle_deg in settings.angles_deg() {
                let mut runs: Vec<RunPlan> = (0..settings.repeats)
                    .flat_map(|_| levels.iter().map(|&torque_nm| RunPlan { group, wheel_angle_deg, torque_nm, settings: settings.clone() }))
                    .collect();
                if settings.shuffle {
                    // Fisher-Yates
                    for k in (1..runs.len()).rev() {
                        runs.swap(k, (random.uniform() * (k + 1) as f64) as usize);
                    }
                }
                plan.extend(runs);
            }
        }
        if plan.is_empty() { Err(Error::NoRuns) } else { Ok(plan) }
    }
}

impl Torques {
    fn levels(&self, group: usize) -> Result<Vec<f64>> {
        let levels = match self {
            Self::One(level) => vec![*level],
            Self::List(levels) => levels.clone(),
            Self::Steps(Steps { start, step, stop }) => {
                let steps = ((stop - start) / step + 1e-9).floor();
                if *step <= 0.0 || !(0.0..10_000.0).contains(&steps) {
                    return Err(Error::NoTorques { group, start_nm: *start, step_nm: *step, stop_nm: *stop });
                }
                (0..=steps as usize).map(|k| ((start + k as f64 * step) * 1e9).round() / 1e9).collect()
            }
        };
        match levels.iter().find(|level| !(-1e5..=1e5).contains(*level)) {
            Some(&value) => Err(Error::OutOfRange { group, field: "torque_nm", value, allowed: "-1e5 to 1e5" }),
            None => Ok(levels),
        }
    }
}

impl RunGroup {
    /// A group with the defaults.
    pub fn new(torque_nm: Torques) -> Self {
        Self {
            gear: default_gear(),
            torque_nm,
            repeats: default_repeats(),
            shuffle: false,
            start_speed_mps: 0.0,
            spin_up_nm: default_spin_up_nm(),
            hold_s: default_hold_s(),
            speed_limit_mps: default_speed_limit_mps(),
            end_speed_mps: default_end_speed_mps(),
            stall_s: default_stall_s(),
            pause_s: default_pause_s(),
            wheel_angle_deg: None,
            dither_nm: 0.0,
            event: None,
        }
    }

    /// The angles of the group; `None` means the test angle.
    fn angles_deg(&self) -> Vec<Option<f64>> {
        match &self.wheel_angle_deg {
            None => vec![None],
            Some(WheelAngles::One(angle)) => vec![Some(*angle)],
            Some(WheelAngles::List(angles)) => angles.iter().copied().map(Some).collect(),
        }
    }

    fn check(&self, group: usize) -> Result<()> {
        let within = |field, value: f64, range: std::ops::RangeInclusive<f64>, allowed| {
            if range.contains(&value) { Ok(()) } else { Err(Error::OutOfRange { group, field, value, allowed }) }
        };
        within("repeats", f64::from(self.repeats), 1.0..=1000.0, "1 to 1000")?;
        within("start_speed_mps", self.start_speed_mps, 0.0..=20.0, "0 to 20")?;
        within("spin_up_nm", self.spin_up_nm, 0.0..=1e5, "0 to 1e5")?;
        within("hold_s", self.hold_s, 0.02..=600.0, "0.02 to 600")?;
        within("speed_limit_mps", self.speed_limit_mps, 0.01..=20.0, "0.01 to 20")?;
        within("end_speed_mps", self.end_speed_mps, 0.0..=20.0, "0 to 20")?;
        within("stall_s", self.stall_s, 0.1..=600.0, "0.1 to 600")?;
        within("pause_s", self.pause_s, 0.0..=600.0, "0 to 600")?;
        let angles = self.angles_deg();
        if angles.is_empty() {
            return Err(Error::NoAngles { group });
        }
        for angle in angles {
            within("wheel_angle_deg", angle.unwrap_or(0.0), -180.0..=180.0, "-180 to 180")?;
        }
        within("dither_nm", self.dither_nm, 0.0..=1e5, "0 to 1e5")?;
        if let Some(event) = &self.event {
            within("event.at_s", event.at_s, 0.0..=600.0, "0 to 600")?;
            within("event.duration_s", event.duration_s, 0.0..=600.0, "0 to 600")?;
            within("event.grip_nm", event.grip_nm, 0.0..=1e5, "0 to 1e5")?;
            within("event.force_n", event.force_n, -1e5..=1e5, "-1e5 to 1e5")?;
            within("event.angle_deg", event.angle_deg, -180.0..=180.0, "-180 to 180")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn levels_are_expanded_and_repeated() {
        let text = "[[runs]]\ntorque_nm = { start = -8, step = 4, stop = 4 }\nrepeats = 2\n[[runs]]\ntorque_nm = 20\ngear = \"reverse\"\n";
        let plan = Campaign::from_toml(text).unwrap().plan(1).unwrap();
        let torques: Vec<f64> = plan.iter().map(|run| run.torque_nm).collect();
        assert_eq!(torques, [-8.0, -4.0, 0.0, 4.0, -8.0, -4.0, 0.0, 4.0, 20.0]);
        assert_eq!(plan[8].settings.gear, Gear::Reverse);
    }

    #[test]
    fn a_group_with_several_angles_is_driven_at_each_in_turn() {
        let text = "[[runs]]\ntorque_nm = [4, 8]\nrepeats = 2\nwheel_angle_deg = [0, -30.5]\n[[runs]]\ntorque_nm = 20\n[[runs]]\n\
                    torque_nm = 12\nwheel_angle_deg = 60\n";
        let plan = Campaign::from_toml(text).unwrap().plan(1).unwrap();
        let driven: Vec<_> = plan.iter().map(|run| (run.wheel_angle_deg, run.torque_nm)).collect();
        let (ahead, right) = (Some(0.0), Some(-30.5));
        assert_eq!(driven[..4], [(ahead, 4.0), (ahead, 8.0), (ahead, 4.0), (ahead, 8.0)]);
        assert_eq!(driven[4..], [(right, 4.0), (right, 8.0), (right, 4.0), (right, 8.0), (None, 20.0), (Some(60.0), 12.0)]);
    }

    #[test]
    fn a_shuffled_group_keeps_its_runs_and_repeats_its_order() {
        let campaign = Campaign::from_toml("[[runs]]\ntorque_nm = { start = 4, step = 4, stop = 40 }\nshuffle = true\n").unwrap();
        let order = |seed| campaign.plan(seed).unwrap().iter().map(|run| run.torque_nm as i32).collect::<Vec<_>>();
        assert_eq!(order(1), order(1));
        assert_ne!(order(1), order(2));
        let mut sorted = order(1);
        sorted.sort_unstable();
        assert_eq!(sorted, (1..=10).map(|k| 4 * k).collect::<Vec<_>>());
    }

    #[test]
    fn a_campaign_is_read_back_unchanged_from_its_text() {
        let text = "name = \"all\"\nseed = 7\ntopics = { gear = { rate_hz = 5 } }\n[[runs]]\ntorque_nm = { start = 4, step = 4, stop = 12 }\n\
                    shuffle = true\nwheel_angle_deg = [0, -30.5]\nevent = { kind = \"wet_patch\", at_s = 0.5, duration_s = 1, grip_nm = 5 }\n\
                    [[runs]]\ngear = \"reverse\"\ntorque_nm = [4, 8]\nstart_speed_mps = 0.5\nspin_up_nm = 40\nend_speed_mps = 0.2\ndither_nm = 1\n";
        let campaign = Campaign::from_toml(text).unwrap();
        let written = campaign.to_toml(&["# the first\n".to_owned()]).unwrap();
        assert_eq!(Campaign::from_toml(&written).unwrap(), campaign);
        assert!(written.contains("\n# the first\n[[runs]]\n"), "{written}");
        let short = Campaign { runs: vec![RunGroup::new(Torques::One(20.0))], ..Campaign::default() };
        let written = short.to_toml(&[]).unwrap();
        assert!(["start_time", "seed", "topics", "shuffle", "spin_up_nm"].iter().all(|key| !written.contains(key)), "{written}");
        assert_eq!(Campaign::from_toml(&written).unwrap(), short);
    }

    #[test]
    fn errors_are_reported() {
        let message = |text: &str| Campaign::from_toml(text).unwrap_err().to_string();
        assert_eq!(message(""), Error::NoRuns.to_string());
        assert_eq!(message("[[runs]]\ntorque_nm = 4\nhold_s = 0\n"), "runs entry 1: hold_s is 0; allowed: 0.02 to 600");
        assert!(message("[[runs]]\ntorque_nm = 4\nholds = 2\n").ends_with("did you mean `hold_s`?"));
        assert!(message("start_time = \"noon\"\n[[runs]]\ntorque_nm = 4\n").contains("noon"));
        assert!(message("[[runs]]\ntorque_nm = { start = 8, step = 4, stop = 4 }\n").contains("gives no level"));
        assert_eq!(message("[[runs]]\ntorque_nm = 4\nwheel_angle_deg = []\n"), "runs entry 1: wheel_angle_deg holds no angle");
        assert_eq!(
            message("[[runs]]\ntorque_nm = 4\nwheel_angle_deg = [0, 300]\n"),
            "runs entry 1: wheel_angle_deg is 300; allowed: -180 to 180"
        );
        assert!(message("[[runs]]\ntorque_nm = \"much\"\n").contains("expected a number, a list of numbers, or { start, step, stop }"));
        assert!(message("[[runs]]\ntorque_nm = 4\nevent = { kind = \"wet_path\" }\n").ends_with("did you mean `wet_patch`?"));
    }
}
