//! The drive that a fit found between commanded and effective torque, what it does not deliver, and what changed during the campaign.

use serde::{Deserialize, Serialize};

/// Families of drives between the torque command and the torque at the wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DriveFamily {
    /// A first-order lag.
    FirstOrder,
    /// A rate limit, with one slope or with two, and a lag behind it.
    RateLimit,
    /// A second-order lag, which may oscillate.
    SecondOrder,
    /// Whatever the drive is: the torque feedback is the torque.
    Feedback,
}

/// What a limit bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LimitKind {
    /// The torque [N·m], in either direction.
    Torque,
    /// The driving torque times the wheel's speed [N·m·m/s].
    Power,
    /// The speed [m/s]: a governor.
    Speed,
}

/// A limit of the torque that is delivered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DriveLimit {
    /// What it bounds.
    pub kind: LimitKind,
    /// The bound, in the unit of its kind.
    pub value: f64,
    /// Its standard error; absent where the limit was found by the torque feedback, or by the growth of acceleration with torque.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub std_err: Option<f64>,
}

/// Nothing drives faster than this multiple of a limit of the speed.
const FASTEST: f64 = 1.1;

impl DriveLimit {
    /// Whether a limit of the speed leaves no driving torque at a speed.
    pub fn governs(&self, speed_mps: f64) -> bool {
        self.kind == LimitKind::Speed && speed_mps > FASTEST * self.value
    }

    /// The largest driving torque that is delivered at a speed [N·m]; without end below a limit of the speed.
    pub fn most_nm(&self, speed_mps: f64) -> f64 {
        match self.kind {
            LimitKind::Torque => self.value,
            LimitKind::Power => self.value / speed_mps.max(1e-6),
            LimitKind::Speed => f64::INFINITY,
        }
    }
}

/// Another drive that was fitted to the same data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ComparedDrive {
    /// In words, with its parameters.
    pub drive: String,
    /// By how much worse it predicts runs that were left out (−2·ln L).
    pub worse: f64,
    /// Standard error of that over the runs.
    pub std_err: f64,
}

/// Changes over the campaign, or over each log, before which the vehicle may have cooled down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CampaignChange {
    /// Whether it restarts with each log.
    pub of_each_log: bool,
    /// Relative change of friction over half of it; 0 where none is clear.
    pub friction_share: f64,
    /// Its standard error.
    pub friction_share_std_err: f64,
    /// Relative change of the torque under the same command over half of it; 0 where none is clear.
    pub torque_share: f64,
    /// Its standard error.
    pub torque_share_std_err: f64,
}

/// The drive beyond its dead time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IdentifiedDrive {
    /// Its family.
    pub family: DriveFamily,
    /// The lag, alone or behind a rate limit [s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub lag_s: Option<f64>,
    /// Largest rise and largest fall of the torque [N·m/s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub slopes_nm_s: Option<[f64; 2]>,
    /// Whether the first slope is that of a torque whose magnitude grows, the second of one whose magnitude falls. Otherwise up and down.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub slopes_by_magnitude: bool,
    /// Natural frequency of a second-order lag [Hz].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub frequency_hz: Option<f64>,
    /// Damping of a second-order lag, 1 where it is critical.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub damping: Option<f64>,
    /// What it does not deliver.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub limit: Option<DriveLimit>,
    /// Time for which torque that was asked for was not delivered, by the torque feedback [s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub undelivered_s: Option<f64>,
    /// Share of the commanded torque that was delivered then, where it is the same at different torques: another scale, and not a limit.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub undelivered_share: Option<f64>,
    /// Time for which the feedback shows more torque than was asked for [s]: the log does not hold the command that the drive had.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub exceeded_s: Option<f64>,
    /// A drive that the data prefer by far to the one that was given.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub better_than_given: Option<ComparedDrive>,
    /// Other drives that were fitted, each worse.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub compared: Vec<ComparedDrive>,
}

impl IdentifiedDrive {
    /// In words, without limits.
    fn text(&self) -> String {
        match (self.family, self.slopes_nm_s, self.frequency_hz.zip(self.damping)) {
            (DriveFamily::RateLimit, Some([a, b]), _) if a == b => format!("rate limit of {a:.0} N·m/s"),
            (DriveFamily::RateLimit, Some([a, b]), _) if self.slopes_by_magnitude => {
                format!("rate limits of {a:.0} N·m/s growing and {b:.0} N·m/s falling")
            }
            (DriveFamily::RateLimit, Some([a, b]), _) => format!("rate limits of {a:.0} N·m/s up and {b:.0} N·m/s down"),
            (_, _, Some((hz, damping))) => format!("second-order lag of {hz:.2} Hz with damping {damping:.2}"),
            (DriveFamily::Feedback, _, _) => "as the torque feedback shows it".to_owned(),
            _ => "first-order lag".to_owned(),
        }
    }

    /// Label and text of each thing worth a line.
    pub(crate) fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = vec![("drive", self.text())];
        if let Some(limit) = self.limit {
            let unit = match limit.kind {
                LimitKind::Torque => "N·m",
                LimitKind::Power => "N·m·m/s (torque times speed)",
                LimitKind::Speed => "m/s (a governor)",
            };
            let error = limit.std_err.map_or(String::new(), |e| format!(" ± {e:.2}"));
            lines.push(("limit", format!("{:.2}{error} {unit}", limit.value)));
        }
        if let Some(seconds) = self.undelivered_s {
            lines.push(("", format!("the commanded torque is not delivered for {seconds:.1} s")));
        }
        lines
    }
}

impl CampaignChange {
    /// The changes from the beginning to the end, in words.
    pub(crate) fn lines(&self) -> Vec<(&'static str, String)> {
        let of = if self.of_each_log { "each log" } else { "the campaign" };
        let mut lines = Vec::new();
        if self.friction_share != 0.0 {
            let (value, error) = (200.0 * self.friction_share, 200.0 * self.friction_share_std_err);
            lines.push(("drift", format!("over {of}, friction changes by {value:+.1} ± {error:.1} %")));
        }
        if self.torque_share != 0.0 {
            let (value, error) = (200.0 * self.torque_share, 200.0 * self.torque_share_std_err);
            lines.push(("drift", format!("over {of}, the torque under the same command changes by {value:+.1} ± {error:.1} %")));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_of_power_falls_with_speed_and_every_drive_has_its_words() {
        let limit = DriveLimit { kind: LimitKind::Power, value: 15.0, std_err: Some(0.1) };
        assert_eq!(limit.most_nm(0.5), 30.0);
        assert!(DriveLimit { kind: LimitKind::Speed, ..limit }.most_nm(0.6).is_infinite());
        let plain = IdentifiedDrive {
            family: DriveFamily::FirstOrder,
            lag_s: Some(0.05),
            slopes_nm_s: None,
            slopes_by_magnitude: false,
            frequency_hz: None,
            damping: None,
            limit: Some(limit),
            undelivered_s: None,
            undelivered_share: None,
            exceeded_s: None,
            better_than_given: None,
            compared: Vec::new(),
        };
        let text = |drive: &IdentifiedDrive| drive.lines().into_iter().map(|l| l.1).collect::<Vec<_>>().join("; ");
        assert_eq!(text(&plain), "first-order lag; 15.00 ± 0.10 N·m·m/s (torque times speed)");
        let slow = IdentifiedDrive { family: DriveFamily::RateLimit, slopes_nm_s: Some([60.0, 60.0]), limit: None, ..plain };
        assert_eq!(text(&slow), "rate limit of 60 N·m/s");
    }
}
