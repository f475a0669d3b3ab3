//! The signals of a recording as series, by what their messages mean.
//!
//! A measured signal has a value per reading; one that is repeated is left out. A held signal has a value at any time: one that is logged on
//! change, or once, is filled in.

use crate::log::{MessageKind, Recording, Signal, rate};
use crate::signal::held::{held_note, held_until};
use crate::signal::publishers::two_publishers;
use crate::signal::{Error, Result, Series, new_values_only};
use crate::units::NS_PER_S;

/// Smallest number of values of a measured signal.
pub(crate) const FEWEST: usize = 50;
/// Smallest number of commands that hold until the next one: a step, and the value before it.
const FEWEST_HELD: usize = 2;

/// The series taken from a recording, with notes on them.
pub(crate) struct TakenSignals<'a> {
    recording: &'a Recording,
    /// Time 0 of the series [ns].
    pub start_ns: i64,
    /// End of the speed [s].
    end_s: f64,
    pub notes: Vec<String>,
}

impl<'a> TakenSignals<'a> {
    /// From a recording.
    pub(crate) fn new(recording: &'a Recording) -> Self {
        let signals = &recording.signals;
        let optional = [&signals.torque_feedback, &signals.yaw_rate, &signals.gear, &signals.estop];
        let start_ns = [&signals.speed, &signals.torque, &signals.angle]
            .into_iter()
            .chain(optional.into_iter().flatten())
            .filter_map(|s| s.time_ns.first().copied())
            .min()
            .unwrap_or(0);
        let end_ns = signals.speed.time_ns.last().copied().unwrap_or(start_ns);
        let end_s = end_ns.saturating_sub(start_ns) as f64 / NS_PER_S;
        Self { recording, start_ns, end_s, notes: recording.clock_notes.clone() }
    }

    fn series(&self, signal: &Signal) -> Series {
        let t_s = signal.time_ns.iter().map(|t| t.saturating_sub(self.start_ns) as f64 / NS_PER_S).collect();
        Series { t_s, value: signal.value.clone() }
    }

    /// A signal whose values hold until the next message, if it is logged in this way.
    pub(crate) fn held(&mut self, name: &'static str, signal: &Signal) -> Series {
        let series = self.series(signal);
        self.filled(name, series)
    }

    fn filled(&mut self, name: &'static str, series: Series) -> Series {
        let kind = MessageKind::of(&series.t_s, &series.value);
        if series.is_empty() || !kind.is_held() {
            return series;
        }
        self.notes.extend(held_note(name, kind, &series));
        held_until(&series, self.end_s)
    }

    /// A signal with a new measurement for each value.
    pub(crate) fn measured(&mut self, name: &'static str, signal: &Signal) -> Series {
        let series = self.series(signal);
        if series.len() >= FEWEST && MessageKind::of(&series.t_s, &series.value) == MessageKind::OnChange {
            return self.filled(name, series);
        }
        match rate(signal) {
            Some(rate) if rate.repeats > 1 => {
                self.notes.push(format!(
                    "{name}: logged at {:.0} Hz, but new values come only at {:.1} Hz; repeated values are left out",
                    rate.logged_hz, rate.true_hz
                ));
                new_values_only(&series, rate.repeats)
            }
            _ => series,
        }
    }

    /// A measured signal that is not required, if it has enough values.
    pub(crate) fn optional(&mut self, name: &'static str, signal: Option<&Signal>) -> Option<Series> {
        let series = self.measured(name, signal?);
        let found = series.len();
        if found < FEWEST {
            self.notes.push(format!("{name} is not used: it has {found} usable values, at least {FEWEST} are needed"));
        }
        (found >= FEWEST).then_some(series)
    }

    /// Whether a held signal has enough values.
    ///
    /// # Errors
    /// It has too few.
    pub(crate) fn enough(&self, name: &'static str, signal: &Signal) -> Result<()> {
        let series = self.series(signal);
        let is_held = MessageKind::of(&series.t_s, &series.value).is_held();
        let needed = match (is_held, name) {
            (true, "torque") => FEWEST_HELD,
            (true, _) => 1,
            (false, _) => FEWEST,
        };
        if series.len() < needed { Err(Error::TooFew { signal: name, found: series.len(), needed }) } else { Ok(()) }
    }

    /// The torque command that the wheel follows.
    ///
    /// # Errors
    /// Too few values; two publishers.
    pub(crate) fn command(&mut self, feedback: Option<&Series>) -> Result<Series> {
        let signal = &self.recording.signals.torque;
        let mut series = self.series(signal);
        self.enough("torque", signal)?;
        if let Some(two) = two_publishers(&series) {
            series = two.followed(&series, feedback, &mut self.notes)?;
        }
        Ok(self.filled("torque", series))
    }
}
