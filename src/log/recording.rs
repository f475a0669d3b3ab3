//! One log read whole: signals in SI, where they come from, and what was lost.

use crate::log::loss::Loss;
use crate::log::reference_path::ReferencePath;
use crate::log::signal_map::SignalName;
use crate::map::{LogRef, Vehicle};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// One log, its signals found, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// File name, hash and size.
    pub source: LogRef,
    /// Where the file lies.
    pub path: PathBuf,
    /// The vehicle that drove.
    pub vehicle: Vehicle,
    /// The signals.
    pub signals: Signals,
    /// Where each signal comes from.
    pub origins: Vec<Origin>,
    /// What was read and what was lost.
    pub loss: Loss,
    /// Remarks that the user should see.
    pub notes: Vec<String>,
}

/// The signals of a log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Signals {
    /// Speed of the front wheel's rim [m/s].
    pub speed: Signal,
    /// Torque as commanded [N·m].
    pub torque: Signal,
    /// Torque as the drive reports it [N·m].
    pub torque_feedback: Option<Signal>,
    /// Angle of the front wheel [rad], left positive.
    pub angle: Signal,
    /// Rate of the vehicle's heading [rad/s], left positive.
    pub yaw_rate: Option<Signal>,
    /// Gear: −1 reverse, 0 neutral, +1 forward.
    pub gear: Option<Signal>,
    /// Emergency stop: 1 active, 0 not.
    pub estop: Option<Signal>,
    /// Signals of the lateral calibration, by name, when those were read.
    pub lateral: BTreeMap<SignalName, Signal>,
    /// The reference as whole polylines, sorted by time, when it was named so; `lateral` then holds no reference point.
    pub reference_paths: Vec<ReferencePath>,
}

/// A time series: sorted by time, values finite. Equal times keep the order of the log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Signal {
    /// Time of each value [ns since the epoch of the stamps].
    pub time_ns: Vec<i64>,
    /// The values, in the signal's SI unit.
    pub value: Vec<f64>,
    /// Positive means in the gear's direction; the value is as logged.
    pub relative_to_gear: bool,
    /// A magnitude, as logged; its sign must come from other signals.
    pub unsigned: bool,
}

/// Where a signal comes from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Origin {
    /// Which signal.
    pub signal: SignalName,
    /// The message path.
    pub path: String,
    /// The unit that the log has it in.
    pub unit: String,
    /// Why this path.
    pub reason: String,
    /// Number of values.
    pub values: usize,
}

impl Signal {
    /// Number of values.
    pub fn len(&self) -> usize {
        self.time_ns.len()
    }

    /// Sorts by time; equal times keep their order.
    pub(crate) fn sort(&mut self) {
        if !self.time_ns.is_sorted() {
            let mut pairs: Vec<(i64, f64)> = self.time_ns.iter().copied().zip(self.value.iter().copied()).collect();
            pairs.sort_by_key(|(time_ns, _)| *time_ns);
            (self.time_ns, self.value) = pairs.into_iter().unzip();
        }
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.time_ns.is_empty()
    }
}

impl Signals {
    /// The signal of that name, if the log has it.
    pub fn get(&self, name: SignalName) -> Option<&Signal> {
        match name {
            SignalName::Speed => Some(&self.speed),
            SignalName::Torque => Some(&self.torque),
            SignalName::TorqueFeedback => self.torque_feedback.as_ref(),
            SignalName::Angle => Some(&self.angle),
            SignalName::YawRate => self.yaw_rate.as_ref(),
            SignalName::Gear => self.gear.as_ref(),
            SignalName::Estop => self.estop.as_ref(),
            lateral => self.lateral.get(&lateral),
        }
    }

    pub(crate) fn set(&mut self, name: SignalName, signal: Signal) {
        match name {
            SignalName::Speed => self.speed = signal,
            SignalName::Torque => self.torque = signal,
            SignalName::TorqueFeedback => self.torque_feedback = Some(signal),
            SignalName::Angle => self.angle = signal,
            SignalName::YawRate => self.yaw_rate = Some(signal),
            SignalName::Gear => self.gear = Some(signal),
            SignalName::Estop => self.estop = Some(signal),
            lateral => {
                self.lateral.insert(lateral, signal);
            }
        }
    }
}
