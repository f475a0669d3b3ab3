//! Combinations of the simulator's options, drawn from a seed: drive, limits, sensors, clocks, message habits and warming at once.

use super::vehicle_text::changed;

/// A vehicle file and a campaign with options drawn at random.
#[derive(Debug, Clone)]
pub(crate) struct FieldCase {
    /// The changed lines of the vehicle file, below their headings.
    pub(crate) changes: Vec<(&'static str, String)>,
    /// What stands before the runs of the campaign.
    pub(crate) topics: String,
}

/// SplitMix64: the same numbers on every machine. Source: Steele, Lea, Flood, OOPSLA 2014.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number between two others, with few digits.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        let value = low + (high - low) * self.next();
        (value * 1e3).round() / 1e3
    }

    fn one_in(&mut self, count: u32) -> bool {
        self.next() * f64::from(count) < 1.0
    }

    fn of(&mut self, count: u32) -> u32 {
        (self.next() * f64::from(count)) as u32
    }
}

impl FieldCase {
    /// The case of a seed. Left out: a dead band of the torque, which no log shows between two driven torques.
    pub(crate) fn new(seed: u64) -> Self {
        let mut draw = Draw(seed);
        let mut changes: Vec<(&'static str, String)> = Vec::new();
        let (mass, inertia) = (draw.between(150.0, 260.0), draw.between(65.0, 115.0));
        changes.push(("[motion]", format!("mass_kg = {mass}\nyaw_inertia_kgm2 = {inertia}")));
        let (dead, lag) = (draw.between(0.02, 0.09), draw.between(0.02, 0.09));
        changes.push(("[drive]", format!("dead_time_s = {dead}\nlag_s = {lag}")));
        match draw.of(4) {
            1 => changes.push(("[drive]", format!("slew_limit_nm_s = {}", draw.between(40.0, 150.0)))),
            2 => {
                let (rise, fall) = (draw.between(40.0, 120.0), draw.between(60.0, 240.0));
                changes.push(("[drive]", format!("slew_limit_nm_s = {rise}\nslew_fall_limit_nm_s = {fall}")));
            }
            3 => {
                let (frequency, damping) = (draw.between(3.0, 8.0), draw.between(0.2, 0.9));
                changes.push(("[drive]", format!("frequency_hz = {frequency}\ndamping = {damping}")));
            }
            _ => {}
        }
        match draw.of(6) {
            1 => changes.push(("[motion]", format!("power_limit_w = {}", draw.between(130.0, 260.0)))),
            2 => {
                let from = draw.between(0.5, 0.8);
                changes.push(("[motion]", format!("governor_mps = [{from:.3}, {:.3}]", from + 0.05)));
            }
            3 => changes.push(("[drive]", format!("torque_limit_nm = {}", draw.between(28.0, 38.0)))),
            _ => {}
        }
        if draw.one_in(3) {
            let (fall, time) = (draw.between(-0.1, 0.25), draw.between(80.0, 400.0));
            changes.push(("[motion]", format!("friction_fall = {fall}\nwarming_time_s = {time}")));
        }
        match draw.of(4) {
            1 => changes.push(("[sensors.encoder]", format!("counts_per_rev = {}", 200 + draw.of(800)))),
            2 => changes.push(("[sensors.encoder]", format!("counts_per_rev = 0\nstep_mps = {}", draw.between(0.005, 0.03)))),
            _ => {}
        }
        if draw.one_in(2) {
            let scale = if draw.one_in(2) { draw.between(0.8, 1.2) } else { 1.0 };
            let offset = if draw.one_in(2) { draw.between(-1.5, 1.5) } else { 0.0 };
            changes
                .push(("[sensors.torque_feedback]", format!("scale = {scale}\noffset_nm = {offset}\nshows_limits = {}", draw.one_in(2))));
        }
        let habit = |draw: &mut Draw| match draw.of(5) {
            1 => format!("burst_s = {}", draw.between(0.05, 0.12)),
            2 => format!("burst_s = {}, stamped_on_arrival = true", draw.between(0.05, 0.12)),
            3 => format!("stamp_step_s = {}", if draw.one_in(2) { 0.1 } else { 0.02 }),
            4 => format!("jitter_s = {}", draw.between(0.002, 0.015)),
            _ => "latency_s = 0.004".to_owned(),
        };
        let encoder = habit(&mut draw);
        changes.push(("[sensors.encoder]", format!("timing = {{ rate_hz = 50.0, {encoder} }}")));
        let gyro = habit(&mut draw);
        changes.push(("[sensors.gyro]", format!("timing = {{ rate_hz = 100.0, {gyro} }}")));
        let mut topics = String::new();
        if draw.one_in(3) {
            topics += "[topics]\ntorque_command_on_change = true\n";
        }
        let command = habit(&mut draw).replace(", ", "\n");
        topics.push_str("[topics.torque_command]\n");
        topics.push_str(&command);
        topics.push('\n');
        if draw.one_in(3) {
            topics.push_str("clock_offset_s = ");
            topics.push_str(&draw.between(-2.0, 2.0).to_string());
            topics.push('\n');
        }
        Self { changes, topics }
    }

    /// The case without the options whose lines name `option`.
    pub(crate) fn without(mut self, option: &str) -> Self {
        self.changes.retain(|(_, lines)| !lines.contains(option));
        self
    }

    /// The vehicle file.
    pub(crate) fn vehicle_text(&self, bundled: &str) -> String {
        let changes: Vec<(&str, &str)> = self.changes.iter().map(|(heading, lines)| (*heading, lines.as_str())).collect();
        changed(bundled, &changes)
    }

    /// The options in words, to be found again in a report.
    pub(crate) fn text(&self) -> String {
        let changes: Vec<String> = self.changes.iter().map(|(heading, lines)| format!("{heading} {}", lines.replace('\n', "; "))).collect();
        format!("{}\n{}", changes.join("\n"), self.topics.trim_end())
    }
}
