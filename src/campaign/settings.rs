//! Criteria of a usable sample.

use serde::{Deserialize, Serialize};

/// Thresholds of the gates. The defaults suit any vehicle of the class; an ordinary log needs no other values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurveySettings {
    /// Largest deviation of the wheel from the test angle [°]. Default 2.5: an angle sensor's bias and noise stay below 1°, and 2.5° change
    /// the yaw rate of a pivot by 0.1 %.
    pub angle_tolerance_deg: f64,
    /// Steering speed above which the wheel counts as moving [°/s]. Default 5, several standard errors of a slope over 0.2 s of a signal
    /// with 0.15° noise.
    pub steering_rate_deg_s: f64,
    /// Time without a speed sample that splits a stretch [s]. Default 0.1; never less than four periods.
    pub gap_s: f64,
    /// Time without a torque command after which it is unknown, unless it is the same on both sides [s]. Default 0.1.
    pub command_gap_s: f64,
    /// Largest change of the command within one hold [N·m], as a share of the largest command. Default 0.01.
    pub hold_tolerance: f64,
    /// Threshold of slip: difference of encoder and yaw speed above this [m/s] plus `slip_ratio` times the speed. Default 0.04.
    pub slip_mps: f64,
    /// See `slip_mps`. Default 0.03: twice the slip of an ordinary tyre under load.
    pub slip_ratio: f64,
    /// Hampel filter: a sample is an outlier if its distance from the median of its seven neighbours exceeds this many scaled median
    /// absolute deviations. Default 6.
    pub hampel_mads: f64,
    /// Shortest usable stretch [s]. Default 0.2.
    pub shortest_stretch_s: f64,
    /// Below this speed a decelerating wheel counts as coming to rest [m/s]. Default 0.012.
    pub stopping_mps: f64,
}

impl Default for SurveySettings {
    fn default() -> Self {
        Self {
            angle_tolerance_deg: 2.5,
            steering_rate_deg_s: 5.0,
            gap_s: 0.1,
            command_gap_s: 0.1,
            hold_tolerance: 0.01,
            slip_mps: 0.04,
            slip_ratio: 0.03,
            hampel_mads: 6.0,
            shortest_stretch_s: 0.2,
            stopping_mps: 0.012,
        }
    }
}
