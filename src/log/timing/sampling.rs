//! When a periodic signal was sampled, where its times scatter or come in bursts.
//!
//! A sensor samples with the regularity of its own clock. A driver, a network or a recorder may pass on several readings at once, or stamp
//! them late. Times that scatter by more than some milliseconds are replaced: by the log's times if these are regular, otherwise by those of a
//! regular clock that fits them. Irregular times that the arrivals confirm are those of an irregular sensor, and are kept.

use crate::log::signal_map::SignalName;
use crate::log::timing::message_times::TimeSource;
use crate::log::timing::regular::{Bounds, RegularClock};
use crate::log::timing::rhythm::{Rhythm, TOGETHER, middle};
use crate::log::timing::stamp_clock::StampClock;

/// Largest scatter of the times of a regular signal [s].
const REGULAR_S: f64 = 0.004;
/// The log's times are used if they scatter by less than this share of the scatter of the signal's own.
const MORE_REGULAR: f64 = 0.4;
/// Longest period of a signal whose times are corrected [s].
const LONGEST_PERIOD_S: f64 = 0.25;
/// The times at which a signal was sampled.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Sampled {
    /// New times [s]; absent where they are not changed.
    pub time_s: Option<Vec<f64>>,
    /// Remaining uncertainty of each, apart from a common offset [s].
    pub std_s: f64,
    pub note: Option<String>,
}

/// The sampling times of a signal from its stamps, if it has some, and the log's times [s].
pub(crate) fn sampled(signal: SignalName, stamped_s: Option<&[f64]>, log_s: &[f64], clock: &StampClock) -> Sampled {
    let is_measured = matches!(signal, SignalName::Speed | SignalName::YawRate | SignalName::Torque | SignalName::TorqueFeedback);
    let time_s = stamped_s.unwrap_or(log_s);
    let Some(rhythm) = Rhythm::of(time_s).filter(|r| is_measured && r.period_s < LONGEST_PERIOD_S && r.scatter_s > REGULAR_S) else {
        return Sampled::default();
    };
    let name = clock.source.name();
    if let Some(stamped_s) = stamped_s {
        let logged = Rhythm::of(log_s);
        if let Some(logged) = logged.filter(|l| l.scatter_s < MORE_REGULAR * rhythm.scatter_s && !l.comes_in_bursts) {
            let usual_s = || middle(stamped_s.iter().zip(log_s).map(|(t, l)| t - l).collect()).unwrap_or(0.0);
            // rounded stamps are early, and one stamp for several messages late, by up to a step
            let delay_s = if rhythm.comes_in_bursts { 0.0 } else { usual_s() };
            return Sampled {
                time_s: Some(log_s.iter().map(|t| t + delay_s).collect()),
                std_s: logged.scatter_s,
                note: Some(format!(
                    "{name} of {signal}: they scatter by {:.1} ms about a period of {:.1} ms, the log's times by {:.1} ms: the log's times are used",
                    1e3 * rhythm.scatter_s,
                    1e3 * rhythm.period_s,
                    1e3 * logged.scatter_s
                )),
            };
        }
        let delays: Vec<f64> = stamped_s.iter().zip(log_s).map(|(t, l)| l - t).collect();
        let usual_s = middle(delays.clone()).unwrap_or(0.0);
        let spread_s = 1.4826 * middle(delays.iter().map(|d| (d - usual_s).abs()).collect()).unwrap_or(0.0);
        let is_confirmed = clock.source == TimeSource::Stamp && spread_s < 0.5 * rhythm.scatter_s && delays.iter().any(|d| *d != delays[0]);
        if is_confirmed && !rhythm.comes_in_bursts {
            return Sampled::default();
        }
    }
    let bounds = if rhythm.comes_in_bursts { Bounds::of_bursts(time_s, TOGETHER * rhythm.period_s) } else { Bounds::exact(time_s) };
    let Some(found) = RegularClock::fit(&bounds, &rhythm, clock.source != TimeSource::Stamp && rhythm.comes_in_bursts) else {
        return Sampled::default();
    };
    let how = if rhythm.comes_in_bursts {
        let (least, most) = bounds.burst_lengths();
        format!("the messages come in bursts of {least} to {most}")
    } else {
        format!("they scatter by {:.1} ms", 1e3 * rhythm.scatter_s)
    };
    let lost = if found.lost > 0 { format!(", {} of them lost", found.lost) } else { String::new() };
    Sampled {
        note: Some(format!(
            "{name} of {signal}: {how}: the times of a regular clock are used, one every {:.2} ms{lost}",
            1e3 * found.period_s
        )),
        std_s: found.std_s,
        time_s: Some(found.time_s),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::log::timing::message_times::{MessageTimes, SignalTimes};

    /// What becomes of messages every 20 ms by their errors of stamp and arrival [ms], for a number between −1 and 1.
    fn found(errors_ms: impl Fn(f64) -> (f64, f64)) -> Sampled {
        let times: Vec<MessageTimes> = (1..2000u32)
            .map(|k| {
                let (stamp_ms, log_ms) = errors_ms(f64::from((k * 7919 + k * k * 31) % 2003) / 1001.0 - 1.0);
                let at = |error_ms: f64| ((20.0 * f64::from(k) + error_ms) * 1e6) as i64;
                MessageTimes { stamp_ns: at(stamp_ms), publish_ns: 0, log_ns: at(log_ms) }
            })
            .collect();
        let log_s: Vec<f64> = times.iter().map(|t| t.log_ns as f64 * 1e-9).collect();
        let signal = SignalTimes { signal: SignalName::Speed, times: &times };
        let clock = StampClock::of(&signal, &log_s, 0, &[]);
        sampled(SignalName::Speed, clock.time_s.as_deref(), &log_s, &clock)
    }

    #[test]
    fn the_more_regular_times_are_used_and_confirmed_ones_stay() {
        assert_eq!(found(|x| (2.0 * x, 3.0)), Sampled::default());
        assert!(found(|x| (15.0 * x, 25.0 + 0.5 * x)).note.unwrap().contains("the log's times are used"));
        // an irregular sensor: its stamps and arrivals agree
        assert_eq!(found(|x| (15.0 * x, 15.0 * x + 1.0 + 0.2 * x)), Sampled::default());
        let both = found(|x| (15.0 * x, 40.0 - 12.0 * x));
        assert!(both.note.unwrap().contains("regular clock") && both.std_s < 0.002);
    }
}
