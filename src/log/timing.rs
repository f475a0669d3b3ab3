//! When each value was true.
//!
//! In: up to three times per message, as the log holds them: the stamp inside the message, the time of publication, and the time of the log.
//! Out: one time per value, on one clock for all signals of the recording, and notes on what was corrected.
//!
//! The recorder's clock is the common one. If it was set back while recording, later times are moved forward (`log_clock`). A stamp comes
//! from a separate clock: it may be set, stand still, drift, or be an hour away. A message never arrives before it was sent, so the
//! earliest arrivals give the offset of that clock and its drift (`stamp_clock`, `clock_offset`). Where times scatter or come in bursts,
//! and the signal is periodic, the true times are those of a regular clock (`regular`, `sampling`). Times without such a fault are not
//! changed.

pub(crate) mod clock_offset;
pub(crate) mod log_clock;
pub(crate) mod message_times;
pub(crate) mod regular;
pub(crate) mod rhythm;
pub(crate) mod sampling;
pub(crate) mod stamp_clock;

use crate::log::timing::clock_offset::one_clock;
use crate::log::timing::log_clock::{ClockStep, unfold};
use crate::log::timing::message_times::{FEWEST, SignalTimes, TimeSource, to_ns, usual};
use crate::log::timing::sampling::sampled;
use crate::log::timing::stamp_clock::StampClock;

/// The times of one signal's values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TrueTimes {
    /// One per value, in the order of the log [ns].
    pub time_ns: Vec<i64>,
    /// Remaining uncertainty of each time, apart from an offset of all of them [s].
    pub std_s: f64,
}

/// The true times of each of `signals`; `steps` are those at which the log's time goes back. The notes are for the user.
pub(crate) fn true_times(signals: &[SignalTimes<'_>], steps: &[ClockStep]) -> (Vec<TrueTimes>, Vec<String>) {
    let mut notes = Vec::new();
    let base_ns = signals.iter().filter_map(|s| s.times.first()).map(|t| t.log_ns).min().unwrap_or(0);
    let logged = unfold(signals, steps, base_ns, &mut notes);
    let clocks: Vec<StampClock> =
        signals.iter().zip(&logged.time_s).map(|(s, log_s)| StampClock::of(s, log_s, base_ns, &logged.set_back_s)).collect();
    let shifts_s = one_clock(signals, &clocks, &mut notes);
    let mut found = Vec::new();
    for (((signal, log_s), clock), shift_s) in signals.iter().zip(&logged.time_s).zip(&clocks).zip(shifts_s) {
        notes.extend(clock.note(signal.signal));
        let as_logged = || TrueTimes { time_ns: signal.times.iter().map(usual).collect(), std_s: 0.0 };
        if signal.times.len() < FEWEST && !clock.is_corrected() && shift_s == 0.0 && logged.set_back_s.is_empty() {
            found.push(as_logged());
            continue;
        }
        let stamped_s: Option<Vec<f64>> = clock.time_s.as_ref().map(|t| t.iter().map(|t| t + shift_s).collect());
        let is_as_logged = !clock.is_corrected() && shift_s == 0.0 && (clock.source != TimeSource::Log || logged.set_back_s.is_empty());
        let sampled = sampled(signal.signal, stamped_s.as_deref(), log_s, clock);
        notes.extend(sampled.note);
        found.push(match sampled.time_s {
            None if is_as_logged => as_logged(),
            new => {
                let time_s = new.or(stamped_s).unwrap_or_else(|| log_s.clone());
                TrueTimes { time_ns: time_s.iter().map(|t| to_ns(*t, base_ns)).collect(), std_s: sampled.std_s }
            }
        });
    }
    (found, notes)
}
