//! One complete log: signals in SI, their origin, and the lost data.

use crate::log::loss::Loss;
use crate::log::reference_path::ReferencePath;
use crate::log::signal_map::SignalName;
use crate::map::{LogRef, Vehicle};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// One log, with its signals in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// File name, hash and size.
    pub source: LogRef,
    /// Path of the file.
    pub path: PathBuf,
    /// The vehicle.
    pub vehicle: Vehicle,
    /// The signals.
    pub signals: Signals,
    /// Origin of each signal.
    pub origins: Vec<Origin>,
    /// The read and the lost data.
    pub loss: Loss,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// Notes on the clocks: what was corrected in the times of the signals.
    pub clock_notes: Vec<String>,
}

/// The signals of a log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Signals {
    /// Speed of the front wheel's rim [m/s].
    pub speed: Signal,
    /// Commanded torque [N·m].
    pub torque: Signal,
    /// Torque reported by the drive [N·m].
    pub torque_feedback: Option<Signal>,
    /// Angle of the front wheel [rad], left positive.
    pub angle: Signal,
    /// Rate of the vehicle's heading [rad/s], left positive.
    pub yaw_rate: Option<Signal>,
    /// Gear: −1 reverse, 0 neutral, +1 forward.
    pub gear: Option<Signal>,
    /// Emergency stop: 1 active, 0 not.
    pub estop: Option<Signal>,
    /// Signals of the lateral calibration, and the desired acceleration of pivots in operation, by name, if they were read.
    #[doc(hidden)]
    pub lateral: BTreeMap<SignalName, Signal>,
    /// The reference as complete polylines, sorted by time, if it was named as such; `lateral` then holds no reference point.
    #[doc(hidden)]
    pub reference_paths: Vec<ReferencePath>,
}

/// A time series: sorted by time, values finite. Equal times keep the order of the log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Signal {
    /// Time of each value [ns since the epoch of the stamps].
    pub time_ns: Vec<i64>,
    /// The values, in the signal's SI unit.
    pub value: Vec<f64>,
    /// Uncertainty of each time, apart from an offset of all of them [s]; 0 where the times are as logged.
    pub time_std_s: f64,
    /// Positive means in the gear's direction; the value is unchanged.
    pub relative_to_gear: bool,
    /// A magnitude, unchanged; its sign must come from other signals.
    pub unsigned: bool,
}

/// Origin of a signal.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Origin {
    /// The signal.
    pub signal: SignalName,
    /// The message path.
    pub path: String,
    /// Its unit in the log.
    pub unit: String,
    /// The reason for this path.
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

impl Recording {
    /// Number of values of all signals.
    pub(crate) fn values(&self) -> u64 {
        SignalName::ALL.iter().filter_map(|name| self.signals.get(*name)).map(|signal| signal.len() as u64).sum()
    }
}

impl Signals {
    /// The signal with that name, if the log has it.
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
